#include "daemon/handon/output_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/record/file_name.hpp"
#include "daemon/record/keys.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kBuffer = 1U << 18U;

std::string why() { return std::generic_category().message(errno); }

// Whether its content is that of a run file or a ledger, whatever it is called.
bool is_of_the_record(const std::string& path) {
  constexpr std::string_view kMagic{"SQLite format 3\0", 16};
  constexpr std::size_t kApplicationId = 68;  // its place in SQLite's header; four bytes, the highest first
  std::array<char, 100> header{};
  const auto file = record::open_regular(path);
  if (!file || ::pread(file->get(), header.data(), header.size(), 0) != static_cast<ssize_t>(header.size()))
    return false;
  const std::string_view bytes(header.data(), header.size());
  const std::string_view id = bytes.substr(kApplicationId, 4);
  return bytes.substr(0, kMagic.size()) == kMagic && (id == "DWLL" || id == "DWLG");
}

tl::unexpected<record::Failure> refuse(const std::string& path, const std::string& found) {
  return tl::make_unexpected(record::Failure(path + ": " + found + "; expected the name of another file"));
}

bool has_extension_of_run(const std::string& path) {
  return std::filesystem::path(path).extension().string().rfind(record::kRunSuffix, 0) == 0;
}

// What holds for every file, whether one is there or not.
record::Result<void> may_have_name(const std::string& path) {
  if (path == "-") return refuse(path, "standard output is no file: what is written is complete or not there at all");
  const std::filesystem::path name(path), folder = name.has_parent_path() ? name.parent_path() : ".";
  std::error_code none;
  if (const std::string what = record::kept_by_service(name.filename().string());
      !what.empty() && std::filesystem::exists(record::ledger_in(folder.string()), none))
    return refuse(path, "has the name of " + what);
  return {};
}

// Without `overwrite`, a file that has appeared meanwhile stays. Not every file system can do that in one step; the
// file then has both names for a moment.
bool give_name(const std::string& from, const std::string& to, bool overwrite) {
  if (!overwrite) {
    if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
    if (errno != EINVAL && errno != ENOSYS) return false;
  }
  if (overwrite) return std::rename(from.c_str(), to.c_str()) == 0;
  if (::link(from.c_str(), to.c_str()) != 0) return false;
  ::unlink(from.c_str());
  return true;
}

// false: it is being written elsewhere. The other writer may already have renamed the file that was opened here, so
// `part` must still be that file. Where a file system knows no locks, it counts as free.
bool take_part(const record::OpenFile& file, const std::string& part) {
  if (::flock(file.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return false;
  struct stat own {
  }, there{};
  return ::fstat(file.get(), &own) == 0 && ::lstat(part.c_str(), &there) == 0 && own.st_ino == there.st_ino &&
         own.st_dev == there.st_dev;
}

}  // namespace

record::Result<void> may_write(const Target& target) {
  if (auto may = may_have_name(target.path); !may) return may;
  const auto refused = [&target](const char* found) { return refuse(target.path, found); };
  // NAME.dwell, NAME.dwell-wal, ledger.dwell-ledger: even a new file of such a name would make a run look altered.
  if (has_extension_of_run(target.path))
    return refused("has the name of a run file or of a file beside one: its extension begins with .dwell");
  struct stat status {};
  if (::lstat(target.path.c_str(), &status) != 0) return {};  // what else is wrong with it, opening tells
  if (S_ISDIR(status.st_mode)) return refused("is a directory");
  if (S_ISLNK(status.st_mode)) return refused("is a link");
  if (!S_ISREG(status.st_mode)) return refused("is no regular file");
  if (is_of_the_record(target.path)) return refused("is a run file or a ledger");
  if (record::SigningKey::is_at(target.path)) return refused("is a private key");
  if (!target.overwrite)
    return tl::make_unexpected(target.path + ": exists already; expected a new name, or --overwrite");
  return {};
}

record::Result<void> may_make_run(const std::string& path) {
  if (auto may = may_have_name(path); !may) return may;
  if (has_extension_of_run(path) && std::filesystem::path(path).extension() != record::kRunSuffix)
    return refuse(path, "has the name of a file beside a run");
  struct stat status {};
  if (::lstat(path.c_str(), &status) == 0) return tl::make_unexpected(path + ": exists already; expected a new name");
  return {};
}

record::Result<OutputFile> OutputFile::create(const Target& target) {
  if (auto may = may_write(target); !may) return tl::make_unexpected(may.error());
  std::string part = target.path + ".part";  // may be left of a program that was killed
  if (auto may = may_write({part, true}); !may) return tl::make_unexpected(may.error());
  auto file = record::open_regular(part, O_RDWR | O_CREAT | O_NOFOLLOW, 0666);
  if (!file) {  // its error begins with the name of the part, which nobody gave
    const std::string reason = file.error().substr(part.size() + 2);
    return tl::make_unexpected(target.path + ": cannot be written: " + reason);
  }
  if (!take_part(*file, part)) return tl::make_unexpected(target.path + ": is being written already");
  if (::ftruncate(file->get(), 0) != 0) return tl::make_unexpected(target.path + ": cannot be written: " + why());
  return OutputFile(target, std::move(part), std::move(*file));
}

OutputFile::OutputFile(Target target, std::string part, record::OpenFile file)
    : path_(std::move(target.path)), part_(std::move(part)), overwrite_(target.overwrite), file_(std::move(file)) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::move(other.part_)),
      buffer_(std::move(other.buffer_)),
      error_(std::move(other.error_)),
      overwrite_(other.overwrite_),
      end_(other.end_),
      file_(std::move(other.file_)) {}

OutputFile::~OutputFile() {
  if (file_) ::unlink(part_.c_str());
}

void OutputFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= kBuffer) flush();
}

void OutputFile::flush() {
  write_at(end_, buffer_);
  end_ += static_cast<std::int64_t>(buffer_.size());
  buffer_.clear();
}

void OutputFile::write_at(std::int64_t place, std::string_view bytes) {
  while (error_.empty() && !bytes.empty()) {
    const ssize_t written = ::pwrite(file_.get(), bytes.data(), bytes.size(), place);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      error_ = path_ + ": cannot be written: " + why();
      return;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
    place += written;
  }
}

record::Result<void> OutputFile::keep() {
  flush();
  if (error_.empty() && ::fdatasync(file_.get()) != 0 && errno != EINVAL)
    error_ = path_ + ": cannot be written: " + why();
  if (error_.empty() && !give_name(part_, path_, overwrite_)) error_ = path_ + ": cannot be given its name: " + why();
  if (!error_.empty()) return tl::make_unexpected(error_);
  file_ = record::OpenFile();
  return {};
}

}  // namespace dwell::handon
