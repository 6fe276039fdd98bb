// Does something in a child process, for what must not happen to this one.
#pragma once

#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>
#include <string>

namespace dwell::record {

// Ends the child as SIGKILL would, but with exit code 0: at once, whatever its threads are doing, and without a word of
// a sanitizer, which takes _exit() for an orderly end.
[[noreturn]] inline void vanish() {
  syscall(SYS_exit_group, 0);
  __builtin_unreachable();
}

// What `task` returned in the child; if the child crashed or exited with another code than 0, that is added.
inline std::string in_child(const std::function<std::string()>& task) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    const std::string said = task();
    [[maybe_unused]] const auto written = write(ends[1], said.data(), said.size());
    _exit(0);
  }
  close(ends[1]);
  std::string said;
  char part[4096];
  for (ssize_t count = 0; (count = read(ends[0], part, sizeof part)) > 0;)
    said.append(part, static_cast<std::size_t>(count));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) said += " (the child crashed or failed)";
  return said;
}

}  // namespace dwell::record
