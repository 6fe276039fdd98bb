#include "daemon/ctl/stored_results.hpp"

#include <utility>

namespace dwell::ctl {

record::Result<StoredResults> StoredResults::open(const std::string& path) {
  auto reader = record::ChainReader::open(path, record::ChainSort::run);
  if (!reader) return tl::unexpected(reader.error());
  reader->seek(1, "result");
  StoredResults results(path, std::move(*reader));
  if (!results.error_.empty()) return tl::unexpected(results.error_);
  return results;
}

StoredResults::StoredResults(std::string path, record::ChainReader reader)
    : path_(std::move(path)), reader_(std::move(reader)) {
  next();
}

void StoredResults::next() {
  now_.reset();
  auto row = reader_.next();
  if (!row) {
    error_ = row.error();
  } else if (*row) {
    auto result = record::parse_result((*row)->entry.body);
    if (result) {
      now_ = std::move(*result);
    } else {
      error_ = path_ + ": entry " + std::to_string((*row)->entry.seq) + ": " + result.error();
    }
  }
}

}  // namespace dwell::ctl
