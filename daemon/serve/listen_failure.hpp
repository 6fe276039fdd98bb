// Why an address of the rig file cannot be listened on.
#pragma once

#include <string>

namespace dwell {

struct ListenFailure {
  bool bad_address = false;  // what was asked for is not an address; else it cannot be had
  std::string message;
};

}  // namespace dwell
