// Anchors: copies of chain heads in a place where the service cannot alter them. A file without an anchored head was
// cut or written anew. docs/run-file.md, "Anchors".
#pragma once

#include <cstddef>
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

struct Anchors {
  std::vector<Anchor> all;
  std::size_t skipped = 0;  // lines that name a run or a ledger and do not have the form of an anchor
};

// The anchors of a file, one a line. Before an anchor a line holds nothing, or what the log or journalctl puts there
// and "anchor:": what a person writes into the log is never an anchor. docs/run-file.md has the rule. Other lines are
// skipped. Fails if the file cannot be read or has no anchor at all. Reads the whole file; any thread.
[[nodiscard]] Result<Anchors> read_anchors(const std::string& path);

}  // namespace dwell::record
