// What the tests of the audit share: a recording directory, and the audit of it with this or that option.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "daemon/record/audit.hpp"
#include "daemon/record/ledger.hpp"
#include "tests/record/altered_files.hpp"

namespace dwell::record {

inline Audit audited(const std::string& path, const AuditOptions& options = {}) {
  const Result<Audit> audit = audit_run(path, options);
  EXPECT_TRUE(audit) << audit.error();
  return audit.value_or(Audit{});
}

inline AuditOptions pinned(const SigningKey& key) {
  return {.keys = {key.public_key()}, .ledger = {}, .anchors = {}, .progress = {}};
}
inline AuditOptions with_ledger(const Scratch& scratch) {
  return {.keys = {}, .ledger = scratch.path("ledger.dwell-ledger"), .anchors = {}, .progress = {}};
}
inline AuditOptions with_anchors(const Scratch& scratch, const std::string& lines) {
  return {.keys = {}, .ledger = {}, .anchors = {scratch.write("anchors", lines)}, .progress = {}};
}

inline bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A recording directory with runs 1 … count; runs are a.dwell, b.dwell … The last one may be cut off.
inline Ledger recorded(const Scratch& scratch, int count, bool last_cut_off = false) {
  Ledger ledger = *Ledger::open(scratch.path(), sample_key());
  for (int i = 1; i <= count; ++i) {
    RunHeader header = sample_header(ledger.next_run(), sample_key());
    header.previous_head = ledger.newest_head();
    const std::string name = std::string(1, static_cast<char>('a' + i - 1)) + ".dwell";
    EXPECT_TRUE(ledger.run_begins(header, name));
    const bool cut_off = last_cut_off && i == count;
    const std::string head = write_sample(
        scratch.path(name),
        {.seed = static_cast<unsigned>(i), .end = cut_off ? SampleEnd::log_left : SampleEnd::closed, .header = header});
    const auto seq = static_cast<std::int64_t>(rows_of(scratch.path(name)).size());
    EXPECT_TRUE(ledger.run_ends({header.run, head, seq, cut_off ? "cut off" : "closed"}));
  }
  return ledger;
}

}  // namespace dwell::record
