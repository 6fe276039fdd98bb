#include "daemon/ctl/stored_results.hpp"

#include <utility>

#include "daemon/record/result_text.hpp"

namespace dwell::ctl {
namespace {

using record::Result;

constexpr std::size_t kResultsAhead = 8;

Result<StoredResults::Entry> result_in(record::Entry&& entry, const std::string& path) {
  StoredResults::Entry result;
  if (const auto front = record::front_of(entry.body)) {
    result = {front->position, front->final, {}};
  } else {
    const auto parsed = record::parse_result(entry.body);
    if (!parsed) return tl::unexpected(path + ": entry " + std::to_string(entry.seq) + ": " + parsed.error());
    result = {parsed->position, parsed->final, {}};
  }
  result.body = std::move(entry.body);
  return result;
}

}  // namespace

Result<StoredResults> StoredResults::open(const std::string& path) {
  auto opened = record::ChainReader::open(path, record::ChainSort::run);
  if (!opened) return tl::unexpected(opened.error());
  const auto reader = std::make_shared<record::ChainReader>(std::move(*opened));
  reader->seek(1, "result");
  const auto read = [reader, path, failed = false]() mutable -> std::optional<Result<Entry>> {
    if (failed) return std::nullopt;
    auto row = reader->next();
    if (row && !*row) return std::nullopt;
    Result<Entry> result = row ? result_in(std::move((*row)->entry), path) : tl::unexpected(row.error());
    failed = !result;
    return result;
  };
  StoredResults results(std::make_unique<Reading>(read, kResultsAhead));
  if (!results.error_.empty()) return tl::unexpected(results.error_);
  return results;
}

StoredResults::StoredResults(std::unique_ptr<Reading> reading) : reading_(std::move(reading)) { next(); }

void StoredResults::next() {
  now_.reset();
  auto result = reading_->next();
  if (!result) return;
  if (*result)
    now_ = std::move(**result);
  else
    error_ = std::move(result->error());
}

}  // namespace dwell::ctl
