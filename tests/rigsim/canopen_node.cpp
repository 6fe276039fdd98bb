#include "tests/rigsim/canopen_node.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace rigsim {
namespace {

constexpr double kMetresPerUnit = 1e-9;
constexpr std::uint32_t kNotValid = 1U << 31U, kFrameBits = (1U << 30U) - 1;
constexpr unsigned kPdos = 2;

constexpr std::uint32_t kReadOnly = 0x06010002, kNoObject = 0x06020000, kWrongLength = 0x06070010,
                        kNoEntry = 0x06090011, kWrongValue = 0x06090030, kNotNow = 0x08000022,
                        kUnknownCommand = 0x05040001, kToggleError = 0x05030000;

std::uint32_t little_endian(const std::uint8_t* bytes, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t i = std::min<std::size_t>(count, 4); i > 0; --i) value = value << 8U | bytes[i - 1];
  return value;
}

std::uint16_t index_of(const ::can_frame& frame) {
  return static_cast<std::uint16_t>(little_endian(frame.data + 1, 2));
}

}  // namespace

CanopenNode::CanopenNode(std::uint8_t id, Transducer what, std::vector<::can_frame>& out)
    : id_(id), what_(what), out_(out) {}

void CanopenNode::set_entry(std::uint16_t index, std::uint8_t sub_index, std::uint32_t value, std::size_t bytes,
                            bool writable) {
  Entry entry;
  for (std::size_t i = 0; i < bytes; ++i) entry.bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  entry.writable = writable;
  dictionary_[key(index, sub_index)] = std::move(entry);
}

void CanopenNode::remove_entry(std::uint16_t index, std::uint8_t sub_index) {
  dictionary_.erase(key(index, sub_index));
}

std::uint32_t CanopenNode::entry(std::uint16_t index, std::uint8_t sub_index) const {
  const auto place = dictionary_.find(key(index, sub_index));
  return place == dictionary_.end() ? 0 : little_endian(place->second.bytes.data(), place->second.bytes.size());
}

void CanopenNode::fill() {
  dictionary_.clear();
  const bool encoder = what_ == Transducer::encoder;
  const std::uint32_t measured = encoder ? 0x60040020 : what_ == Transducer::input ? 0x91300120 : 0x61300120;
  set_entry(0x1000, 0, encoder ? 0x00020196 : 0x00020194, 4, false);
  set_entry(0x1001, 0, 0, 1, false);
  set_entry(0x1005, 0, 0x80, 4, true);
  const std::string name = encoder                      ? "rigsim encoder"
                           : what_ == Transducer::input ? "rigsim input"
                                                        : "rigsim load cell";
  dictionary_[key(0x1008, 0)] = {{name.begin(), name.end()}, false};
  set_entry(0x1017, 0, 0, 2, true);
  set_entry(0x1018, 0, 4, 1, false);
  set_entry(0x1018, 1, kVendor, 4, false);
  set_entry(0x1018, 2, measured >> 16U, 4, false);
  set_entry(0x1018, 3, kRevision, 4, false);
  set_entry(0x1018, 4, 1000U + id_, 4, false);
  for (unsigned i = 0; i < kPdos; ++i) {
    const auto parameters = static_cast<std::uint16_t>(0x1800 + i), mapping = static_cast<std::uint16_t>(0x1A00 + i);
    const bool valid = i == 0 && what_ != Transducer::input;
    set_entry(parameters, 0, 2, 1, false);
    set_entry(parameters, 1, (valid ? 0 : kNotValid) | (0x180 + 0x100 * i + id_), 4, true);
    set_entry(parameters, 2, what_ == Transducer::load_cell && i == 0 ? 1 : 254, 1, true);
    set_entry(mapping, 0, 0, 1, false);
  }
  // The status before the value, so that the value does not begin at bit 0.
  std::vector<std::uint32_t> mapped;
  if (what_ == Transducer::input) mapped.push_back(0x61500108);
  mapped.push_back(wrong_ ? (encoder ? 0x60300110U : 0x71300110U) : measured);
  set_entry(0x1A00, 0, static_cast<std::uint32_t>(mapped.size()), 1, false);
  for (std::size_t i = 0; i < mapped.size(); ++i)
    set_entry(0x1A00, static_cast<std::uint8_t>(i + 1), mapped[i], 4, false);
  if (what_ == Transducer::input) set_entry(0x6150, 1, 0, 1, false);
  set_entry(static_cast<std::uint16_t>(measured >> 16U), static_cast<std::uint8_t>(measured >> 8U), 0, 4, false);
}

