// The results that a run file holds, one at a time in the order of the file.
#pragma once

#include <optional>
#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

// Bound to one thread. Memory: one result.
class StoredResults {
 public:
  // Fails with "FILE: what is wrong".
  [[nodiscard]] static record::Result<StoredResults> open(const std::string& path);

  // The result at hand; null: there is none left, or error() says what is wrong with the next one.
  [[nodiscard]] const record::StoredResult* now() const noexcept { return now_ ? &*now_ : nullptr; }
  // Only if now() is not null.
  void next();
  [[nodiscard]] const std::string& error() const noexcept { return error_; }

 private:
  StoredResults(std::string path, record::ChainReader reader);

  std::string path_;
  record::ChainReader reader_;
  std::optional<record::StoredResult> now_;
  std::string error_;
};

}  // namespace dwell::ctl
