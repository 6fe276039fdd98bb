// An address to listen on that this computer may not have yet: a cable or a lease may come later than the service.
#pragma once

#include <string>
#include <utility>

namespace dwell {

// Bound to one thread.
class AwaitedAddress {
 public:
  // host: a numeric address or "localhost". awaited: this computer did not have it when it was bound.
  AwaitedAddress(std::string host, bool awaited) : host_(std::move(host)), awaited_(awaited) {}

  // True until this computer has had the address; nobody can be served before. Costs three system calls while it is
  // true, none afterwards.
  [[nodiscard]] bool awaited() noexcept;

 private:
  std::string host_;
  bool awaited_;
};

}  // namespace dwell
