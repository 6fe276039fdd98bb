#include "drivers/can/decoder.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace dwell::can {
namespace {

constexpr canid_t kSource = 0xFFU;

bool within(std::uint64_t value, const Condition& condition) noexcept {
  return std::any_of(condition.ranges.begin(), condition.ranges.end(),
                     [value](const auto& range) { return value >= range.first && value <= range.second; });
}

// SAE J1939-71: of a number of a byte or more, the uppermost byte FE says error and FF not available.
bool is_j1939_code(std::uint64_t bits, const Field& field) noexcept {
  return field.form == Form::unsigned_integer && field.length >= 8 && bits >> (field.length - 8U) >= 0xFEU;
}

}  // namespace

can_filter filter_of(const Match& match) noexcept {
  if (!match.extended) return {match.id & CAN_SFF_MASK, CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
  if (!match.j1939) return {(match.id & CAN_EFF_MASK) | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG};
  const std::uint32_t group = group_of(match.id);
  const bool broadcast = (group & 0xFF00U) >= 0xF000U;
  canid_t mask = (broadcast ? 0x3FFFF00U : 0x3FF0000U) | CAN_EFF_FLAG | CAN_RTR_FLAG;
  canid_t id = group << 8U | CAN_EFF_FLAG;
  if (match.source >= 0) {
    mask |= kSource;
    id |= static_cast<canid_t>(match.source) & kSource;
  }
  return {id, mask};
}

Decoder::Decoder(std::vector<Wanted> wanted) : wanted_(std::move(wanted)), order_(wanted_.size()) {
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  const auto key = [this](std::size_t index) {
    const can_filter filter = filter_of(wanted_[index].match);
    return std::tuple(filter.can_mask, filter.can_id, index);
  };
  std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const can_filter filter = filter_of(wanted_[order_[i]].match);
    if (keys_.empty() || keys_.back().back().mask != filter.can_mask) keys_.emplace_back();
    if (keys_.back().empty() || keys_.back().back().id != filter.can_id)
      keys_.back().push_back({filter.can_id, filter.can_mask, i, 0});
    ++keys_.back().back().count;
  }
  readings_.reserve(order_.size());
}

std::vector<can_filter> Decoder::filters() const {
  std::vector<can_filter> filters;
  for (const auto& keys : keys_)
    for (const Key& key : keys) filters.push_back({key.id, key.mask});
  return filters;
}

std::span<const Reading> Decoder::decode(const canfd_frame& frame) noexcept {
  readings_.clear();
  const std::size_t size = std::min<std::size_t>(frame.len, kMostBytes);
  for (const std::vector<Key>& keys : keys_) {
    const canid_t id = frame.can_id & keys.front().mask;
    const auto key =
        std::lower_bound(keys.begin(), keys.end(), id, [](const Key& each, canid_t value) { return each.id < value; });
    if (key == keys.end() || key->id != id) continue;
    for (std::size_t i = key->first; i < key->first + key->count; ++i)
      readings_.push_back(read(order_[i], frame.data, size));
  }
  return readings_;
}

Reading Decoder::read(std::size_t index, const std::uint8_t* data, std::size_t size) const noexcept {
  const Wanted& wanted = wanted_[index];
  for (const Condition& condition : wanted.conditions) {
    if (bytes_of(condition.selector) > size) return {index, Verdict::short_frame, 0.0};
    if (!within(bits_of(data, condition.selector), condition)) return {index, Verdict::absent, 0.0};
  }
  if (bytes_of(wanted.field) > size) return {index, Verdict::short_frame, 0.0};
  const std::uint64_t bits = bits_of(data, wanted.field);
  if (wanted.match.j1939 && is_j1939_code(bits, wanted.field)) return {index, Verdict::invalid, 0.0};
  const double value = wanted.factor * number_of(bits, wanted.field) + wanted.offset;
  return std::isfinite(value) ? Reading{index, Verdict::value, value} : Reading{index, Verdict::invalid, 0.0};
}

}  // namespace dwell::can
