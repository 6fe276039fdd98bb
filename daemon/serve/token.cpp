#include "daemon/serve/token.hpp"

#include <fcntl.h>
#include <grp.h>
#include <openssl/crypto.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "config/sha256.hpp"
#include "daemon/record/small_file.hpp"

namespace dwell {
namespace {

// The largest file that is read. Far more than a token, so that a token that is too long is told as one.
constexpr std::size_t kMostBytes = 4096;

std::string octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", static_cast<unsigned>(mode & 07777U));
  return text.data();
}

std::string name_of_user(uid_t uid) {
  const passwd* const entry = getpwuid(uid);
  return entry != nullptr ? entry->pw_name : std::to_string(uid);
}
std::string name_of_group(gid_t gid) {
  const group* const entry = getgrgid(gid);
  return entry != nullptr ? entry->gr_name : std::to_string(gid);
}

// "PATH (root:root, mode 0600)".
std::string with_owner(const std::string& path, const struct stat& status) {
  return path + " (" + name_of_user(status.st_uid) + ":" + name_of_group(status.st_gid) + ", mode " +
         octal(status.st_mode) + ")";
}

// Root as another user, with that user's groups, while it lives.
class AsUser {
 public:
  explicit AsUser(const passwd& user) {
    const int count = getgroups(0, nullptr);
    groups_.resize(static_cast<std::size_t>(std::max(count, 0)));
    known_ = count >= 0 && getgroups(count, groups_.data()) == count;
    is_ =
        known_ && initgroups(user.pw_name, user.pw_gid) == 0 && setegid(user.pw_gid) == 0 && seteuid(user.pw_uid) == 0;
  }
  ~AsUser() {
    if (seteuid(0) != 0 || setegid(getgid()) != 0) std::abort();  // never go on as somebody in between
    if (known_ && setgroups(groups_.size(), groups_.data()) != 0) std::abort();
  }
  AsUser(const AsUser&) = delete;
  AsUser& operator=(const AsUser&) = delete;

  explicit operator bool() const { return is_; }

 private:
  std::vector<gid_t> groups_;
  bool known_ = false;
  bool is_ = false;
};

// The folder or file on the way that keeps this process from reading the file; empty: none does.
std::string obstacle(const std::filesystem::path& path) {
  std::filesystem::path way;
  for (const auto& part : path) {
    way /= part;
    if (faccessat(AT_FDCWD, way.c_str(), way == path ? R_OK : X_OK, AT_EACCESS) != 0) return way.string();
  }
  return {};
}

}  // namespace

std::string unreadable_token_note(const std::string& path, const std::string& user) {
  struct stat status {};
  const passwd* const entry = geteuid() == 0 ? getpwnam(user.c_str()) : nullptr;
  if (entry == nullptr || stat(path.c_str(), &status) != 0) return {};
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::canonical(path, error);
  if (error) return {};
  const std::string group = name_of_group(entry->pw_gid);
  std::string in_the_way;
  {
    const AsUser as_user(*entry);
    if (!as_user) return {};
    in_the_way = obstacle(absolute);
  }
  if (in_the_way.empty() || stat(in_the_way.c_str(), &status) != 0) return {};
  const bool folder = S_ISDIR(status.st_mode);
  return "the user " + user + ", as whom the unit of systemd runs the service, cannot " +
         (folder ? "enter the folder " : "read ") + with_owner(in_the_way, status) + ": chgrp " + group + " " +
         in_the_way + " and chmod " + (folder ? "g+x" : "0640") + " it";
}

tl::expected<Token, std::string> Token::read(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) == 0 && (status.st_mode & S_IRWXO) != 0 && S_ISREG(status.st_mode))
    return tl::unexpected("is open to every user of this computer (mode " + octal(status.st_mode) +
                          "): expected 0640 or less; chmod o= it, and put another token in");
  auto text = record::read_small_file(path, kMostBytes);
  if (!text) return tl::unexpected("cannot be read: " + text.error().substr(path.size() + 2));  // behind "PATH: "
  if (!text->empty() && text->back() == '\n') text->pop_back();
  const std::string expected = ": expected one line of " + std::to_string(kFewest) + " to " + std::to_string(kMost) +
                               " characters; openssl rand -hex 16 makes one";
  if (text->size() < kFewest)
    return tl::unexpected("holds a token of " + std::to_string(text->size()) + " characters" + expected);
  if (text->size() > kMost) return tl::unexpected("holds more than a token" + expected);
  // What a header carries unchanged.
  if (!std::all_of(text->begin(), text->end(), [](char c) { return c > ' ' && c < 0x7f; }))
    return tl::unexpected("holds a space, a second line or what is not ASCII" + expected);
  return Token(*text);
}

Token::Token(std::string_view text) : sha256_(config::sha256(text)) {}

bool Token::is(std::string_view text) const {
  const std::string other = config::sha256(text);
  return CRYPTO_memcmp(sha256_.data(), other.data(), sha256_.size()) == 0;
}

}  // namespace dwell
