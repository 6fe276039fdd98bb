#include "daemon/ctl/personal_key.hpp"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <utility>

namespace dwell::ctl {
namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

std::string personal_key_name() {
  const passwd* const user = ::getpwuid(::getuid());
  std::array<char, 256> host{};
  if (::gethostname(host.data(), host.size() - 1) != 0) host[0] = '\0';
  std::string name = (user != nullptr ? std::string(user->pw_name) : std::to_string(::getuid())) + "@" + host.data();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c <= ' ' || c == '+' || c > '~'; }, '_');
  return name;  // no blanks, no "+": the text form of a key knows none
}

record::Result<std::string> personal_key_path() {
  if (const std::string config = variable("XDG_CONFIG_HOME"); !config.empty()) return config + "/dwell/key";
  if (const std::string home = variable("HOME"); !home.empty()) return home + "/.config/dwell/key";
  return tl::unexpected(
      std::string("where keys are kept is not known: expected HOME or XDG_CONFIG_HOME in the environment"));
}

record::Result<PersonalKey> load_or_make_key(const std::string& path) {
  std::error_code failed;
  if (std::filesystem::exists(path, failed)) {
    auto key = record::SigningKey::load(path);
    if (!key) return tl::unexpected(key.error());
    return PersonalKey{std::move(*key), false};
  }
  auto key = record::SigningKey::make(personal_key_name());
  if (!key) return tl::unexpected(key.error());
  if (auto saved = save_personal_key(*key, path); !saved) return tl::unexpected(saved.error());
  return PersonalKey{std::move(*key), true};
}

record::Result<void> save_personal_key(const record::SigningKey& key, const std::string& path) {
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  const mode_t before = ::umask(0077);
  if (!folder.empty()) std::filesystem::create_directories(folder, failed);
  ::umask(before);
  if (failed) return tl::unexpected(folder.string() + " cannot be made: " + failed.message());
  // Whoever holds that file knows the key by which it was signed. So it is kept, and the private key is not written.
  const std::string pub = path + ".pub";
  std::error_code none;
  if (std::filesystem::exists(std::filesystem::symlink_status(pub, none)))
    return tl::unexpected(pub + ": exists already; a key is not replaced: move the file away, or name another key");
  if (auto saved = key.save(path); !saved) return tl::unexpected(saved.error());
  const std::string vkey = key.public_key().vkey();
  std::ofstream text(pub);
  text << vkey << "\n";
  text.close();
  if (!text) return tl::unexpected(pub + " cannot be written; the public key is " + vkey);
  return {};
}

}  // namespace dwell::ctl
