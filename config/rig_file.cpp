#include "config/rig_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "config/decimal_comma.hpp"
#include "config/draft.hpp"
#include "config/nesting.hpp"
#include "config/sha256.hpp"

namespace dwell::config {
namespace {

Mistakes of_the_file(std::string message) { return {{0, 0, std::move(message)}}; }

std::string too_large() {
  return "is larger than a rig file may be: expected at most " + std::to_string(kMaxFileBytes) + " bytes";
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

Result<std::string> read_whole(const std::string& path) {
  const auto failed = [] {
    return tl::make_unexpected(of_the_file(std::string("cannot be read: ") + std::strerror(errno)));
  };
  // Non-blocking, so that a named pipe is refused rather than waited for.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (file.get() < 0 || ::fstat(file.get(), &status) != 0) return failed();
  if (!S_ISREG(status.st_mode)) return tl::make_unexpected(of_the_file("is not a regular file: expected a rig file"));
  std::string text;
  char buffer[65536];
  while (true) {
    const ssize_t got = ::read(file.get(), buffer, sizeof buffer);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return failed();
    if (got == 0) return text;
    text.append(buffer, static_cast<std::size_t>(got));
    if (text.size() > kMaxFileBytes) return tl::make_unexpected(of_the_file(too_large()));
  }
}

void read_all(const toml::table& document, const SchemaSource& schemas, Draft& draft) {
  Section root(document, "the file", draft.mistakes);
  read_method(root, draft);
  read_limits(root, draft);
  read_service(root, draft);
  read_devices(root, schemas, draft);
  read_channels(root, schemas, draft);
  root.refuse_rest();
  describe_devices(draft);
  validate(draft);
}

}  // namespace

Result<RigFile> load(const std::string& path, const SchemaSource& schemas) {
  Result<std::string> text = read_whole(path);
  if (!text) return tl::make_unexpected(std::move(text.error()));
  return parse(*text, path, schemas);
}

Result<RigFile> parse(std::string_view text, const std::string& path, const SchemaSource& schemas) {
  if (text.size() > kMaxFileBytes) return tl::make_unexpected(of_the_file(too_large()));
  if (const std::optional<Position> deep = too_deep(text)) {
    return tl::make_unexpected(
        Mistakes{{deep->line, deep->column,
                  "this is nested deeper than a rig file may be: expected at most " + std::to_string(kMaxBrackets) +
                      " brackets open at a time and " + std::to_string(kMaxDots) + " dots in a key"}});
  }
  toml::table document;
  try {
    document = toml::parse(text);
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    std::string what = one_line(error.description());
    if (const auto number = decimal_comma(text, std::max(1, static_cast<int>(at.line))))
      what += "; expected a decimal point: " + *number;
    return tl::make_unexpected(
        Mistakes{{std::max(1, static_cast<int>(at.line)), std::max(1, static_cast<int>(at.column)), std::move(what)}});
  }
  Draft draft;
  draft.file.path = path;
  const std::filesystem::path parent = std::filesystem::path(path).parent_path();
  draft.file.directory = parent.empty() ? std::string(1, '.') : parent.string();
  draft.file.sha256 = sha256(text);
  draft.file.text = text;
  read_all(document, schemas, draft);
  if (draft.mistakes.count() > 0) return tl::make_unexpected(std::move(draft.mistakes).sorted());
  return std::move(draft.file);
}

}  // namespace dwell::config
