#include "daemon/record/key_file.hpp"

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "daemon/record/directory_lock.hpp"
#include "daemon/record/small_file.hpp"

namespace dwell::record {
namespace {

std::string next_path(const std::string& directory) { return directory + "/key.next"; }

bool exists(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

Result<void> write_public(const std::string& directory, const SigningKey& key) {
  const std::string path = directory + "/key.pub";
  const std::string line = key.public_key().vkey() + "\n";
  if (const auto now = read_small_file(path); now && *now == line) return {};
  return replace_small_file(path, line);
}

Result<void> take_next(const std::string& directory) {
  return rename_durably(next_path(directory), key_path(directory));
}

Result<SigningKey> load_or_make(const std::string& directory, const std::string& name, bool& made) {
  const std::string path = key_path(directory);
  if (exists(path)) return SigningKey::load(path);
  made = true;
  auto key = SigningKey::make(name);
  if (!key) return key;
  if (auto saved = key->save(path); !saved) return tl::unexpected(saved.error());
  return key;
}

// Completes a change of keys that was cut off if the ledger knows the next key; otherwise undoes it. The next key is
// deleted only after the ledger has opened with the old one, for the next one may be the one that signs.
Result<KeyAndLedger> finish_change(const std::string& directory) {
  auto next = SigningKey::load(next_path(directory));
  if (next) {
    if (auto ledger = Ledger::open(directory, *next))
      return take_next(directory).map([&] { return KeyAndLedger{std::move(*next), std::move(*ledger), false}; });
  }
  auto key = SigningKey::load(key_path(directory));
  if (!key) return tl::unexpected(key.error());
  auto ledger = Ledger::open(directory, *key);
  if (!ledger) return tl::unexpected(ledger.error());
  unlink(next_path(directory).c_str());
  return KeyAndLedger{std::move(*key), std::move(*ledger), false};
}

Result<KeyAndLedger> open_as_it_is(const std::string& directory, const std::string& name) {
  bool made = false;
  auto key = load_or_make(directory, name, made);
  if (!key) return tl::unexpected(key.error());
  auto ledger = Ledger::open(directory, *key);
  if (!ledger) return tl::unexpected(ledger.error());
  return KeyAndLedger{std::move(*key), std::move(*ledger), made};
}

}  // namespace

std::string key_path(const std::string& directory) { return directory + "/key"; }

Result<KeyAndLedger> open_key_and_ledger(const std::string& directory, const std::string& name) {
  auto opened = exists(next_path(directory)) ? finish_change(directory) : open_as_it_is(directory, name);
  if (!opened) return opened;
  if (auto written = write_public(directory, opened->key); !written) return tl::unexpected(written.error());
  return opened;
}

Result<PublicKey> change_key(const std::string& directory, const std::string& name) {
  DirectoryLock lock;
  if (auto locked = lock.take(directory); !locked) return tl::unexpected(locked.error());
  auto now = open_key_and_ledger(directory, name);
  if (!now) return tl::unexpected(now.error());
  auto next = SigningKey::make(name);
  if (!next) return tl::unexpected(next.error());
  unlink(next_path(directory).c_str());
  auto changed = next->save(next_path(directory))
                     .and_then([&] { return now->ledger.key_changes(next->public_key()); })
                     .and_then([&] { return take_next(directory); })
                     .and_then([&] { return write_public(directory, *next); });
  if (!changed) return tl::unexpected(changed.error());
  return next->public_key();
}

}  // namespace dwell::record
