#include "drivers/socketcan/socket.hpp"

#include <linux/can/raw.h>
#include <linux/errqueue.h>
#include <linux/net_tstamp.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace dwell::socketcan {
namespace {

constexpr std::string_view kLocal = "unix:";
constexpr std::size_t kBatch = 64;
constexpr int kReceiveBuffer = 4 << 20;  // bytes; the kernel takes as much of it as it allows

std::int64_t to_ns(const timespec& time) noexcept { return std::int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }

tl::unexpected<std::string> failed(const std::string& interface, const char* what, int error) {
  return tl::unexpected(interface + ": " + what + ": " + std::strerror(error));
}

class KernelSocket : public Socket {
 public:
  explicit KernelSocket(int descriptor, std::string interface = {}) noexcept
      : descriptor_(descriptor), interface_(std::move(interface)) {}
  ~KernelSocket() override { ::close(descriptor_); }
  KernelSocket(const KernelSocket&) = delete;
  KernelSocket& operator=(const KernelSocket&) = delete;

  [[nodiscard]] int descriptor() const noexcept override { return descriptor_; }
  [[nodiscard]] Link link() const noexcept override {
    ifreq request{};
    interface_.copy(request.ifr_name, IFNAMSIZ - 1);
    if (interface_.empty() || ::ioctl(descriptor_, SIOCGIFFLAGS, &request) != 0) return Link::up;
    const auto flags = static_cast<unsigned>(request.ifr_flags);
    return (flags & IFF_UP) == 0 ? Link::down : (flags & IFF_RUNNING) == 0 ? Link::no_carrier : Link::up;
  }

  // A socket that cannot do one of these does without: a stamp that is missing is replaced.
  void ask_for_stamps_and_losses() noexcept {
    set(SOL_SOCKET, SO_TIMESTAMPNS, 1);
    set(SOL_SOCKET, SO_TIMESTAMPING, SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE);
    set(SOL_SOCKET, SO_RXQ_OVFL, 1);
    set(SOL_SOCKET, SO_RCVBUF, kReceiveBuffer);
  }
  template <class T>
  bool set(int level, int option, const T& value) noexcept {
    return ::setsockopt(descriptor_, level, option, &value, sizeof value) == 0;
  }

  Batch read(std::span<Packet> room) noexcept override {
    Batch batch;
    while (batch.count < room.size()) {
      const std::size_t wanted = std::min(room.size() - batch.count, kBatch);
      const int got = receive(room.subspan(batch.count, wanted));
      if (got < 0) {
        if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) batch.error = errno;
        break;
      }
      batch.count += static_cast<std::size_t>(got);
      if (static_cast<std::size_t>(got) < wanted) break;
    }
    batch.dropped = dropped_;
    return batch;
  }

  int write(const canfd_frame& frame, bool fd) noexcept override {
    const std::size_t size = fd ? CANFD_MTU : CAN_MTU;
    return ::send(descriptor_, &frame, size, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(size) ? 0 : errno;
  }

 private:
  struct alignas(cmsghdr) Control {
    std::array<char, CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(scm_timestamping)) +
                         CMSG_SPACE(sizeof(std::uint32_t)) + 64>
        bytes;
  };

  int receive(std::span<Packet> room) noexcept {
    for (std::size_t i = 0; i < room.size(); ++i) {
      pieces_[i] = {&room[i].frame, sizeof room[i].frame};
      msghdr& header = messages_[i].msg_hdr;
      header = {};
      header.msg_iov = &pieces_[i];
      header.msg_iovlen = 1;
      header.msg_control = controls_[i].bytes.data();
      header.msg_controllen = controls_[i].bytes.size();
    }
    const int got = ::recvmmsg(descriptor_, messages_.data(), static_cast<unsigned>(room.size()),
                               MSG_DONTWAIT | MSG_TRUNC, nullptr);
    for (int i = 0; i < got; ++i) {
      Packet& packet = room[static_cast<std::size_t>(i)];
      packet.own = (messages_[static_cast<std::size_t>(i)].msg_hdr.msg_flags & MSG_CONFIRM) != 0;
      packet.size = messages_[static_cast<std::size_t>(i)].msg_len;
      if (packet.size == CAN_MTU) clear_rest(packet.frame);
      read_control(messages_[static_cast<std::size_t>(i)].msg_hdr, packet);
    }
    return got;
  }

