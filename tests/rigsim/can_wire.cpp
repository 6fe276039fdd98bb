#include "tests/rigsim/can_wire.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace rigsim {
namespace {

constexpr std::string_view kLocal = "unix:";
constexpr std::size_t kMostClients = 16;
constexpr int kFramesAtOnce = 256;

}  // namespace

Result<CanWire> CanWire::open(const std::string& interface) {
  CanWire wire;
  if (interface.compare(0, kLocal.size(), kLocal) != 0) {
    auto opened = dwell::socketcan::open_socket(interface, {});
    if (!opened) return tl::make_unexpected(opened.error());
    wire.interface_ = std::move(*opened);
    return wire;
  }
  if (const std::string fault = dwell::socketcan::interface_fault(interface); !fault.empty())
    return tl::make_unexpected(interface + ": " + fault);
  const std::string path = interface.substr(kLocal.size());
  wire.listener_ = Fd(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  path.copy(address.sun_path, sizeof address.sun_path - 1);
  ::unlink(path.c_str());
  if (!wire.listener_ || ::bind(wire.listener_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      ::listen(wire.listener_.get(), static_cast<int>(kMostClients)) != 0)
    return tl::make_unexpected("cannot listen at " + interface + ": " + std::strerror(errno));
  wire.path_ = path;
  return wire;
}

CanWire::~CanWire() {
  if (listener_) ::unlink(path_.c_str());
}

void CanWire::watch(std::vector<pollfd>& polled) const {
  if (interface_) polled.push_back({interface_->descriptor(), POLLIN, 0});
  if (listener_) polled.push_back({listener_.get(), POLLIN, 0});
  for (const Fd& client : clients_) polled.push_back({client.get(), POLLIN, 0});
}

void CanWire::receive(std::vector<WireFrame>& frames) {
  if (interface_) {
    std::array<dwell::socketcan::Packet, 64> packets;
    const auto batch = interface_->read(packets);
    for (std::size_t i = 0; i < batch.count; ++i)
      if ((packets[i].frame.can_id & CAN_ERR_FLAG) == 0)
        frames.push_back({packets[i].frame, packets[i].size == CANFD_MTU, packets[i].real_ns});
    return;
  }
  while (clients_.size() < kMostClients) {
    Fd client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (!client) break;
    const int room = 4 << 20;
    ::setsockopt(client.get(), SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    clients_.push_back(std::move(client));
  }
  for (Fd& client : clients_) {
    for (int i = 0; i < kFramesAtOnce && client; ++i) {
      WireFrame frame;
      const ssize_t size = ::recv(client.get(), &frame.can, sizeof frame.can, 0);
      if (size < 0 && (errno == EAGAIN || errno == EINTR)) break;
      frame.fd = size == CANFD_MTU;
      if (size <= 0) {
        client.close();
      } else if (frame.fd || size == CAN_MTU) {
        unsigned lost = 0;
        forward(frame, &client, lost);
        frames.push_back(frame);
      }
    }
  }
  std::erase_if(clients_, [](const Fd& client) { return !client; });
}

unsigned CanWire::send(const WireFrame& frame) {
  unsigned lost = 0;
  if (interface_) return interface_->write(frame.can, frame.fd) == 0 ? 0 : 1;
  forward(frame, nullptr, lost);
  return lost;
}

void CanWire::forward(const WireFrame& frame, const Fd* from, unsigned& lost) {
  const std::size_t size = frame.fd ? CANFD_MTU : CAN_MTU;
  for (const Fd& client : clients_)
    if (&client != from && client && ::send(client.get(), &frame.can, size, MSG_NOSIGNAL | MSG_DONTWAIT) < 0) ++lost;
}

}  // namespace rigsim
