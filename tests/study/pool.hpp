// All cores at once over numbered, independent work.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

namespace dwell::study {

// work(0) … work(count - 1), in no order, on all cores; a line about how far it is where stderr is a terminal.
template <typename Work>
void for_all(int count, const char* what, const Work& work) {
  std::atomic<int> next{0};
  const bool terminal = isatty(STDERR_FILENO) != 0;
  const auto run = [&](bool tells) {
    for (int i; (i = next.fetch_add(1)) < count;) {
      work(i);
      if (tells) std::fprintf(stderr, "\r%-16s %d of %d ", what, std::min(i + 1, count), count);
    }
  };
  std::vector<std::thread> threads;
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  for (unsigned k = 1; k < cores; ++k) threads.emplace_back(run, false);
  run(terminal);
  for (std::thread& thread : threads) thread.join();
  if (terminal) std::fprintf(stderr, "\r%40s\r", "");
}

}  // namespace dwell::study
