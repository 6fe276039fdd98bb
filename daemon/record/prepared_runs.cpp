#include "daemon/record/prepared_runs.hpp"

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <iterator>
#include <string_view>

#include "daemon/record/file_name.hpp"

namespace dwell::record {
namespace {

constexpr std::string_view kFront = "next-", kBack = ".new";

// 0: not the name of a prepared file.
std::int64_t run_of(std::string_view name) {
  if (name.size() <= kFront.size() + kBack.size() || name.substr(0, kFront.size()) != kFront ||
      name.substr(name.size() - kBack.size()) != kBack)
    return 0;
  const char* const end = name.data() + name.size() - kBack.size();
  std::int64_t run = 0;
  const auto [stopped, error] = std::from_chars(name.data() + kFront.size(), end, run);
  return error == std::errc{} && stopped == end && run > 0 ? run : 0;
}

}  // namespace

std::string PreparedRuns::path_of(std::int64_t run) const { return directory_ + "/" + first_name_of_run(run); }

void PreparedRuns::make(std::int64_t run) {
  for (auto one = made_.begin(); one != made_.end();)
    one = one->first >= run && one->first < run + kAhead ? std::next(one) : discard(one);
  for (std::int64_t number = run; number < run + kAhead; ++number) {
    if (made_.contains(number)) continue;
    // Copied: if no thread can be begun, whoever waits makes the file, and std::async loses what is moved into it.
    const auto create = [path = path_of(number)] { return ChainWriter::create_ahead(path, ChainSort::run); };
    made_.emplace(number, std::async(create));
  }
}

Result<ChainWriter> PreparedRuns::take(std::int64_t run) {
  make(run);
  const auto own = made_.find(run);
  Result<ChainWriter> file = own->second.get();
  made_.erase(own);
  if (file) return file;
  return ChainWriter::create_ahead(path_of(run), ChainSort::run);
}

std::vector<std::int64_t> PreparedRuns::left_over() const {
  std::vector<std::int64_t> runs;
  std::error_code failed;
  for (std::filesystem::directory_iterator entry(directory_, failed), none; !failed && entry != none;
       entry.increment(failed))
    if (const std::int64_t run = run_of(entry->path().filename().string()); run > 0) runs.push_back(run);
  return runs;
}

Result<std::optional<RunHeader>> PreparedRuns::header_of(std::int64_t run) const {
  const std::string path = path_of(run);
  const auto unclear = [](const std::string& why) {
    return tl::unexpected(why + "; it may hold a run: move it elsewhere");
  };
  auto reader = ChainReader::open(path, ChainSort::run);
  if (!reader) return unclear(reader.error());
  const auto first = reader->next();
  if (!first) return unclear(first.error());
  if (!*first) return std::nullopt;
  auto header = parse_run_header((*first)->entry.body);
  if (!header) return unclear(path + ": " + header.error());
  return std::move(*header);
}

void PreparedRuns::remove(std::int64_t run) const noexcept {
  for (const char* part : {"-wal", ""}) unlink((path_of(run) + part).c_str());
}

void PreparedRuns::discard() {
  for (auto one = made_.begin(); one != made_.end();) one = discard(one);
}

PreparedRuns::Made::iterator PreparedRuns::discard(Made::iterator one) {
  if (one->second.get()) remove(one->first);
  return made_.erase(one);
}

}  // namespace dwell::record
