// What a live stream is told of the current dwell: the whole object once a second and whenever more than values
// changed, in between only what moved. At 30 elements the whole is half a megabyte, nearly all of it covariance and
// budgets; ten of these a second are more than many a network carries. Bound to one thread; allocates.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/report/dwell_view.hpp"

namespace dwell {

class DwellStream {
 public:
  // The whole object comes after so long at the latest. Longer: a reader that lost an event shows old covariances and
  // budgets for longer; shorter: more bytes, for what changes little.
  static constexpr std::int64_t kWholeEvery_ns = 1'000'000'000;

  struct Event {
    const char* name;  // "dwell" or "change"
    std::string data;  // one line
  };

  DwellStream();
  ~DwellStream();
  DwellStream(const DwellStream&) = delete;
  DwellStream& operator=(const DwellStream&) = delete;

  // The next event, which tells of `view`. t_ns: when the view was published; if it is told again, now.
  [[nodiscard]] Event next(const DwellView& view, std::int64_t t_ns);
  // Somebody joins who has been given the whole object from elsewhere, perhaps a newer one: the next event is whole.
  void joined() noexcept;

 private:
  struct Told;
  std::unique_ptr<Told> told_;  // null: nothing that a change could start from
};

}  // namespace dwell
