#include "daemon/ctl/child_file.hpp"

#include <pwd.h>
#include <unistd.h>

#include <filesystem>
#include <utility>

#include "daemon/record/random_id.hpp"

namespace dwell::ctl {
namespace {

constexpr int kTogether = 200;  // entries per commit. A commit signs once and waits for the disk once

record::Person this_person() {
  const passwd* const user = ::getpwuid(::getuid());
  return {::getuid(), user != nullptr ? user->pw_name : ""};
}

}  // namespace

record::Result<std::string> final_head(const std::string& path) {
  auto reader = record::ChainReader::open(path, record::ChainSort::run);
  if (!reader) return tl::unexpected(reader.error());
  reader->seek(1, "end");
  auto end = reader->next();
  if (!end) return tl::unexpected(end.error());
  if (*end) return record::hex((*end)->head);
  reader->seek(1);
  record::Digest head{};
  for (;;) {
    const auto row = reader->next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) return record::hex(head);
    head = (*row)->head;
  }
}

record::Result<record::RunHeader> child_header(const record::RunHeader& parent, std::string parent_head,
                                               record::KeptFile rig) {
  auto id = record::random_id();
  if (!id) return tl::unexpected(id.error());
  record::RunHeader child = parent;
  child.run = 0;
  child.id = std::move(*id);
  child.begun_by = "replay";
  child.person = this_person();
  child.comment.clear();
  child.previous_head.clear();
  child.parent_id = parent.id;
  child.parent_head = std::move(parent_head);
  child.rig = std::move(rig);
  child.origin = record::this_origin();
  return child;
}

record::Result<ChildFile> ChildFile::create(const std::string& path, const record::RunHeader& header,
                                            const record::SigningKey& key, std::int64_t t_ns) {
  auto writer = record::ChainWriter::create(path, record::ChainSort::run, "dwell/run/" + header.id, key);
  if (!writer) return tl::unexpected(writer.error());
  ChildFile child(path, std::move(*writer));
  record::RunHeader signed_header = header;
  signed_header.vkey = key.public_key().vkey();
  child.append("run", t_ns, to_json(signed_header));
  if (!child.error_.empty()) return tl::unexpected(child.error_);
  return child;
}

ChildFile::ChildFile(ChildFile&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      writer_(std::move(other.writer_)),
      uncommitted_(other.uncommitted_),
      error_(std::move(other.error_)) {}

ChildFile::~ChildFile() {
  if (path_.empty()) return;
  std::error_code ignored;
  for (const char* part : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path_ + part, ignored);
}

void ChildFile::append(const char* kind, std::int64_t t_ns, const std::string& body) {
  if (!error_.empty()) return;
  record::Result<void> done = writer_.append(kind, t_ns, body);
  if (done && ++uncommitted_ >= kTogether) {
    done = writer_.commit();
    uncommitted_ = 0;
  }
  if (!done) error_ = done.error();
}

record::Result<void> ChildFile::finish(std::int64_t t_ns, const record::RunEnd& end) {
  append("end", t_ns, to_json(end));
  if (!error_.empty()) return tl::unexpected(error_);
  if (auto closed = writer_.close(); !closed) return closed;
  path_.clear();
  return {};
}

}  // namespace dwell::ctl
