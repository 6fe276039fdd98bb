#include "tests/record/power/block_log.hpp"

#include <fcntl.h>
#include <linux/dm-ioctl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace dwell::record {
namespace {

// drivers/md/dm-log-writes.c; all little-endian.
constexpr std::uint64_t kMagic = 0x6a736677736872;
constexpr std::uint64_t kFlush = 1, kDiscard = 4, kMark = 8;
struct Super {
  std::uint64_t magic, version, entries;
  std::uint32_t sector_bytes;
};
struct LogEntry {
  std::uint64_t sector, sectors, flags, text_bytes;
};

}  // namespace

tl::expected<void, std::string> mark_block_log(const std::string& name, const std::string& text) {
  const std::string message = "mark " + text;
  std::vector<char> bytes(sizeof(dm_ioctl) + sizeof(dm_target_msg) + message.size() + 1, '\0');
  dm_ioctl head{};
  head.version[0] = DM_VERSION_MAJOR;
  head.data_size = static_cast<std::uint32_t>(bytes.size());
  head.data_start = sizeof head;
  std::strncpy(head.name, name.c_str(), sizeof head.name - 1);
  std::memcpy(bytes.data(), &head, sizeof head);
  std::memcpy(bytes.data() + sizeof head + sizeof(dm_target_msg), message.c_str(), message.size());
  const int control = ::open("/dev/mapper/control", O_RDWR | O_CLOEXEC);
  if (control < 0) return fails(std::string("/dev/mapper/control: ") + std::strerror(errno));
  const bool done = ::ioctl(control, DM_TARGET_MSG, bytes.data()) == 0;
  const int error = errno;
  ::close(control);
  if (!done) return fails(name + ": no mark in its log: " + std::strerror(error));
  return {};
}

tl::expected<void, std::string> read_block_log(const std::string& log, const std::string& mark,
                                               const std::function<void(const LoggedWrite&)>& take) {
  std::ifstream file(log, std::ios::binary);
  Super super{};
  file.read(reinterpret_cast<char*>(&super), sizeof super);
  if (!file || super.magic != kMagic || super.version != 1) return fails(log + ": no log of dm-log-writes");
  std::vector<char> sector(super.sector_bytes), bytes;
  file.seekg(super.sector_bytes);
  bool lasting = true;
  for (std::uint64_t n = 0; n < super.entries; ++n) {
    file.read(sector.data(), static_cast<std::streamsize>(sector.size()));
    LogEntry entry{};
    std::memcpy(&entry, sector.data(), sizeof entry);
    if ((entry.flags & kMark) != 0) {
      const std::string text(sector.data() + sizeof entry, entry.text_bytes);
      if (text == mark) lasting = false;
      continue;
    }
    bytes.resize((entry.flags & kDiscard) != 0 ? 0 : entry.sectors * super.sector_bytes);
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file) return fails(log + ": ends amid entry " + std::to_string(n));
    if (!bytes.empty()) take({entry.sector * super.sector_bytes, bytes, lasting});
    if (!lasting && (entry.flags & kFlush) != 0) return {};
  }
  if (lasting) return fails(log + ": holds no mark " + mark);
  return {};
}

}  // namespace dwell::record
