// The recording of a case: what each channel's sample i reads and how it is stamped, any of them at any time, and all
// of them as the one ordered stream of records.
#pragma once

#include <cstdint>
#include <vector>

#include "core/stream/record.hpp"
#include "tests/study/case.hpp"

namespace dwell::study {

// True instant of channel c's sample i.
[[nodiscard]] double instant_s(const Case& about, int c, std::int64_t i);
// What it reads at its true instant.
[[nodiscard]] double reading(const Case& about, int c, std::int64_t i, double t_s);
// The stamp that a true instant gets, and the true instant of a stamp (of a device without turnaround).
[[nodiscard]] double stamp_s(const Case& about, int c, double t_s);
[[nodiscard]] double true_s(const Case& about, double stamp_s);

// The stream, endless. The case must outlive it. Bound to one thread.
class Player {
 public:
  explicit Player(const Case& about);
  // The next record, in order of the stamps.
  Record next();
  // Of the record just given.
  [[nodiscard]] double now_s() const { return now_s_; }

 private:
  void prepare(int c);
  const Case& about_;
  struct Due {
    std::int64_t i, t_ns, after;  // after: the sample before that was not lost
    double t_s;
  };
  std::vector<Due> due_;
  double now_s_ = 0.0;
};

}  // namespace dwell::study
