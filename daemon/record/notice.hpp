// A message of the recorder to the operator: one line for the log, the journal and the alarms.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace dwell::record {

struct Notice {
  enum class Grade : std::uint8_t { info, warning, error };
  Grade grade = Grade::info;
  std::string text;
  std::int64_t run = 0;  // the ledger's number of the run it is about; 0: none
  std::string head;      // of an anchor: hexadecimal
};

// Called on the recorder's thread; must not block.
using Tell = std::function<void(const Notice&)>;

}  // namespace dwell::record
