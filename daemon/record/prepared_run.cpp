#include "daemon/record/prepared_run.hpp"

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <string_view>

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

std::string PreparedRun::path_of(std::int64_t run) const {
  return directory_ + "/" + std::string(kFront) + std::to_string(run) + std::string(kBack);
}

void PreparedRun::make(std::int64_t run) {
  if (run_ == run) return;
  discard();
  run_ = run;
  // Copied: if no thread can be begun, whoever waits makes the file, and std::async loses what is moved into it.
  const auto create = [path = path_of(run)] { return ChainWriter::create_ahead(path, ChainSort::run); };
  made_ = std::async(create);
}

Result<ChainWriter> PreparedRun::take(std::int64_t run) {
  make(run);
  Result<ChainWriter> file = made_.get();
  run_ = 0;
  if (file) return file;
  return ChainWriter::create_ahead(path_of(run), ChainSort::run);
}

std::vector<std::int64_t> PreparedRun::left_over() const {
  std::vector<std::int64_t> runs;
  std::error_code failed;
  for (std::filesystem::directory_iterator entry(directory_, failed), none; !failed && entry != none;
       entry.increment(failed))
    if (const std::int64_t run = run_of(entry->path().filename().string()); run > 0) runs.push_back(run);
  return runs;
}

Result<std::optional<RunHeader>> PreparedRun::header_of(std::int64_t run) const {
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

void PreparedRun::remove(std::int64_t run) const noexcept {
  for (const char* part : {"-wal", ""}) unlink((path_of(run) + part).c_str());
}

void PreparedRun::discard() {
  if (run_ == 0) return;
  const bool made = made_.get().has_value();
  if (made) remove(run_);
  run_ = 0;
}

}  // namespace dwell::record