  // What of the frame the kernel did not write.
  static void clear_rest(canfd_frame& frame) noexcept {
    frame.flags = 0;
    std::memset(frame.data + CAN_MAX_DLEN, 0, CANFD_MAX_DLEN - CAN_MAX_DLEN);
  }

  void read_control(msghdr& header, Packet& packet) noexcept {
    packet.real_ns = packet.hardware_ns = 0;
    for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
      if (control->cmsg_level != SOL_SOCKET) continue;
      if (control->cmsg_type == SO_TIMESTAMPNS) {
        timespec time{};
        std::memcpy(&time, CMSG_DATA(control), sizeof time);
        packet.real_ns = to_ns(time);
      } else if (control->cmsg_type == SO_TIMESTAMPING) {
        scm_timestamping times{};
        std::memcpy(&times, CMSG_DATA(control), sizeof times);
        packet.hardware_ns = to_ns(times.ts[2]);
      } else if (control->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&dropped_, CMSG_DATA(control), sizeof dropped_);
      }
    }
  }

  int descriptor_;
  std::string interface_;  // empty: a local socket
  std::uint32_t dropped_ = 0;
  std::array<mmsghdr, kBatch> messages_{};
  std::array<iovec, kBatch> pieces_{};
  std::array<Control, kBatch> controls_{};
};

Opened open_local(const std::string& interface) {
  const int descriptor = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (descriptor < 0) return failed(interface, "cannot make a socket", errno);
  auto socket = std::make_unique<KernelSocket>(descriptor);
  socket->ask_for_stamps_and_losses();
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  interface.copy(address.sun_path, sizeof address.sun_path - 1, kLocal.size());
  if (::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
    return failed(interface, "cannot connect", errno);
  return socket;
}

Opened open_interface(const std::string& interface, Filters filters, OwnFrames own) {
  const int descriptor = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
  if (descriptor < 0) {
    if (errno == EAFNOSUPPORT) return tl::unexpected(interface + ": this kernel has no CAN (modules can and can-raw)");
    return failed(interface, "cannot make a CAN socket", errno);
  }
  auto socket = std::make_unique<KernelSocket>(descriptor, interface);
  const unsigned index = ::if_nametoindex(interface.c_str());
  if (index == 0) return tl::unexpected(interface + ": there is no such interface");
  // Before binding, so that nothing unwanted is ever in the queue.
  if (!filters.empty() && filters.size() <= CAN_RAW_FILTER_MAX &&
      ::setsockopt(descriptor, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(filters.size_bytes())) != 0)
    return failed(interface, "cannot set the filters", errno);
  const can_err_mask_t all_errors = CAN_ERR_MASK;
  socket->set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, all_errors);
  socket->set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, 1);
  if (own == OwnFrames::returned) socket->set(SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 1);
  socket->ask_for_stamps_and_losses();
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = static_cast<int>(index);
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    if (errno == ENODEV) return tl::unexpected(interface + ": is not a CAN interface");
    return failed(interface, "cannot bind", errno);
  }
  return socket;
}

}  // namespace

Opened open_socket(const std::string& interface, Filters filters, OwnFrames own) {
  if (std::string fault = interface_fault(interface); !fault.empty()) return tl::unexpected(interface + ": " + fault);
  return interface.compare(0, kLocal.size(), kLocal) == 0 ? open_local(interface)
                                                          : open_interface(interface, filters, own);
}

std::string interface_fault(const std::string& interface) {
  if (interface.compare(0, kLocal.size(), kLocal) == 0) {
    constexpr std::size_t kLongest = sizeof(sockaddr_un::sun_path) - 1;
    if (interface.size() == kLocal.size()) return "the path is missing; expected unix:PATH";
    if (interface.size() - kLocal.size() > kLongest)
      return "the path is too long; expected at most " + std::to_string(kLongest) + " bytes";
    return {};
  }
  if (interface.empty() || interface.size() >= IFNAMSIZ || interface.find('/') != std::string::npos)
    return "is not the name of an interface; expected 1 to " + std::to_string(IFNAMSIZ - 1) +
           " characters, for instance can0, or unix:PATH";
  return {};
}

}  // namespace dwell::socketcan
