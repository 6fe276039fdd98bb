// Operators' starts that are answered once it is known whether their run is recorded: its record comes to the recorder
// through the stream, and only then its file is begun.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "daemon/record/recorder.hpp"

namespace dwell {

struct StartOutcome {
  // unknown: the recorder did not get so far in time, or the run was over before anybody looked.
  enum class Is : std::uint8_t { recorded, not_recorded, unknown } is = Is::unknown;
  std::string why;  // of not_recorded
};

// Bound to one thread. Instants: CLOCK_MONOTONIC_RAW.
class AwaitedStarts {
 public:
  // The longest wait for the recorder; usual are some tenths of a second. Shorter: a slow disk's runs are not known.
  // Longer: dwellctl, which gives up after 10 s, is not answered.
  static constexpr std::int64_t kPatience_ns = 5'000'000'000;
  explicit AwaitedStarts(std::int64_t patience_ns = kPatience_ns) : patience_ns_(patience_ns) {}

  // number: of the request. tell: called once by look().
  void add(std::uint16_t number, std::int64_t now_ns, std::function<void(const StartOutcome&)> tell);
  // Call it regularly.
  void look(const record::RecorderState& recorder, std::int64_t now_ns);

 private:
  struct Awaited {
    std::uint16_t number;
    std::int64_t until_ns;
    std::function<void(const StartOutcome&)> tell;
  };
  const std::int64_t patience_ns_;
  std::vector<Awaited> awaited_;  // in the order of the requests
};

}  // namespace dwell
