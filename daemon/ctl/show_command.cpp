// show: what a run was, on a page.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_summary.hpp"
#include "daemon/ctl/terminal.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

constexpr std::size_t kPage = 80;     // columns of the page where there is no terminal, and the fewest
constexpr std::size_t kWidest = 120;  // longer lines read badly

}  // namespace

int show_run(const std::string& file, bool json) {
  const auto run = read_summary(file);
  if (!run) {
    tell_error(run.error());
    return kUsage;
  }
  const auto print = [](const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); };
  if (json) {
    write_summary_json(*run, print);
  } else {
    print(
        summary_page(*run, isatty(STDOUT_FILENO) == 1 ? std::clamp(Terminal::size().columns, kPage, kWidest) : kPage));
  }
  for (const std::string& why : run->unreadable) tell_error(why);
  return run->unreadable.empty() ? kDone : kUsage;
}

}  // namespace dwell::ctl
