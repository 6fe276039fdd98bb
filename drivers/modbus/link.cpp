#include "drivers/modbus/link.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>

namespace dwell::modbus {
namespace {

using driver::monotonic_ns;
using driver::raw_ns;
using driver::Stop;

constexpr std::int64_t kConnect_ns = 1'000'000'000;
// libmodbus waits uninterruptibly: it is entrusted only with waits that stop can outlast.
constexpr std::int64_t kUninterruptible_ns = 350'000'000;

constexpr std::size_t kTcpHeader = 6;  // transaction, protocol, length
constexpr std::uint8_t kUntouched = 0xFF;
constexpr std::size_t kProbe =
    4;  // bytes of the frame that tell whether anything arrived: no valid frame begins with four 0xFF

std::uint16_t word_at(const std::uint8_t* bytes) noexcept {
  return static_cast<std::uint16_t>((bytes[0] << 8U) | bytes[1]);
}
std::uint8_t high(unsigned word) noexcept { return static_cast<std::uint8_t>(word >> 8U); }
std::uint8_t low(unsigned word) noexcept { return static_cast<std::uint8_t>(word); }

modbus_t* new_context(const Setup& setup) {
  // The address given to the TCP context is not used: Connector makes the connection.
  return setup.transport == Transport::tcp
             ? modbus_new_tcp("127.0.0.1", setup.port)
             : modbus_new_rtu(setup.serial.c_str(), setup.baud, setup.parity, 8, setup.stop_bits);
}

}  // namespace

Link::Link(const Setup& setup) : setup_(setup), context_(new_context(setup), &modbus_free) {
  if (!context_) throw std::runtime_error(setup.address() + ": " + modbus_strerror(errno));
  modbus_set_error_recovery(context_.get(), MODBUS_ERROR_RECOVERY_NONE);
  // The response timeout then bounds the whole answer, not only its first byte.
  modbus_set_byte_timeout(context_.get(), 0, 0);
  if (setup.transport == Transport::tcp) connector_.emplace(setup.host, setup.port);
}

Link::~Link() { close(); }

std::string Link::open(const Stop& stop) {
  std::string error;
  if (connector_) {
    const int descriptor = connector_->connect(monotonic_ns() + kConnect_ns, stop, error);
    if (descriptor < 0) return setup_.address() + ": " + error;
    modbus_set_socket(context_.get(), descriptor);
    return {};
  }
  if (error = lock_.take(setup_.serial); !error.empty()) {
    error = setup_.address() + ": " + error;
  } else if (modbus_connect(context_.get()) != 0) {
    error = setup_.address() + ": " + modbus_strerror(errno);
  } else if (modbus_get_socket(context_.get()) >= FD_SETSIZE) {
    error = setup_.address() + ": too many files are open in this program";
    close();
  } else {
    ::fcntl(modbus_get_socket(context_.get()), F_SETFD, FD_CLOEXEC);
    lock_.exclude_others();
    // Whoever used the port before may have left a request under way.
    free_ns_ = monotonic_ns() + setup_.late_ns;
  }
  return error;
}

void Link::close() noexcept {
  const int descriptor = modbus_get_socket(context_.get());
  if (descriptor < 0) return lock_.release();
  // A serial port with unsent bytes may take long to close.
  if (!connector_) ::tcflush(descriptor, TCIOFLUSH);
  modbus_close(context_.get());
  lock_.release();
}

Answer Link::read(const Block& block, std::uint16_t* registers, const Stop& stop) noexcept {
  return connector_ ? read_tcp(block, registers, stop) : read_rtu(block, registers, stop);
}

Answer Link::read_tcp(const Block& block, std::uint16_t* registers, const Stop& stop) noexcept {
  ++transaction_;
  const std::array<std::uint8_t, 12> request = {high(transaction_),
                                                low(transaction_),
                                                0,
                                                0,
                                                0,
                                                6,
                                                block.station,
                                                static_cast<std::uint8_t>(block.table),
                                                high(block.first),
                                                low(block.first),
                                                high(block.count),
                                                low(block.count)};
  Answer answer;
  answer.sent_ns = raw_ns();
  const std::int64_t deadline_ns = monotonic_ns() + setup_.timeout_ns;
  const auto sent = ::send(modbus_get_socket(context_.get()), request.data(), request.size(), MSG_NOSIGNAL);
  Receipt receipt = Receipt::lost;
  if (sent == static_cast<ssize_t>(request.size())) {
    while ((receipt = receive(deadline_ns, stop, answer)) == Receipt::frame) {
      // libmodbus finds the end by the function code; where the header tells another, the stream is out of step.
      if (word_at(&frame_[2]) != 0 || word_at(&frame_[4]) + kTcpHeader != frame_size_) {
        receipt = Receipt::bad;
        break;
      }
      if (word_at(&frame_[0]) == transaction_) {
        judge(&frame_[kTcpHeader], frame_size_ - kTcpHeader, block, registers, answer);
        return answer;
      }
      ++answer.late;
      // A device that collects small packets (Nagle) holds the current answer back until the late one is acknowledged,
      // which this end would do only after 40 ms: with a shorter timeout every answer would come late from then on.
      const int yes = 1;
      ::setsockopt(modbus_get_socket(context_.get()), IPPROTO_TCP, TCP_QUICKACK, &yes, sizeof yes);
    }
  } else {
    answer.error = sent < 0 ? errno : EAGAIN;
  }
  switch (receipt) {
    case Receipt::stopped:
      answer.stopped = true;
      break;
    case Receipt::timeout:
      answer.fault = DWELL_FAULT_TIMEOUT;
      break;
    case Receipt::partial:
      answer.fault = DWELL_FAULT_SHORT_FRAME;
      break;
    case Receipt::lost:
      answer.fault = DWELL_FAULT_DISCONNECTED;
      break;
    default:
      answer.fault = DWELL_FAULT_BAD_FRAME;
      break;
  }
  answer.broken = receipt != Receipt::timeout && receipt != Receipt::stopped;
  return answer;
}

Answer Link::read_rtu(const Block& block, std::uint16_t* registers, const Stop& stop) noexcept {
  Answer answer;
  if (!keep_silent(stop, answer)) return answer;
  const std::array<std::uint8_t, 6> request = {block.station,     static_cast<std::uint8_t>(block.table),
                                               high(block.first), low(block.first),
                                               high(block.count), low(block.count)};
  modbus_set_slave(context_.get(), block.station);
  answer.sent_ns = raw_ns();
  const std::int64_t deadline_ns = monotonic_ns() + setup_.wire.time_ns(kRequestBytes) + setup_.timeout_ns +
                                   setup_.wire.time_ns(answer_bytes(block.count));
  Receipt receipt = Receipt::lost;
  if (modbus_send_raw_request(context_.get(), request.data(), request.size()) == static_cast<int>(kRequestBytes))
    receipt = receive(deadline_ns, stop, answer);
  else
    answer.error = errno;
  switch (receipt) {
    case Receipt::frame:
      judge(frame_.data(), frame_size_ - 2, block, registers, answer);
      break;
    case Receipt::stopped:
      answer.stopped = true;
      break;
    case Receipt::timeout:
      answer.fault = DWELL_FAULT_TIMEOUT;
      break;
    case Receipt::partial:
      answer.fault = DWELL_FAULT_SHORT_FRAME;
      break;
    case Receipt::bad_checksum:
      answer.fault = DWELL_FAULT_BAD_CHECKSUM;
      break;
    case Receipt::bad:
      answer.fault = DWELL_FAULT_BAD_FRAME;
      break;
    case Receipt::lost:
      answer.fault = DWELL_FAULT_DISCONNECTED;
      answer.broken = true;
      break;
  }
  const bool in_step = answer.fault == DWELL_FAULT_NONE || answer.fault == DWELL_FAULT_EXCEPTION;
  free_ns_ = monotonic_ns() + (in_step ? setup_.gap_ns : setup_.late_ns);
  return answer;
}

// RTU: waits until the line may be used and throws away what arrives until then. false: stopped or lost.
bool Link::keep_silent(const Stop& stop, Answer& answer) noexcept {
  const int descriptor = modbus_get_socket(context_.get());
  bool anything = false;
  while (true) {
    switch (stop.wait(descriptor, POLLIN, free_ns_)) {
      case Stop::Wait::stopped:
        answer.stopped = true;
        return false;
      case Stop::Wait::timeout:
        answer.late += anything ? 1U : 0U;
        return true;
      case Stop::Wait::ready:
        break;
    }
    const auto got = ::read(descriptor, frame_.data(), frame_.size());
    if (got <= 0 && (got == 0 || (errno != EAGAIN && errno != EINTR))) {
      answer.error = got == 0 ? ECONNRESET : errno;
      answer.fault = DWELL_FAULT_DISCONNECTED;
      answer.broken = true;
      return false;
    }
    anything = true;
    free_ns_ = std::max(free_ns_, monotonic_ns() + setup_.gap_ns);
  }
}

// Waits for one frame, into frame_. libmodbus finds its end and, with RTU, checks its CRC and station.
Link::Receipt Link::receive(std::int64_t deadline_ns, const Stop& stop, Answer& answer) noexcept {
  std::int64_t left_ns = deadline_ns - monotonic_ns();
  if (left_ns <= 0) return Receipt::timeout;
  if (left_ns > kUninterruptible_ns) {
    switch (stop.wait(modbus_get_socket(context_.get()), POLLIN, deadline_ns)) {
      case Stop::Wait::ready:
        break;
      case Stop::Wait::timeout:
        return Receipt::timeout;
      case Stop::Wait::stopped:
        return Receipt::stopped;
    }
    left_ns = std::clamp<std::int64_t>(deadline_ns - monotonic_ns(), 1000, kUninterruptible_ns);
  }
  std::fill_n(frame_.begin(), kProbe, kUntouched);
  modbus_set_response_timeout(context_.get(), 0, static_cast<std::uint32_t>(std::max<std::int64_t>(1, left_ns / 1000)));
  const int size = modbus_receive_confirmation(context_.get(), frame_.data());
  const int error = errno;
  answer.received_ns = raw_ns();
  if (size > 0) {
    frame_size_ = static_cast<std::size_t>(size);
    return Receipt::frame;
  }
  if (size == 0) return Receipt::bad;  // a frame of another station
  if (error == ETIMEDOUT) {
    const auto end = frame_.begin() + kProbe;
    const bool anything =
        std::find_if(frame_.begin(), end, [](std::uint8_t byte) { return byte != kUntouched; }) != end;
    return anything ? Receipt::partial : Receipt::timeout;
  }
  if (error == EMBBADCRC) return Receipt::bad_checksum;
  if (error > MODBUS_ENOBASE) return Receipt::bad;
  answer.error = error;
  return Receipt::lost;
}

// Whether a whole frame answers the request; `unit`: from the station's number to the end, checksum apart.
void Link::judge(const std::uint8_t* unit, std::size_t size, const Block& block, std::uint16_t* registers,
                 Answer& answer) noexcept {
  const auto function = static_cast<std::uint8_t>(block.table);
  answer.fault = DWELL_FAULT_BAD_FRAME;
  if (size < 3 || unit[0] != block.station) return;
  if (unit[1] == (function | 0x80U)) {
    if (size != 3) return;
    answer.fault = DWELL_FAULT_EXCEPTION;
    answer.exception = unit[2];
    return;
  }
  if (unit[1] != function || unit[2] + std::size_t{3} != size) return;
  if (unit[2] != 2U * block.count) {
    if (unit[2] < 2U * block.count) answer.fault = DWELL_FAULT_SHORT_FRAME;
    return;
  }
  for (std::size_t i = 0; i < block.count; ++i) registers[i] = word_at(unit + 3 + 2 * i);
  answer.fault = DWELL_FAULT_NONE;
}

}  // namespace dwell::modbus
