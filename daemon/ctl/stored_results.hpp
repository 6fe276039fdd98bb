// Reads the results of a run file one at a time, in the order of the file.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "daemon/record/ahead.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

// Bound to one thread; another one of its own reads ahead. Memory: ten results.
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

  // The current result. Null: none is left, or reading failed; then error() says why.
  [[nodiscard]] const Entry* now() const noexcept { return now_ ? &*now_ : nullptr; }
  // Only if now() is not null.
  void next();
  // Moves the current result to the caller and leaves an empty one until next(). Only if now() is not null.
  [[nodiscard]] Entry take() { return std::exchange(*now_, {}); }
  [[nodiscard]] const record::Failure& error() const noexcept { return error_; }

 private:
  using Reading = record::Ahead<record::Result<Entry>>;

  explicit StoredResults(std::unique_ptr<Reading> reading);

  std::unique_ptr<Reading> reading_;
  std::optional<Entry> now_;
  record::Failure error_{""};
};

}  // namespace dwell::ctl
