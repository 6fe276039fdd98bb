// Anchors: copies of chain heads in a place where the service cannot alter them. A file without an anchored head was
// cut or written anew. docs/run-file.md, "Anchors".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/record/digest.hpp"
#include "daemon/record/keys.hpp"

namespace dwell::record {

// States: at `utc` the chain `origin` ("dwell/run/ID", "dwell/ledger/ID") had this head, after its entry `seq`.
struct Anchor {
  std::string utc;  // ISO 8601
  std::string origin;
  std::int64_t seq = 0;
  Digest head{};
};

// One line: "UTC ORIGIN SEQ BASE64", without a newline.
[[nodiscard]] std::string to_line(const Anchor& anchor);

// The anchors of a file, one a line. A line may begin with the prefix that a journal adds; lines without an origin are
// skipped. Fails with "FILE, line N: what is wrong", and if the file has no anchor at all.
[[nodiscard]] Result<std::vector<Anchor>> read_anchors(const std::string& path);

}  // namespace dwell::record
