#include "drivers/canopen/sdo_client.hpp"

#include <utility>

namespace dwell::canopen {
namespace {

// Command specifiers, the upper three bits of the first byte.
constexpr unsigned kUploadSegment = 0, kUploadInitiated = 2, kDownloadInitiated = 3, kAbort = 4;
constexpr std::uint8_t kAskUpload = 0x40, kAskSegment = 0x60, kAskDownload = 0x23, kTellAbort = 0x80;
constexpr std::uint8_t kToggle = 0x10;

constexpr std::uint32_t kToggleError = 0x05030000, kTimedOut = 0x05040000, kOutOfMemory = 0x05040005,
                        kWrongLength = 0x06070010;

}  // namespace

void SdoClient::download(const Object& object, std::uint32_t value, std::uint8_t size, std::int64_t now_ns) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  put_le(bytes, value);
  begin(object, std::span(bytes).first(std::clamp<std::size_t>(size, 1, 4)), now_ns);
}

void SdoClient::begin(const Object& object, std::span<const std::uint8_t> value, std::int64_t now_ns) noexcept {
  request_ = {object, {}, static_cast<std::uint8_t>(value.size())};
  std::copy(value.begin(), value.end(), request_.value.begin());
  attempts_ = 0;
  abort_code_ = 0;
  state_ = State::busy;
  ask(now_ns);
}

void SdoClient::cancel() noexcept {
  finish(State::idle);
  to_send_.reset();
}

void SdoClient::ask(std::int64_t now_ns) noexcept {
  ++attempts_;
  answer_.size = 0;
  answer_.sized = true;
  const auto command =
      request_.writes() ? static_cast<std::uint8_t>(kAskDownload | (4 - request_.size) << 2) : kAskUpload;
  to_send_ = make_frame(kSdoRequest + node_,
                        {command, static_cast<std::uint8_t>(request_.object.index),
                         static_cast<std::uint8_t>(request_.object.index >> 8U), request_.object.sub_index,
                         request_.value[0], request_.value[1], request_.value[2], request_.value[3]});
  phase_ = Phase::initiate;
  deadline_ns_ = now_ns + kTimeout_ns;
}

void SdoClient::ask_segment(std::int64_t now_ns) noexcept {
  to_send_ = make_frame(kSdoRequest + node_,
                        {static_cast<std::uint8_t>(kAskSegment | (answer_.toggle ? kToggle : 0)), 0, 0, 0, 0, 0, 0, 0});
  phase_ = Phase::segment;
  deadline_ns_ = now_ns + kTimeout_ns;
}

void SdoClient::finish(State state, std::uint32_t abort_code) noexcept {
  state_ = state;
  phase_ = Phase::none;
  abort_code_ = abort_code;
}

void SdoClient::abort_and_finish(std::uint32_t code) noexcept {
  std::array<std::uint8_t, 4> bytes{};
  put_le(bytes, code);
  to_send_ = make_frame(kSdoRequest + node_, {kTellAbort, static_cast<std::uint8_t>(request_.object.index),
                                              static_cast<std::uint8_t>(request_.object.index >> 8U),
                                              request_.object.sub_index, bytes[0], bytes[1], bytes[2], bytes[3]});
  finish(State::aborted, code);
}

void SdoClient::abort_and_pause(std::uint32_t code, std::int64_t now_ns) noexcept {
  abort_and_finish(code);
  if (attempts_ >= kAttempts) {
    if (code == kTimedOut) state_ = State::no_answer;
    return;
  }
  state_ = State::busy;
  phase_ = Phase::pause;
  deadline_ns_ = now_ns + kPause_ns;
}

void SdoClient::tick(std::int64_t now_ns) noexcept {
  if (phase_ == Phase::none || now_ns < deadline_ns_) return;
  if (phase_ == Phase::pause)
    ask(now_ns);
  else
    abort_and_pause(kTimedOut, now_ns);
}

void SdoClient::take(const can_frame& answer, std::int64_t now_ns) noexcept {
  const bool asked = phase_ == Phase::initiate || phase_ == Phase::segment;
  if (!asked || answer.can_dlc != 8) {
    ++late_;
    return;
  }
  const unsigned what = answer.data[0] >> 5U;
  if (what == kUploadSegment && phase_ == Phase::segment) {
    take_segment(answer, now_ns);
    return;
  }
  const Object object{static_cast<std::uint16_t>(get_le({answer.data + 1, 2})), answer.data[3]};
  if (object == request_.object && what == kAbort) {
    finish(State::aborted, static_cast<std::uint32_t>(get_le({answer.data + 4, 4})));
  } else if (object == request_.object && phase_ == Phase::initiate &&
             what == (request_.writes() ? kDownloadInitiated : kUploadInitiated)) {
    take_initiated(answer, now_ns);
  } else {
    ++late_;
  }
}

void SdoClient::take_initiated(const can_frame& answer, std::int64_t now_ns) noexcept {
  if (request_.writes()) {
    finish(State::done);
    return;
  }
  const bool expedited = (answer.data[0] & 2U) != 0, sized = (answer.data[0] & 1U) != 0;
  if (expedited) {
    answer_.sized = sized;
    answer_.size = sized ? 4 - (answer.data[0] >> 2U & 3U) : 4;
    std::copy_n(answer.data + 4, answer_.size, answer_.bytes.begin());
    finish(State::done);
    return;
  }
  answer_.announced = sized ? static_cast<std::size_t>(get_le({answer.data + 4, 4})) : 0;
  if (answer_.announced > kMostBytes) {
    abort_and_finish(kOutOfMemory);
    return;
  }
  answer_.toggle = false;
  ask_segment(now_ns);
}

void SdoClient::take_segment(const can_frame& answer, std::int64_t now_ns) noexcept {
  if (((answer.data[0] & kToggle) != 0) != answer_.toggle) {
    abort_and_pause(kToggleError, now_ns);
    return;
  }
  const std::size_t count = 7 - (answer.data[0] >> 1U & 7U);
  const bool last = (answer.data[0] & 1U) != 0;
  // One of no bytes that is not the last would let a transfer go on for ever.
  if (answer_.size + count > kMostBytes || (count == 0 && !last)) {
    abort_and_finish(count == 0 ? kWrongLength : kOutOfMemory);
    return;
  }
  std::copy_n(answer.data + 1, count, answer_.bytes.begin() + static_cast<std::ptrdiff_t>(answer_.size));
  answer_.size += count;
  if (!last) {
    answer_.toggle = !answer_.toggle;
    ask_segment(now_ns);
  } else if (answer_.announced != 0 && answer_.announced != answer_.size) {
    abort_and_finish(kWrongLength);
  } else {
    finish(State::done);
  }
}

std::optional<can_frame> SdoClient::to_send() noexcept { return std::exchange(to_send_, std::nullopt); }

unsigned SdoClient::take_late() noexcept { return std::exchange(late_, 0); }

}  // namespace dwell::canopen
