// A child file: the results and events of a run, computed again with another rig file. It states the parent's head and
// holds no stream, for that is in the parent. The parent file is not altered.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::ctl {

// The head of a run's `end` entry, hexadecimal; if the run has none, the head of its last entry.
[[nodiscard]] record::Result<std::string> final_head(const std::string& path);

// The header of a child of this run, begun now by the user of this program. rig: path as given; text: of the rig file.
[[nodiscard]] record::Result<record::RunHeader> child_header(const record::RunHeader& parent, std::string parent_head,
                                                             record::KeptFile rig);

// Bound to one thread. A file that is not finished is removed again.
class ChildFile {
 public:
  // Fails if the file exists already. t_ns: of the parent's first record.
  [[nodiscard]] static record::Result<ChildFile> create(const std::string& path, const record::RunHeader& header,
                                                        const record::SigningKey& key, std::int64_t t_ns);
  ChildFile(ChildFile&& other) noexcept;
  ChildFile& operator=(ChildFile&&) = delete;
  ~ChildFile();

  // t_ns: of the parent's record at that position. After the first failure nothing more is added; finish() returns its
  // reason.
  void add(std::int64_t t_ns, const record::StoredResult& result) { append("result", t_ns, to_json(result)); }
  void add(std::int64_t t_ns, const record::StoredEvent& event) { append("event", t_ns, to_json(event)); }
  [[nodiscard]] record::Result<void> finish(std::int64_t t_ns, const record::RunEnd& end);

 private:
  ChildFile(std::string path, record::ChainWriter writer) : path_(std::move(path)), writer_(std::move(writer)) {}
  void append(const char* kind, std::int64_t t_ns, const std::string& body);

  std::string path_;  // empty: finished
  record::ChainWriter writer_;
  int uncommitted_ = 0;
  std::string error_;
};

}  // namespace dwell::ctl
