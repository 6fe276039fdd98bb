#include "daemon/record/anchor.hpp"

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

// Position of the origin, which follows a space; npos: there is none.
std::size_t origin_in(const std::string& line) {
  for (const char* front : {" dwell/run/", " dwell/ledger/"})
    if (const std::size_t at = line.find(front); at != std::string::npos) return at + 1;
  return std::string::npos;
}

Result<Anchor> parse(const std::string& line, std::size_t origin_at) {
  Anchor anchor;
  std::string digits, head, more;
  std::istringstream rest(line.substr(origin_at));
  rest >> anchor.origin >> digits >> head;
  const std::string front = line.substr(0, origin_at - 1);
  anchor.utc = front.substr(front.find_last_of(" \t") + 1);
  if (!parse_utc(anchor.utc)) return tl::unexpected("\"" + anchor.utc + "\" before the origin is no instant in UTC");
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), anchor.seq);
  if (error != std::errc() || end != digits.data() + digits.size() || anchor.seq < 1)
    return tl::unexpected("\"" + digits + "\" is no number of an entry");
  const std::optional<std::string> bytes = from_base64(head);
  if (!bytes || bytes->size() != anchor.head.size())
    return tl::unexpected("\"" + head + "\" is no head: expected 32 bytes in base64");
  std::copy(bytes->begin(), bytes->end(), anchor.head.begin());
  if (rest >> more) return tl::unexpected("\"" + more + "\" after the head");
  return anchor;
}

}  // namespace

std::string to_line(const Anchor& anchor) {
  return anchor.utc + " " + anchor.origin + " " + std::to_string(anchor.seq) + " " +
         base64({reinterpret_cast<const char*>(anchor.head.data()), anchor.head.size()});
}

Result<std::vector<Anchor>> read_anchors(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path))
    return tl::unexpected(path + ": cannot be read: " + std::strerror(file ? EISDIR : errno));
  std::vector<Anchor> anchors;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::size_t at = origin_in(line);
    if (at == std::string::npos) continue;
    Result<Anchor> anchor = parse(line, at);
    if (!anchor) return tl::unexpected(path + ", line " + std::to_string(number) + ": " + anchor.error());
    anchors.push_back(std::move(*anchor));
  }
  if (anchors.empty())
    return tl::unexpected(path + ": no anchor in it; expected lines \"UTC dwell/run/ID NUMBER HEAD\"");
  return anchors;
}

}  // namespace dwell::record
