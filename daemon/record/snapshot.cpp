#include "daemon/record/snapshot.hpp"

#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/overlay_vfs.hpp"
#include "daemon/record/regular_file.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {
namespace {

using WalHeader = std::array<unsigned char, 32>;

WalHeader header_of(int wal_file) {
  WalHeader header{};
  if (wal_file >= 0 && ::pread(wal_file, header.data(), header.size(), 0) < 0) header.fill(0xff);
  return header;
}

bool same_file(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino && a.st_size == b.st_size &&
         a.st_mtim.tv_sec == b.st_mtim.tv_sec && a.st_mtim.tv_nsec == b.st_mtim.tv_nsec;
}

// Attempts to open that a writer may spoil before opening fails, and the pause between two of them: 3 s in all. A
// writer closes a file only once, but that takes three waits for the disk. Halved: with a slow disk opening may fail.
// Doubled: a file that is written to all the time fails later.
constexpr int kTries = 60;
constexpr std::chrono::milliseconds kPause{50};

}  // namespace

struct Snapshot::Impl {
  std::string path;
  OpenFile wal_file;
  struct stat database_status {};
  WalHeader wal_header{};  // zero: the log is empty
  std::string journal;     // what is wrong with a -journal; empty: there is none
  std::unique_ptr<OverlayVfs> vfs;
  Database database;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    database.reset();
    vfs.reset();
  }

  // Locks the log, if there is one, and remembers what must not change.
  Result<void> hold() {
    const std::string wal = path + "-wal";
    Result<OpenFile> opened = open_regular_if_there(wal);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    wal_file = std::move(*opened);
    // On a file system without locks there is no writer of ours either.
    while (wal_file && ::flock(wal_file.get(), LOCK_SH) != 0 && errno == EINTR) continue;
    if (::stat(path.c_str(), &database_status) != 0) return tl::unexpected(path + ": " + std::strerror(errno));
    wal_header = header_of(wal_file.get());
    std::error_code none;
    if (std::filesystem::exists(std::filesystem::symlink_status(path + "-journal", none)))
      journal = "a -journal lies beside it, and neither a run nor a ledger ever has one";
    return expect_regular(path);
  }

  Result<void> connect(const std::function<bool()>& stop) {
    vfs = std::make_unique<OverlayVfs>(wal_file.get(), stop);
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, vfs->name());
    database.reset(opened);
    if (code != SQLITE_OK)
      return tl::unexpected(vfs->error().empty() ? sqlite_error(opened, path) : path + ": " + vfs->error());
    // Nothing that the file defines (triggers, views) is run, and no value may be larger than an entry.
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(ChainReader::kMaxBody) + 65536);
    // The first statement reads the header, and with it the log.
    if (!execute(opened, "PRAGMA cell_size_check = ON; PRAGMA user_version"))
      return tl::unexpected(vfs->error().empty() ? sqlite_error(opened, path) : path + ": " + vfs->error());
    return {};
  }

  [[nodiscard]] bool unchanged() const {
    struct stat now {
    }, wal_now{};
    if (::stat(path.c_str(), &now) != 0 || !same_file(now, database_status)) return false;
    // A log that appeared later belongs to a later state.
    if (!wal_file) return true;
    return ::fstat(wal_file.get(), &wal_now) == 0 && wal_now.st_nlink > 0 &&
           (wal_header == WalHeader{} || header_of(wal_file.get()) == wal_header);
  }
};

Snapshot::Snapshot(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Snapshot::Snapshot(Snapshot&&) noexcept = default;
Snapshot& Snapshot::operator=(Snapshot&&) noexcept = default;
Snapshot::~Snapshot() = default;

Result<Snapshot> Snapshot::open(const std::string& path, const std::function<bool()>& stop) {
  std::error_code code;
  // The log lies beside the file itself, not beside a link to it.
  const std::filesystem::path real = std::filesystem::canonical(path, code);
  if (code) return tl::unexpected(path + ": " + code.message());
  for (int tries = 1;; ++tries) {
    auto impl = std::make_unique<Impl>();
    impl->path = real.string();
    if (Result<void> held = impl->hold(); !held) return tl::unexpected(std::move(held.error()));
    Result<void> done = impl->connect(stop);
    if (impl->vfs->stopped()) return fails({path + ": reading was given up", Cause::stopped});
    if (impl->unchanged()) {
      if (!done) return tl::unexpected(std::move(done.error()));
      return Snapshot(std::move(impl));
    }
    if (tries == kTries) return fails(read_again(path + ": "));
    std::this_thread::sleep_for(kPause);
  }
}

sqlite3* Snapshot::database() const noexcept { return impl_->database.get(); }
const std::string& Snapshot::path() const noexcept { return impl_->path; }
bool Snapshot::unchanged() const noexcept { return impl_->unchanged(); }
bool Snapshot::stopped() const noexcept { return impl_->vfs->stopped(); }
const std::string& Snapshot::altered() const noexcept {
  return impl_->journal.empty() ? impl_->vfs->altered() : impl_->journal;
}

}  // namespace dwell::record
