#include "daemon/record/cut_off_run.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/last_entry.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

std::string file_of_run(const std::string& directory, std::int64_t run) {
  std::error_code failed;
  for (std::filesystem::directory_iterator entry(directory, failed), none; !failed && entry != none;
       entry.increment(failed)) {
    std::string name = entry->path().filename().string();
    if (run_of_file_name(name) == run) return name;
  }
  return {};
}

bool is_there(const std::string& directory, const std::string& name) {
  std::error_code failed;
  return std::filesystem::exists(directory + "/" + name, failed);
}

bool are_two_files(const std::string& a, const std::string& b) {
  struct stat one {
  }, other{};
  return lstat(a.c_str(), &one) == 0 && lstat(b.c_str(), &other) == 0 &&
         (one.st_dev != other.st_dev || one.st_ino != other.st_ino);
}

Result<FileEnd> end_of_file(const std::string& directory, CutOffRun run) {
  FileEnd found{std::move(run), {}, 0, false};
  auto reader = ChainReader::open(directory + "/" + found.run.file, ChainSort::run);
  if (!reader) return tl::unexpected(reader.error());
  const auto first = reader->next();
  if (!first) return tl::unexpected(first.error());
  if (!*first) return found;
  const auto last = last_entry(*reader);
  if (!last) return tl::unexpected(last.error());
  found.head = hex(last->head);
  found.seq = last->entry.seq;
  found.closed = last->entry.kind == "end" || last->entry.kind == "signature";
  const auto header = parse_run_header((*first)->entry.body);
  if (header) {
    const auto read = RunReader::open(directory + "/" + found.run.file);
    found.run.label = read ? read->header().label : header->label;
    found.run.comment = header->comment;
  }
  const auto began_ns = header ? parse_utc(header->start_utc) : tl::unexpected(header.error());
  if (began_ns) found.run.until_utc = iso_utc(*began_ns + last->entry.t_ns - (*first)->entry.t_ns);
  return found;
}

}  // namespace dwell::record
