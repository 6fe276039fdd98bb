#include "drivers/modbus/connect.hpp"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/select.h>
#include <sys/socket.h>

#include <utility>

namespace dwell::modbus {
namespace {

using driver::Stop;

struct Addresses {
  addrinfo* list = nullptr;
  Addresses() = default;
  ~Addresses() {
    if (list != nullptr) ::freeaddrinfo(list);
  }
  Addresses(const Addresses&) = delete;
  Addresses& operator=(const Addresses&) = delete;
};

int look_up(const std::string& host, const std::string& port, int flags, Addresses& addresses) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = flags | AI_NUMERICSERV;
  return ::getaddrinfo(host.c_str(), port.c_str(), &hints, &addresses.list);
}

std::string text_of(int code) { return std::generic_category().message(code); }

// One attempt; -1: `error` says why.
int connect_to(const addrinfo& address, std::int64_t deadline_ns, const Stop& stop, std::string& error) {
  const int descriptor = ::socket(address.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, address.ai_protocol);
  if (descriptor < 0) {
    error = text_of(errno);
    return -1;
  }
  const auto give_up = [&](std::string why) {
    error = std::move(why);
    ::close(descriptor);
    return -1;
  };
  // libmodbus calls select(), which a larger descriptor would make write beyond its set.
  if (descriptor >= FD_SETSIZE) return give_up("too many files are open in this program");
  const int yes = 1;
  ::setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
  if (::connect(descriptor, address.ai_addr, address.ai_addrlen) == 0) return descriptor;
  if (errno != EINPROGRESS) return give_up(text_of(errno));
  switch (stop.wait(descriptor, POLLOUT, deadline_ns)) {
    case Stop::Wait::ready:
      break;
    case Stop::Wait::timeout:
      return give_up("the device does not answer");
    case Stop::Wait::stopped:
      return give_up("stopped");
  }
  int code = 0;
  socklen_t size = sizeof code;
  ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &code, &size);
  return code == 0 ? descriptor : give_up(text_of(code));
}

}  // namespace

// A name being looked up by a thread of its own, as getaddrinfo cannot be interrupted; shared, so that either may go
// first.
struct Connector::Lookup {
  Lookup() : done(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (done < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  ~Lookup() { ::close(done); }
  Lookup(const Lookup&) = delete;
  Lookup& operator=(const Lookup&) = delete;

  int done;
  int code = 0;
  Addresses addresses;
};

Connector::Connector(std::string host, int port) : host_(std::move(host)), port_(std::to_string(port)) {}
Connector::~Connector() = default;

int Connector::connect(std::int64_t deadline_ns, const Stop& stop, std::string& error) {
  Addresses numeric;
  std::shared_ptr<Lookup> named;
  if (look_up(host_, port_, AI_NUMERICHOST, numeric) != 0) {
    if (!lookup_) {
      lookup_ = std::make_shared<Lookup>();
      std::thread([lookup = lookup_, host = host_, port = port_] {
        lookup->code = look_up(host, port, 0, lookup->addresses);
        const std::uint64_t one = 1;
        [[maybe_unused]] const auto written = ::write(lookup->done, &one, sizeof one);
      }).detach();
    }
    if (stop.wait(lookup_->done, POLLIN, deadline_ns) != Stop::Wait::ready) {
      error = "the name `" + host_ + "` is still being looked up";
      return -1;
    }
    named = std::exchange(lookup_, nullptr);
    if (named->code != 0) {
      error = "the name `" + host_ + "`: " + ::gai_strerror(named->code);
      return -1;
    }
  }
  int descriptor = -1;
  for (const addrinfo* address = named ? named->addresses.list : numeric.list;
       address != nullptr && descriptor < 0 && !stop.requested(); address = address->ai_next)
    descriptor = connect_to(*address, deadline_ns, stop, error);
  return descriptor;
}

}  // namespace dwell::modbus
