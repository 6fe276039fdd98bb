// Reads the results of a run file one at a time, in the order of the file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

// Bound to one thread. Memory: one result.
class StoredResults {
 public:
  // An entry as it is in the file. Parsing it would take as long as computing it, and is seldom needed.
  struct Entry {
    std::uint64_t position = 0;
    bool final = false;
    std::string body;
  };

  // Fails with "FILE: what is wrong".
  [[nodiscard]] static record::Result<StoredResults> open(const std::string& path);

  // The current result; null: there is none left, or error() says what is wrong with the next one.
  [[nodiscard]] const Entry* now() const noexcept { return now_ ? &*now_ : nullptr; }
  // Only if now() is not null.
  void next();
  [[nodiscard]] const std::string& error() const noexcept { return error_; }

 private:
  StoredResults(std::string path, record::ChainReader reader);

  std::string path_;
  record::ChainReader reader_;
  std::optional<Entry> now_;
  std::string error_;
};

}  // namespace dwell::ctl
