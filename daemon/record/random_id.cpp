#include "daemon/record/random_id.hpp"

#include <sys/random.h>

#include "daemon/record/digest.hpp"

namespace dwell::record {

Result<std::string> random_id() {
  Digest bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
    return tl::unexpected(std::string("the system yields no random numbers"));
  return hex(bytes).substr(0, 32);
}

}  // namespace dwell::record
