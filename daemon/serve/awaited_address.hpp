// An address to listen on that this computer may not have yet: a cable or a lease comes later than the service.
#pragma once

#include <string>
#include <utility>

namespace dwell {

// Bound to one thread.
class AwaitedAddress {
 public:
  // host: a numeric address or "localhost". awaited: it was not there when it was bound.
  AwaitedAddress(std::string host, bool awaited) : host_(std::move(host)), awaited_(awaited) {}

  // Whether it has not been there yet: until then nobody can be served. Asks the kernel, in three system calls, until
  // it has.
  [[nodiscard]] bool awaited() noexcept;

 private:
  std::string host_;
  bool awaited_;
};

}  // namespace dwell