void CanopenNode::encode(double si) {
  switch (what_) {
    case Transducer::load_cell:
      set_entry(0x6130, 1, std::bit_cast<std::uint32_t>(static_cast<float>(si)), 4, false);
      return;
    case Transducer::encoder:
    case Transducer::input: {
      constexpr double kLowest = -2147483648.0;
      const double counts =
          std::isnan(si) ? kLowest : std::clamp(std::nearbyint(si / kMetresPerUnit), kLowest, -kLowest - 1.0);
      const auto value = static_cast<std::uint32_t>(static_cast<std::int32_t>(counts));
      if (what_ == Transducer::encoder)
        set_entry(0x6004, 0, value, 4, false);
      else
        set_entry(0x9130, 1, value, 4, false);
      return;
    }
  }
}

void CanopenNode::send(canid_t id, const std::vector<std::uint8_t>& bytes) {
  ::can_frame frame{};
  frame.can_id = id;
  frame.can_dlc = static_cast<std::uint8_t>(std::min<std::size_t>(bytes.size(), CAN_MAX_DLEN));
  std::copy_n(bytes.begin(), frame.can_dlc, frame.data);
  out_.push_back(frame);
}

// ---- network management --------------------------------------------------------------------------------------------

void CanopenNode::reset(std::int64_t now_ns) {
  state_ = State::booting;
  boot_ns_ = now_ns + kBoot_ns;
  segments_.clear();
}

std::int64_t CanopenNode::next_ns() const noexcept {
  if (state_ == State::off) return std::numeric_limits<std::int64_t>::max();
  if (state_ == State::booting) return boot_ns_;
  return entry(0x1017, 0) == 0 ? std::numeric_limits<std::int64_t>::max() : heartbeat_ns_;
}

void CanopenNode::tick(std::int64_t now_ns) {
  if (now_ns < next_ns()) return;
  if (state_ == State::booting) {
    fill();
    state_ = State::pre_operational;
    send(0x700U + id_, {0});
    return;
  }
  const std::uint8_t state = state_ == State::operational ? 5 : state_ == State::stopped ? 4 : 127;
  send(0x700U + id_, {state});
  heartbeat_ns_ = now_ns + static_cast<std::int64_t>(1e6 * entry(0x1017, 0) / rate_);
}

void CanopenNode::take(const ::can_frame& frame, std::int64_t now_ns) {
  if (state_ == State::off || state_ == State::booting) return;
  if (frame.can_id == 0x600U + id_ && frame.can_dlc == 8 && state_ != State::stopped) {
    const std::uint32_t before = entry(0x1017, 0);
    serve_sdo(frame);
    if (entry(0x1017, 0) != before) heartbeat_ns_ = now_ns;
  }
  if (frame.can_id != 0 || frame.can_dlc != 2 || (frame.data[1] != 0 && frame.data[1] != id_)) return;
  switch (frame.data[0]) {
    case 0x01:
      state_ = State::operational;
      syncs_ = 0;
      break;
    case 0x02:
      state_ = State::stopped;
      break;
    case 0x80:
      state_ = State::pre_operational;
      break;
    case 0x81:
    case 0x82:
      reset(now_ns);
      break;
    default:
      break;
  }
}

void CanopenNode::emergency(std::uint16_t code, std::uint8_t error_register) {
  if (state_ == State::off || state_ == State::booting) return;
  set_entry(0x1001, 0, error_register, 1, false);
  send(0x80U + id_,
       {static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8U), error_register, 0, 0, 0, 0, 0});
}

// ---- process data --------------------------------------------------------------------------------------------------

void CanopenNode::sync(double si) {
  if (state_ == State::off || state_ == State::booting) return;
  encode(si);
  if (state_ != State::operational) return;
  ++syncs_;
  for (unsigned i = 0; i < kPdos; ++i) {
    const std::uint32_t type = entry(static_cast<std::uint16_t>(0x1800 + i), 2);
    const bool valid = (entry(static_cast<std::uint16_t>(0x1800 + i), 1) & kNotValid) == 0;
    if (valid && type >= 1 && type <= 240 && syncs_ % type == 0) send_pdo(i);
  }
}

void CanopenNode::send_pdo(unsigned number) {
  const auto mapping = static_cast<std::uint16_t>(0x1A00 + number);
  std::vector<std::uint8_t> bytes;
  for (std::uint32_t i = 1; i <= entry(mapping, 0); ++i) {
    const std::uint32_t mapped = entry(mapping, static_cast<std::uint8_t>(i));
    const std::uint32_t value =
        entry(static_cast<std::uint16_t>(mapped >> 16U), static_cast<std::uint8_t>(mapped >> 8U));
    for (unsigned k = 0; k < (mapped & 0xFFU) / 8; ++k) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * k)));
  }
  send(entry(static_cast<std::uint16_t>(0x1800 + number), 1) & CAN_SFF_MASK, bytes);
}

