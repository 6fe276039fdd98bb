#include "daemon/serve/page_files.hpp"

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "daemon/serve/gzip.hpp"

namespace dwell {
namespace {

namespace fs = std::filesystem;

// Scripts, styles and connections from this service alone; nothing inline, so that no text of a rig file or a device
// can become code; in nobody's frame.
constexpr const char* kPolicy =
    "default-src 'self'; base-uri 'none'; object-src 'none'; form-action 'none'; frame-ancestors 'none'";

const char* content_type(std::string_view name) {
  const std::string_view ending = name.substr(name.rfind('.') + 1);
  if (ending == "html") return "text/html; charset=utf-8";
  if (ending == "css") return "text/css; charset=utf-8";
  if (ending == "svg") return "image/svg+xml";
  return "text/javascript; charset=utf-8";
}

// Names the bytes (FNV-1a): after an update of the program a browser takes the new file, until then its own copy.
std::string tag_of(std::string_view bytes) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "\"%016llx\"", static_cast<unsigned long long>(hash));
  return text.data();
}

std::optional<std::string> bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes(PageFiles::kLargest + 1, '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())) && !file.eof()) return std::nullopt;
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  if (bytes.empty() || bytes.size() > PageFiles::kLargest) return std::nullopt;
  return bytes;
}

HttpReply reply_of(std::string_view name, std::string bytes) {
  HttpReply reply{200, std::move(bytes), content_type(name)};
  reply.tag = tag_of(reply.body);
  reply.policy = kPolicy;
  reply.varies = true;
  return reply;
}

}  // namespace

const std::vector<std::string_view>& PageFiles::names() {
  static const std::vector<std::string_view> kNames{
      "index.html",  // the skeleton, and what stands there without JavaScript
      "page.css",
      "icon.svg",
      "main.mjs",  // draws what the feed knows
      "feed.mjs",  // the stream, and what is asked for
      "change.mjs",
      "freshness.mjs",     // what is old
      "history.mjs",       // trends and deviations
      "number.mjs",        // value ± U95
      "wording.mjs",       // the first line
      "coefficients.mjs",  // what stands in place of each coefficient
      "limits.mjs",        // verdicts on limits
      "runs.mjs",          // audits and downloads of runs
      "alarms.mjs",
      "alarms_view.mjs",
      "budget.mjs",
      "polar.mjs",
      "dom.mjs",
      "pictures.mjs",  // when pictures are drawn
      "head_view.mjs",
      "coefficients_view.mjs",
      "phasors_view.mjs",
      "tables_view.mjs",
      "earlier_view.mjs",  // dwells of earlier runs
      "dwell_view.mjs",
      "trace_window.mjs",
      "trace_plot.mjs",
      "traces_view.mjs",
      "wall_view.mjs",
      "mode_shape.mjs",
      "mode_shape_view.mjs",
      "operate_view.mjs",
      "order.mjs",  // orders to the service
  };
  return kNames;
}

PageFiles PageFiles::read(const std::string& folder) {
  PageFiles page{std::string()};
  for (const std::string_view name : names()) {
    const fs::path path = fs::path(folder) / name;
    auto bytes = bytes_of(path);
    if (!bytes) return PageFiles(path.string() + " cannot be read: expected a file of 1 to 100 000 bytes");
    File file{name == "index.html" ? "/" : "/page/" + std::string(name), reply_of(name, std::move(*bytes)), {}};
    file.packed = reply_of(name, gzip_of(file.reply.body));
    file.packed.encoding = "gzip";
    page.files_.push_back(std::move(file));
  }
  return page;
}

std::optional<HttpReply> PageFiles::answer(std::string_view path, bool gzip) const {
  if (!trouble_.empty()) {
    if (path != "/") return std::nullopt;
    return http_error(404, "the page is not to be had: " + trouble_ + "; /api/v1/health and the rest of /api/v1 are");
  }
  for (const File& file : files_)
    if (file.path == path) return gzip && !file.packed.body.empty() ? file.packed : file.reply;
  return std::nullopt;
}

std::string own_page_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  return (program.parent_path() / DWELL_PAGE_DIR).lexically_normal().string();
}

}  // namespace dwell
