#include "core/fit/moment_sets.hpp"

#include <algorithm>

namespace dwell {

MomentSets::MomentSets(std::size_t slots, int channels, int harmonics)
    : channels_(channels), instants_count_(2 * harmonics + 1), readings_count_(harmonics + 1) {
  const std::size_t sets = slots * static_cast<std::size_t>(channels);
  instants_.resize(sets * moments::size(instants_count_));
  readings_.resize(sets * moments::size(readings_count_));
  owners_.resize(sets);
}

void MomentSets::clear(std::size_t slot) noexcept {
  std::fill_n(readings(slot, 0), moments::size(readings_count_) * static_cast<std::size_t>(channels_), 0.0);
  for (int c = 0; c < channels_; ++c) share(slot, c, c);
}

void MomentSets::clear_instants(std::size_t slot, int c) noexcept {
  std::fill_n(instants(slot, c), moments::size(instants_count_), 0.0);
}

void MomentSets::join(const Part& older, const Part& newer, std::size_t into) noexcept {
  clear(into);
  for (int c = 0; c < channels_; ++c)
    if (owner(older.slot, c) == owner(newer.slot, c)) share(into, c, owner(older.slot, c));
  for (int c = 0; c < channels_; ++c)
    if (owner(into, c) == c) clear_instants(into, c);
  for (const Part* part : {&older, &newer})
    for (int c = 0; c < channels_; ++c) {
      const double* set = shared_instants(part->slot, c);
      if (owner(into, c) == c) moments::add_instants(set, instants_count_, part->turn, instants(into, c));
      moments::add_readings(readings(part->slot, c), readings_count_, part->turn,
                            moments::mean_square_u(set, instants_count_), readings(into, c));
    }
}

}  // namespace dwell