// ---- service data --------------------------------------------------------------------------------------------------

void CanopenNode::abort(const ::can_frame& request, std::uint32_t code) {
  send(0x580U + id_, {0x80, request.data[1], request.data[2], request.data[3], static_cast<std::uint8_t>(code),
                      static_cast<std::uint8_t>(code >> 8U), static_cast<std::uint8_t>(code >> 16U),
                      static_cast<std::uint8_t>(code >> 24U)});
}

void CanopenNode::serve_sdo(const ::can_frame& request) {
  switch (request.data[0] >> 5U) {
    case 1:
      return download(request);
    case 2:
      return upload(request);
    case 3:
      return upload_segment(request);
    case 4:
      segments_.clear();
      return;
    default:
      return abort(request, kUnknownCommand);
  }
}

void CanopenNode::upload(const ::can_frame& request) {
  const std::uint16_t index = index_of(request);
  const auto place = dictionary_.find(key(index, request.data[3]));
  if (place == dictionary_.end()) {
    const auto sibling = dictionary_.lower_bound(key(index, 0));
    const bool there = sibling != dictionary_.end() && sibling->first >> 8U == index;
    return abort(request, there ? kNoEntry : kNoObject);
  }
  const auto& bytes = place->second.bytes;
  const auto size = static_cast<std::uint8_t>(bytes.size());
  std::vector<std::uint8_t> answer{0x41, request.data[1], request.data[2], request.data[3], size, 0, 0, 0};
  if (size <= 4) {
    answer[0] = static_cast<std::uint8_t>(0x43 | (4 - size) << 2);
    std::fill(answer.begin() + 4, answer.end(), std::uint8_t{0});
    std::copy(bytes.begin(), bytes.end(), answer.begin() + 4);
  } else {
    segments_ = bytes;
    toggle_ = false;
  }
  send(0x580U + id_, answer);
}

void CanopenNode::upload_segment(const ::can_frame& request) {
  const bool toggle = (request.data[0] & 0x10U) != 0;
  if (segments_.empty()) return abort(request, kUnknownCommand);
  if (toggle != toggle_) return abort(request, kToggleError);
  const std::size_t count = std::min<std::size_t>(segments_.size(), 7);
  const bool last = count == segments_.size();
  std::vector<std::uint8_t> answer(8, 0);
  answer[0] = static_cast<std::uint8_t>((toggle ? 0x10U : 0U) | (7 - count) << 1U | (last ? 1U : 0U));
  std::copy_n(segments_.begin(), count, answer.begin() + 1);
  segments_.erase(segments_.begin(), segments_.begin() + static_cast<std::ptrdiff_t>(count));
  toggle_ = !toggle_;
  send(0x580U + id_, answer);
}

std::uint32_t CanopenNode::refusal(std::uint16_t index, std::uint8_t sub_index, std::uint32_t value) const {
  if (index < 0x1800 || index >= 0x1800 + kPdos) return 0;
  if (state_ == State::operational) return kNotNow;
  const std::uint32_t cob_id = entry(index, 1);
  const bool valid = (cob_id & kNotValid) == 0;
  if (sub_index == 1 && valid && ((value ^ cob_id) & kFrameBits) != 0) return kWrongValue;
  if (sub_index == 2 && valid) return kNotNow;
  return 0;
}

void CanopenNode::download(const ::can_frame& request) {
  const std::uint16_t index = index_of(request);
  const auto place = dictionary_.find(key(index, request.data[3]));
  if (place == dictionary_.end()) return abort(request, kNoObject);
  if (!place->second.writable) return abort(request, kReadOnly);
  const bool expedited = (request.data[0] & 2U) != 0, sized = (request.data[0] & 1U) != 0;
  const std::size_t size = sized ? 4 - (request.data[0] >> 2U & 3U) : place->second.bytes.size();
  if (!expedited || size != place->second.bytes.size()) return abort(request, kWrongLength);
  const std::uint32_t value = little_endian(request.data + 4, size);
  if (const std::uint32_t code = refusal(index, request.data[3], value); code != 0) return abort(request, code);
  set_entry(index, request.data[3], value, size, true);
  send(0x580U + id_, {0x60, request.data[1], request.data[2], request.data[3], 0, 0, 0, 0});
}

}  // namespace rigsim
