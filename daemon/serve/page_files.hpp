// The files of the operators' page, read once from their folder. Nothing outside a fixed list of names is ever opened,
// so no request can reach a file that is not the page's. Without the folder there is no page, and `/` says so; all else
// is served as ever.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "daemon/serve/http_server.hpp"

namespace dwell {

class PageFiles {
 public:
  // What the folder holds: index.html is `/`, every other one `/page/NAME`.
  [[nodiscard]] static const std::vector<std::string_view>& names();
  // A larger file is not taken: each answer holds a copy, for each of 128 clients.
  static constexpr std::size_t kLargest = 100'000;

  // No page; why: what `/` answers in its place.
  explicit PageFiles(std::string why = "this service has none") : trouble_(std::move(why)) {}
  // Reads every file of the list; one that cannot be read leaves no page.
  [[nodiscard]] static PageFiles read(const std::string& folder);

  // nullopt: the path is not the page's. gzip: the client takes it; then the files come in a third of their bytes.
  // Thread-safe.
  [[nodiscard]] std::optional<HttpReply> answer(std::string_view path, bool gzip = false) const;

  // Why there is no page; empty: there is one.
  [[nodiscard]] const std::string& trouble() const noexcept { return trouble_; }

 private:
  struct File {
    std::string path;
    HttpReply reply, packed;
  };
  std::vector<File> files_;
  std::string trouble_;
};

// Where the page of this program lies, relative to the program: share/dwell/page beside its bin. Empty: not known.
[[nodiscard]] std::string own_page_folder();

}  // namespace dwell
