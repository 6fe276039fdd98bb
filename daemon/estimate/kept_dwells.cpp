#include "daemon/estimate/kept_dwells.hpp"

#include <utility>

namespace dwell {
namespace {

std::size_t bytes_of(const std::string& text) { return text.capacity(); }

template <class T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.capacity() * sizeof(T);
}

}  // namespace

std::size_t bytes_of(const Dwell& dwell) noexcept {
  std::size_t bytes = sizeof dwell + bytes_of(dwell.settling_reason) + bytes_of(dwell.phasors) +
                      bytes_of(dwell.elements) + bytes_of(dwell.covariance) + bytes_of(dwell.warnings) +
                      bytes_of(dwell.doubts) + bytes_of(dwell.unstated);
  for (const ChannelPhasor& phasor : dwell.phasors) bytes += bytes_of(phasor.harmonics) + bytes_of(phasor.reason);
  for (const ElementEstimate& element : dwell.elements) {
    bytes += bytes_of(element.reason) + bytes_of(element.budget);
    for (const BudgetShare& share : element.budget) bytes += bytes_of(share.source) + bytes_of(share.channel);
  }
  for (const Warning& warning : dwell.warnings) bytes += bytes_of(warning.what);
  for (const Doubt& doubt : dwell.doubts) bytes += bytes_of(doubt.elements) + bytes_of(doubt.what);
  for (const std::string& uncertainty : dwell.unstated) bytes += bytes_of(uncertainty);
  return bytes;
}

void KeptDwells::push(Dwell dwell) {
  auto kept = std::make_shared<FinishedDwells>(*list_);
  bytes_ += bytes_of(dwell);
  kept->push_back(std::make_shared<const Dwell>(std::move(dwell)));
  // What was counted for a dwell when it came is what it frees: it has not changed since.
  std::size_t gone = 0;
  while (kept->size() - gone > 1 && (kept->size() - gone > most_ || bytes_ > most_bytes_))
    bytes_ -= bytes_of(*(*kept)[gone++]);
  kept->erase(kept->begin(), kept->begin() + static_cast<std::ptrdiff_t>(gone));
  forgotten_ += gone;
  list_ = std::move(kept);
}

}  // namespace dwell
