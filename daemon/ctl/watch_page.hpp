// The screen of watch, as lines: drawn from the state, the size and the time alone. It fits what an operator needs
// first on the first page and turns pages for the rest; nothing is left out.
//
//   three masses                                          age 0.1 s · 14:03:22
//   dwell 1 · measuring, 24.6 s of data · model adequate · 2 warnings, page 2
//   run 17, “rubber 3” · 4.000300 ± 0.000039 Hz · since 14:02:58 (24 s)
//   (what is wrong: no connection, old numbers, paused; that the dwell has ended; alarms that nobody has acknowledged)
//
//   (doubts, coefficients, their trend, their deviation from the dwell before, limits, warnings, settling, channels:
//   dwell_sections(); then the alarms)
//
//   space pause  n b page 1 of 2  r rearm  q quit
//
// Pure but for the time zone; bound to one thread, not real-time.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/watch_state.hpp"
#include "daemon/report/dwell_text.hpp"

namespace dwell::ctl {

struct Size {
  std::size_t rows = 24;
  std::size_t columns = 80;
};

// What the operator has asked of the screen.
struct Controls {
  std::optional<double> paused_s;  // since when the numbers stand still
  std::size_t page = 0;            // 0 …; beyond the last one: the last one
  bool keys = true;                // false: no key can be read
  bool may_rearm = false;
  std::string question;  // in place of the keys, to be answered by y or n
  std::string message;   // what came of the last key
};

struct Page {
  std::vector<TextLine> lines;  // at most Size::rows, none longer than Size::columns
  std::size_t page = 0;         // 0 …
  std::size_t pages = 1;
};

// truth may be null. now_s: of the state's clock; clock: the time of day as text.
[[nodiscard]] Page draw(const WatchState& state, const Controls& controls, const Truth* truth, Size size, double now_s,
                        const std::string& clock);

// Why the dwell in view ended, and why it is still in view: "the run was stopped: the next one begins …".
[[nodiscard]] std::string why_ended(const Dwell& dwell);

// What is left on the operator's own screen at the end: everything, without pages, old numbers marked as well.
[[nodiscard]] std::string last_words(const WatchState& state, const Truth* truth, double now_s);

}  // namespace dwell::ctl
