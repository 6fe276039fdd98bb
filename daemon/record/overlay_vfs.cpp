#include "daemon/record/overlay_vfs.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <utility>

namespace dwell::record {
namespace {

// Bytes 18 and 19 of a database say how it is written and read: 1 with a rollback journal, 2 with a -wal.
constexpr sqlite3_int64 kWriteVersion = 18;
constexpr sqlite3_int64 kReadVersion = 19;
constexpr unsigned char kWithWal = 2;

int read_log(int file, void* to, int size, std::uint64_t offset) {
  auto* at = static_cast<unsigned char*>(to);
  for (auto left = static_cast<std::size_t>(size); left > 0;) {
    const ssize_t got = ::pread(file, at, left, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return SQLITE_IOERR_READ;
    at += got;
    offset += static_cast<std::uint64_t>(got);
    left -= static_cast<std::size_t>(got);
  }
  return SQLITE_OK;
}

}  // namespace

// SQLite allocates it, with the bytes of the real file right after it.
struct OverlayVfs::File : sqlite3_file {
  OverlayVfs* owner;
  static File* of(sqlite3_file* file) { return static_cast<File*>(file); }
  sqlite3_file* real() { return reinterpret_cast<sqlite3_file*>(this + 1); }
};

OverlayVfs::OverlayVfs(int wal_file, std::function<bool()> stop)
    : parent_(sqlite3_vfs_find(nullptr)), vfs_(*parent_), wal_file_(wal_file), stop_(std::move(stop)) {
  name_ = "dwell-" + std::to_string(reinterpret_cast<std::uintptr_t>(this));
  vfs_.pNext = nullptr;
  vfs_.zName = name_.c_str();
  vfs_.szOsFile = static_cast<int>(sizeof(File)) + parent_->szOsFile;
  vfs_.pAppData = this;
  vfs_.xOpen = open;
  vfs_.xDelete = [](sqlite3_vfs*, const char*, int) { return SQLITE_READONLY; };
  // SQLite must find neither journal nor log.
  vfs_.xAccess = [](sqlite3_vfs*, const char*, int, int* there) {
    *there = 0;
    return SQLITE_OK;
  };
  vfs_.xFullPathname = [](sqlite3_vfs* vfs, const char* path, int size, char* to) {
    sqlite3_vfs* parent = static_cast<OverlayVfs*>(vfs->pAppData)->parent_;
    return parent->xFullPathname(parent, path, size, to);
  };
  sqlite3_vfs_register(&vfs_, 0);
}

OverlayVfs::~OverlayVfs() { sqlite3_vfs_unregister(&vfs_); }

int OverlayVfs::open(sqlite3_vfs* vfs, const char* path, sqlite3_file* file, int flags, int* out_flags) {
  auto* own = static_cast<OverlayVfs*>(vfs->pAppData);
  file->pMethods = nullptr;
  if ((flags & SQLITE_OPEN_MAIN_DB) == 0) return SQLITE_CANTOPEN;
  const int only_read = (flags & ~(SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE)) | SQLITE_OPEN_READONLY;
  File* opened = File::of(file);
  sqlite3_file* real = opened->real();
  // Opened through SQLite's own file system. If the writer were in this process, closing a descriptor of ours would
  // release its locks.
  int code = own->parent_->xOpen(own->parent_, path, real, only_read, out_flags);
  if (code == SQLITE_OK) code = own->take_log(real);
  if (code != SQLITE_OK) {
    if (real->pMethods != nullptr) real->pMethods->xClose(real);
    return code;
  }
  opened->owner = own;
  file->pMethods = &methods();
  return SQLITE_OK;
}

int OverlayVfs::take_log(sqlite3_file* database) {
  if (wal_file_ < 0) return SQLITE_OK;
  std::array<unsigned char, 100> header{};
  const int code = database->pMethods->xRead(database, header.data(), static_cast<int>(header.size()), 0);
  if (code != SQLITE_OK) return code == SQLITE_IOERR_SHORT_READ ? SQLITE_OK : code;
  if (header[kReadVersion] != kWithWal) {
    struct stat status {};
    if (::fstat(wal_file_, &status) == 0 && status.st_size > 0)
      altered_ = "a -wal lies beside it, and a closed file has none";
    return SQLITE_OK;
  }
  Result<WalView> log = WalView::read(wal_file_);
  // A frame that is being written looks damaged, but not for long.
  for (int again = 0; again < 2 && log && !log->altered().empty(); ++again) log = WalView::read(wal_file_);
  if (!log) {
    error_ = std::move(log.error());
    return SQLITE_CANTOPEN;
  }
  const std::uint32_t page_size = std::uint32_t{header[16]} << 8 | header[17];  // 1: 65536
  if (!log->empty() && log->page_size() != (page_size == 1 ? 65536u : page_size)) {
    altered_ = "the -wal has pages of another size: it belongs to another file";
    return SQLITE_OK;
  }
  wal_ = std::move(*log);
  altered_ = wal_.altered();
  return SQLITE_OK;
}

int OverlayVfs::read(sqlite3_file* file, void* to, int size, sqlite3_int64 offset) {
  File* opened = File::of(file);
  OverlayVfs& own = *opened->owner;
  own.stopped_ = own.stopped_ || (own.stop_ && own.stop_());
  if (own.stopped_) return SQLITE_IOERR_READ;
  std::uint64_t in_log = 0;
  if (!own.wal_.empty()) {
    const auto page = offset / own.wal_.page_size() + 1;
    const auto within = offset % own.wal_.page_size();
    if (page <= own.wal_.pages()) in_log = own.wal_.offset_of(static_cast<std::uint32_t>(page));
    if (in_log != 0) {
      if (within + size > own.wal_.page_size()) return SQLITE_IOERR_READ;
      in_log += static_cast<std::uint64_t>(within);
    }
  }
  sqlite3_file* real = opened->real();
  const int code =
      in_log != 0 ? read_log(own.wal_file_, to, size, in_log) : real->pMethods->xRead(real, to, size, offset);
  // So SQLite takes it for a file without a log.
  auto* bytes = static_cast<unsigned char*>(to);
  for (const sqlite3_int64 at : {kWriteVersion, kReadVersion})
    if (offset <= at && at < offset + size && bytes[at - offset] == kWithWal) bytes[at - offset] = 1;
  return code;
}

int OverlayVfs::size(sqlite3_file* file, sqlite3_int64* bytes) {
  const WalView& wal = File::of(file)->owner->wal_;
  if (!wal.empty()) {
    *bytes = static_cast<sqlite3_int64>(wal.pages()) * wal.page_size();
    return SQLITE_OK;
  }
  sqlite3_file* real = File::of(file)->real();
  return real->pMethods->xFileSize(real, bytes);
}

const sqlite3_io_methods& OverlayVfs::methods() {
  static const sqlite3_io_methods kMethods = [] {
    sqlite3_io_methods m{};
    m.iVersion = 1;
    m.xClose = [](sqlite3_file* file) {
      sqlite3_file* real = File::of(file)->real();
      return real->pMethods->xClose(real);
    };
    m.xRead = read;
    m.xWrite = [](sqlite3_file*, const void*, int, sqlite3_int64) { return SQLITE_READONLY; };
    m.xTruncate = [](sqlite3_file*, sqlite3_int64) { return SQLITE_READONLY; };
    m.xSync = [](sqlite3_file*, int) { return SQLITE_OK; };
    m.xFileSize = size;
    m.xLock = [](sqlite3_file*, int) { return SQLITE_OK; };
    m.xUnlock = [](sqlite3_file*, int) { return SQLITE_OK; };
    m.xCheckReservedLock = [](sqlite3_file*, int* held) {
      *held = 0;
      return SQLITE_OK;
    };
    m.xFileControl = [](sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; };
    m.xSectorSize = [](sqlite3_file*) { return 4096; };
    m.xDeviceCharacteristics = [](sqlite3_file*) { return SQLITE_IOCAP_IMMUTABLE; };
    return m;
  }();
  return kMethods;
}

}  // namespace dwell::record
