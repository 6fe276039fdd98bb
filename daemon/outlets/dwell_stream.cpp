#include "daemon/outlets/dwell_stream.hpp"

#include "daemon/report/dwell_change.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell {

struct DwellStream::Told {
  Json dwell;  // as it was told last, without what changes leave out
  std::int64_t whole_ns = 0;
};

DwellStream::DwellStream() = default;
DwellStream::~DwellStream() = default;

void DwellStream::joined() noexcept { told_.reset(); }

DwellStream::Event DwellStream::next(const DwellView& view, std::int64_t t_ns) {
  Json now = json_value(view, Detail::moving);
  if (told_ && t_ns - told_->whole_ns < kWholeEvery_ns) {
    if (const auto change = change_between(told_->dwell, now)) {
      told_->dwell = std::move(now);
      return {"change", dump(*change)};
    }
  }
  told_ = std::make_unique<Told>(Told{std::move(now), t_ns});
  return {"dwell", to_json(view)};
}

}  // namespace dwell
