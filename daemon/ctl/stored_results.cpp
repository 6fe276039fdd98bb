#include "daemon/ctl/stored_results.hpp"

#include <utility>

#include "daemon/record/result_text.hpp"

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
    std::string& body = (*row)->entry.body;
    if (const auto front = record::front_of(body)) {
      now_ = Entry{front->position, front->final, {}};
    } else {
      const auto result = record::parse_result(body);
      if (!result) {
        error_ = path_ + ": entry " + std::to_string((*row)->entry.seq) + ": " + result.error();
        return;
      }
      now_ = Entry{result->position, result->final, {}};
    }
    now_->body = std::move(body);
  }
}

}  // namespace dwell::ctl
