// Anchors: heads of chains that are kept where the service cannot alter them. A file that does not contain an anchored
// head was cut or written anew. docs/run-file.md, "Anchors".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "daemon/record/digest.hpp"
#include "daemon/record/keys.hpp"

namespace dwell::record {

// That the chain `origin` ("dwell/run/ID", "dwell/ledger/ID") had this head after entry `seq` at `utc`.
struct Anchor {
  std::string utc;  // ISO 8601
  std::string origin;
  std::int64_t seq = 0;
  Digest head{};
};

// One line: "UTC ORIGIN SEQ BASE64", without a newline.
[[nodiscard]] std::string to_line(const Anchor& anchor);

// The anchors of a file, one a line. Before the UTC of a line may stand what a journal puts there; lines that name no
// origin are passed over. Fails with "FILE, line N: what is wrong", and where there is none at all.
[[nodiscard]] Result<std::vector<Anchor>> read_anchors(const std::string& path);

}  // namespace dwell::record
