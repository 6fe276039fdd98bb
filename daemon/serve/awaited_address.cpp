#include "daemon/serve/awaited_address.hpp"

#include <netdb.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

namespace dwell {

bool AwaitedAddress::awaited() noexcept {
  if (!awaited_) return false;
  addrinfo numeric{};
  numeric.ai_flags = AI_NUMERICHOST | AI_PASSIVE;
  numeric.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (getaddrinfo(host_.c_str(), nullptr, &numeric, &found) != 0) return true;
  const int probe = socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (probe >= 0) {
    awaited_ = bind(probe, found->ai_addr, found->ai_addrlen) != 0 && errno == EADDRNOTAVAIL;
    close(probe);
  }
  freeaddrinfo(found);
  return awaited_;
}

}  // namespace dwell
