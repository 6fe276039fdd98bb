#include "daemon/ctl/stored_results.hpp"

#include <charconv>
#include <string_view>
#include <utility>

namespace dwell::ctl {

std::optional<StoredResults::Entry> front_of(const std::string& body) {
  static constexpr std::string_view position = R"({"position":)", yes = R"(,"final":true,"dwell":)",
                                    no = R"(,"final":false,"dwell":)";
  const std::string_view text = body;
  if (text.substr(0, position.size()) != position) return std::nullopt;
  StoredResults::Entry entry;
  const char* const digits = text.data() + position.size();
  const auto [end, code] = std::from_chars(digits, text.data() + text.size(), entry.position);
  if (code != std::errc{}) return std::nullopt;
  const std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
  entry.final = rest.substr(0, yes.size()) == yes;
  if (!entry.final && rest.substr(0, no.size()) != no) return std::nullopt;
  return entry;
}

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
    now_ = front_of(body);
    if (!now_) {
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
