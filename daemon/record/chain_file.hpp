// A file of chained, signed entries: an SQLite database. Run files and the ledger are such files. docs/run-file.md.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/record/digest.hpp"
#include "daemon/record/keys.hpp"

namespace dwell::record {

// The two sorts of files, told apart by SQLite's application_id.
enum class ChainSort : std::uint32_t {
  run = 0x44574c4c,     // "DWLL"
  ledger = 0x44574c47,  // "DWLG"
};

// Called while somebody else has a file open for writing, with how often it was called before. Returns whether to try
// again. Empty: gives up at once.
using WhileBusy = std::function<bool(int tries)>;

// Appends entries. One thread at a time. Every failure is returned with its reason, "disk full" for instance. It
// discards uncommitted entries and leaves committed ones as they were. While a writer exists, SQLite in no other
// program can open the file; ChainReader can.
class ChainWriter {
 public:
  // A new file; fails where there is one. `origin` is the first line of its notes, for instance "dwell/run/<id>".
  [[nodiscard]] static Result<ChainWriter> create(const std::string& path, ChainSort sort, std::string origin,
                                                  const SigningKey& key);
  // Makes a file without entries in advance, with four waits for the disk; its first commit then takes one. The writer
  // may be handed to another thread. Call take_name() before the first append(). On failure no file is left behind.
  [[nodiscard]] static Result<ChainWriter> create_ahead(const std::string& path, ChainSort sort);
  // Gives a file of create_ahead() and its log a second name, `path`. Does not wait for the disk: after a loss of power
  // the file may have its first name alone.
  [[nodiscard]] Result<void> take_name(const std::string& path, std::string origin, const SigningKey& key);
  // Waits until the name `kept` survives a loss of power, then removes the name `first`. Any thread.
  [[nodiscard]] static Result<void> drop_name(const std::string& first, const std::string& kept);
  // Opens an existing file to append to it. Follows its chain from the start; its last note must be by `key`.
  [[nodiscard]] static Result<ChainWriter> open(const std::string& path, ChainSort sort, std::string origin,
                                                const SigningKey& key);
  // The same after a change of keys: the last note must be by `last`.
  [[nodiscard]] static Result<ChainWriter> open(const std::string& path, ChainSort sort, std::string origin,
                                                const SigningKey& key, const PublicKey& last,
                                                const WhileBusy& busy = {});
  // The same without a private key. Its commits carry no note: for a `signature` entry, which carries its own.
  [[nodiscard]] static Result<ChainWriter> open_without_key(const std::string& path, ChainSort sort, std::string origin,
                                                            const PublicKey& last, const WhileBusy& busy = {});
  ChainWriter(ChainWriter&&) noexcept;
  ChainWriter& operator=(ChainWriter&&) noexcept;
  ~ChainWriter();  // discards uncommitted entries

  // Appends an entry; it counts once committed. Refuses a body that readers would refuse: of more than kMaxJson bytes,
  // of a "stream" more than ChainReader::kMaxBody.
  [[nodiscard]] Result<void> append(std::string_view kind, std::int64_t t_ns, std::string_view body);
  // Starts the log, with up to three waits for the disk. The next commit then takes one.
  [[nodiscard]] Result<void> begin_log();
  // Moves the -wal into the file, unless somebody reads it. A copy of the file alone then holds all that was committed
  // before. Waits for the disk once, and the next commit takes one wait. Fails if writing failed, now or before.
  [[nodiscard]] Result<void> merge_log();
  // Signs the head and commits: the entries since the last commit survive a loss of power once this returns. Waits for
  // the disk once; twice where a long -wal is moved into the file. Nothing appended: does nothing. Fails, and discards
  // these entries, also where the file has been removed or replaced.
  [[nodiscard]] Result<void> commit();
  // The same where close() comes next: leaves the -wal to that, and so waits once.
  [[nodiscard]] Result<void> commit_last();
  // Discards what was appended since the last commit.
  void roll_back();
  // Commits, and merges the -wal into the file. Nothing can be appended afterwards. If it fails, all committed entries
  // are still in the file and its -wal, and it may be tried again.
  [[nodiscard]] Result<void> close();

  // Whether the file still stands at its name: it has neither been removed nor replaced. One system call.
  [[nodiscard]] bool in_its_place() const;
  // Entry and head of the last commit. Before the first: 0, and 32 zero bytes.
  [[nodiscard]] std::int64_t committed() const noexcept;
  [[nodiscard]] const Digest& committed_head() const noexcept;

 private:
  struct Impl;
  explicit ChainWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Reads the entries that were committed when it was opened. Alters no byte of the file or its -wal, and works on a
// read-only file system. While it exists, a writer keeps the -wal as it is, up to kMaxWal bytes. If the -wal grows
// beyond that or the writer closes the file, reading fails with "written to while it was read: read it again". Bound to
// one thread. Entries are read one at a time; an entry of more than kMaxBody bytes is an error.
class ChainReader {
 public:
  static constexpr std::int64_t kMaxBody = 64 << 20;
  static constexpr std::int64_t kMaxWal = 512 << 20;

  // Fails with the reason if the file cannot be read or is not of this sort.
  [[nodiscard]] static Result<ChainReader> open(const std::string& path, ChainSort sort);
  ChainReader(ChainReader&&) noexcept;
  ChainReader& operator=(ChainReader&&) noexcept;
  ~ChainReader();

  // The next entry in the order of `seq`, its stored head and the note on it (empty: none). nullopt: there is none
  // left. Fails on a damaged database. Checks neither chain nor notes: audit.hpp does.
  struct Row {
    Entry entry;
    Digest head{};
    std::string note;
  };
  [[nodiscard]] Result<std::optional<Row>> next();
  // Goes on with the first entry of this kind, or of all kinds (empty), from `seq` on.
  void seek(std::int64_t seq, const std::string& kind = {});
  // Damage of the -wal that no crash causes, or a -journal beside the file; empty: none. SQLite would write both into
  // the file.
  [[nodiscard]] const std::string& altered() const noexcept;

 private:
  struct Impl;
  explicit ChainReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
