#include "tests/drivers/modbus_device.hpp"

#include <netinet/in.h>
#include <poll.h>
#include <pty.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace dwell::test {
namespace {

std::uint8_t high(unsigned word) { return static_cast<std::uint8_t>(word >> 8U); }
std::uint8_t low(unsigned word) { return static_cast<std::uint8_t>(word); }
std::uint16_t word_at(const std::uint8_t* bytes) { return static_cast<std::uint16_t>(bytes[0] << 8U | bytes[1]); }

std::uint16_t crc_of(const std::vector<std::uint8_t>& bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? (crc >> 1U) ^ 0xA001U : crc >> 1U;
  }
  return static_cast<std::uint16_t>(crc);
}

bool readable(int descriptor) {
  pollfd one{descriptor, POLLIN, 0};
  return ::poll(&one, 1, 5) > 0;
}

}  // namespace

Reply answer(const Request& request, const std::function<std::uint16_t(unsigned)>& value_of) {
  Reply reply;
  reply.pdu = {request.function, static_cast<std::uint8_t>(2 * request.count)};
  for (unsigned i = 0; i < request.count; ++i) {
    const std::uint16_t value = value_of(request.first + i);
    reply.pdu.push_back(high(value));
    reply.pdu.push_back(low(value));
  }
  return reply;
}

Reply exception(const Request& request, std::uint8_t code) {
  Reply reply;
  reply.pdu = {static_cast<std::uint8_t>(request.function | 0x80U), code};
  return reply;
}

ModbusDevice::ModbusDevice(Over over, Script script) : over_(over), script_(std::move(script)) {
  if (over_ == Over::serial) {
    static std::atomic<int> serial_number{0};
    serial_ = (std::filesystem::temp_directory_path() /
               ("dwell-test-" + std::to_string(::getpid()) + "-" + std::to_string(serial_number++)))
                  .string();
  }
  come();
}

ModbusDevice::~ModbusDevice() { leave(); }

void ModbusDevice::leave() {
  leaving_ = true;
  if (thread_.joinable()) thread_.join();
  for (int* descriptor : {&listener_, &master_, &slave_}) {
    if (*descriptor >= 0) ::close(*descriptor);
    *descriptor = -1;
  }
  if (!serial_.empty()) std::filesystem::remove(serial_);
}

void ModbusDevice::come() {
  leaving_ = false;
  requests_ = 0;
  if (over_ == Over::tcp) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int yes = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(port_));
    socklen_t size = sizeof address;
    if (::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listener_, 4) != 0)
      throw std::runtime_error("cannot listen");
    ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { serve_tcp(); });
  } else {
    std::array<char, 256> name{};
    if (::openpty(&master_, &slave_, name.data(), nullptr, nullptr) != 0)
      throw std::runtime_error("no pseudo-terminal");
    termios raw{};
    ::tcgetattr(slave_, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(slave_, TCSANOW, &raw);
    std::filesystem::remove(serial_);
    std::filesystem::create_symlink(name.data(), serial_);
    thread_ = std::thread([this] { serve_serial(); });
  }
}

void ModbusDevice::serve_tcp() {
  while (!leaving_) {
    if (!readable(listener_)) continue;
    const int client = ::accept(listener_, nullptr, nullptr);
    std::array<std::uint8_t, 12> bytes{};
    std::size_t held = 0;
    bool connected = client >= 0;
    while (connected && !leaving_) {
      if (!readable(client)) continue;
      const auto got = ::recv(client, bytes.data() + held, bytes.size() - held, 0);
      connected = got > 0;
      held += connected ? static_cast<std::size_t>(got) : 0;
      if (!connected || held < bytes.size()) continue;
      held = 0;
      connected = respond(
          client, {requests_++, word_at(&bytes[0]), bytes[6], bytes[7], word_at(&bytes[8]), word_at(&bytes[10])});
    }
    const linger at_once{1, 0};
    ::setsockopt(client, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    ::close(client);
  }
}

void ModbusDevice::serve_serial() {
  std::array<std::uint8_t, 8> bytes{};
  std::size_t held = 0;
  while (!leaving_) {
    if (!readable(master_)) continue;
    const auto got = ::read(master_, bytes.data() + held, bytes.size() - held);
    held += got > 0 ? static_cast<std::size_t>(got) : 0;
    if (held < bytes.size()) continue;
    held = 0;
    respond(master_, {requests_++, 0, bytes[0], bytes[1], word_at(&bytes[2]), word_at(&bytes[4])});
  }
}

bool ModbusDevice::respond(int descriptor, const Request& request) {
  for (const Reply& reply : script_(request)) {
    const auto due = std::chrono::steady_clock::now() + reply.delay;
    while (std::chrono::steady_clock::now() < due && !leaving_)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (reply.reset) return false;
    std::vector<std::uint8_t> frame;
    const std::uint8_t unit = reply.unit.value_or(request.unit);
    if (over_ == Over::tcp) {
      const std::uint16_t transaction = reply.transaction.value_or(request.transaction);
      const auto length = static_cast<unsigned>(reply.pdu.size() + 1);
      frame = {high(transaction), low(transaction), 0, 0, high(length), low(length)};
    }
    frame.push_back(unit);
    frame.insert(frame.end(), reply.pdu.begin(), reply.pdu.end());
    if (over_ == Over::serial) {
      const std::uint16_t crc = crc_of(frame);
      frame.push_back(static_cast<std::uint8_t>(low(crc) ^ (reply.bad_checksum ? 0x55U : 0U)));
      frame.push_back(high(crc));
    }
    frame.resize(std::min(frame.size(), reply.keep));
    const auto written = over_ == Over::tcp ? ::send(descriptor, frame.data(), frame.size(), MSG_NOSIGNAL)
                                            : ::write(descriptor, frame.data(), frame.size());
    if (written < 0) return false;
  }
  return true;
}

}  // namespace dwell::test
