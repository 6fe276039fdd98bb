#include "daemon/record/run_list.hpp"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/last_entry.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {
namespace {

std::uint64_t size_of(const std::string& path) {
  std::error_code failed;
  const auto bytes = std::filesystem::file_size(path, failed);
  return failed ? 0 : bytes;
}

// Fails where the file is damaged.
Result<std::uint64_t> ended_dwells(RunReader& reader) {
  std::uint64_t dwells = 0;
  const auto read = reader.results(true, [&](const StoredResult&) {
    ++dwells;
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  return dwells;
}

// Leaves the state as it is if the file cannot be read to its end.
Result<void> fill(ListedRun& listed, const std::string& path) {
  auto reader = RunReader::open(path);
  if (!reader) return tl::unexpected(reader.error());
  const RunHeader& header = reader->header();
  listed.run = header.run;
  listed.label = header.label;
  listed.begun_by = header.begun_by;
  listed.begun_utc = header.start_utc;
  listed.clock_synchronized = header.origin.clock_synchronized;
  const auto dwells = ended_dwells(*reader);
  if (!dwells) return tl::unexpected(dwells.error());
  auto entries = ChainReader::open(path, ChainSort::run);
  if (!entries) return tl::unexpected(entries.error());
  const auto last = last_entry(*entries);
  if (!last) return tl::unexpected(last.error());
  listed.dwells = *dwells;
  listed.state = reader->end() ? "closed" : "cut off";
  listed.samples = reader->end() ? reader->end()->samples : 0;
  listed.ended_utc = reader->ended_utc();
  listed.head = hex(last->head);
  return {};
}

bool comes_before(const ListedRun& a, const ListedRun& b) { return a.run != b.run ? a.run < b.run : a.file < b.file; }

}  // namespace

ListedRun look_at_run(const std::string& directory, const std::string& name) {
  const std::string path = directory + "/" + name;
  ListedRun listed;
  listed.run = run_of_file_name(name);
  listed.file = name;
  listed.state = "unreadable";
  listed.bytes = size_of(path) + size_of(path + "-wal");
  std::error_code failed;
  listed.linked = std::filesystem::is_symlink(path, failed);
  listed.kept = is_kept(directory, name);
  [[maybe_unused]] const auto read = read_until_whole([&] { return fill(listed, path); });
  return listed;
}

void look_at_runs(const std::string& directory, const std::string& running, const std::function<void(ListedRun)>& take,
                  const std::function<bool()>& stop) {
  std::vector<std::string> names;
  std::error_code failed;
  for (std::filesystem::directory_iterator entry(directory, failed), none; !failed && entry != none;
       entry.increment(failed)) {
    std::string name = entry->path().filename().string();
    if (run_of_file_name(name) > 0 && name != running) names.push_back(std::move(name));
  }
  // The newest first: people ask for them first.
  std::sort(names.begin(), names.end(),
            [](const auto& a, const auto& b) { return run_of_file_name(a) > run_of_file_name(b); });
  for (const std::string& name : names) {
    if (stop()) return;
    take(look_at_run(directory, name));
  }
}

bool is_kept(const std::string& directory, const std::string& name) {
  std::error_code failed;
  return std::filesystem::exists(directory + "/" + name + std::string(kKeepSuffix), failed) || failed;
}

void RunList::put(ListedRun run) {
  const std::lock_guard lock(mutex_);
  auto runs = std::make_shared<ListedRuns>(*runs_);
  const auto old = std::find_if(runs->begin(), runs->end(), [&](const ListedRun& r) { return r.file == run.file; });
  if (old != runs->end()) runs->erase(old);
  runs->insert(std::upper_bound(runs->begin(), runs->end(), run, comes_before), std::move(run));
  if (runs->size() > kListed) runs->erase(runs->begin());
  runs_ = std::move(runs);
}

void RunList::remove(const std::string& file) {
  const std::lock_guard lock(mutex_);
  auto runs = std::make_shared<ListedRuns>(*runs_);
  runs->erase(std::remove_if(runs->begin(), runs->end(), [&](const ListedRun& r) { return r.file == file; }),
              runs->end());
  runs_ = std::move(runs);
}

std::shared_ptr<const ListedRuns> RunList::all() const {
  const std::lock_guard lock(mutex_);
  return runs_;
}

}  // namespace dwell::record
