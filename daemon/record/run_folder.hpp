// The recording directory: run files, the ledger that knows them, the service's key, a reserve of room. One service at
// a time records into one directory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/record/anchor.hpp"
#include "daemon/record/cut_off_run.hpp"
#include "daemon/record/run_store.hpp"

namespace dwell::record {

struct FolderOptions {
  std::string directory;
  std::string rig;                          // the rig's name, for the files' names
  std::string key_name;                     // of a key that is made; keys.hpp says what a name may be
  std::int64_t reserve_bytes = 32'000'000;  // DiskReserve::kBytes; tests take less
  // Room that must be free beside the reserve before a run begins: 100 s of 64 channels at 10 kHz. Halved, recording
  // may stop again at once. Doubled, a small disk is refused although it would do.
  std::int64_t room_bytes = 256'000'000;
};

// A run that has ended, as it is to be listed and anchored.
struct EndedRunFile {
  std::string file;  // its name in the directory
  Anchor head;       // of its last commit; the instant is empty
};

// Bound to one thread. Fails with "disk full" or another reason for people.
class RunFolder final : public RunStore {
 public:
  explicit RunFolder(FolderOptions options);
  ~RunFolder() override;
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  // Makes the missing parts of the directory, and enters a run that was cut off into the ledger. Does nothing if it is
  // open already.
  [[nodiscard]] Result<void> open();
  [[nodiscard]] bool is_open() const noexcept;
  // The public key of the one with which the service signs. The folder must be open.
  [[nodiscard]] const PublicKey& key() const noexcept;
  // Whether open() made that key: there was none.
  [[nodiscard]] bool key_is_new() const noexcept;

  [[nodiscard]] Result<void> ready() override;
  // The folder must be open. The ledger's entry comes after this returns; if the ledger refuses it, write() fails.
  [[nodiscard]] Result<void> begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) override;
  [[nodiscard]] Result<void> write(std::span<const NewEntry> batch) override;
  // The ledger's entry and moving the -wal into the file are left to the background: the caller does not wait for them.
  [[nodiscard]] Result<void> end(std::span<const NewEntry> last) override;

  // Whether there is background work: files that are being closed, and entries for the ledger, also those that it has
  // refused and is to get later.
  [[nodiscard]] bool busy() const;
  // Waits for what can be done of it, and for the next files that are being made.
  void settle();
  // The failures of background work since the last call, one sentence each.
  [[nodiscard]] std::vector<std::string> take_failures();

  // Most ended runs that are kept until they are taken; older ones are forgotten, and listed when the service starts
  // again. Their anchors fit into the pipe of deliver_anchor().
  static constexpr std::size_t kMostEnded = 256;
  // The runs that have ended since the last call, in their order; none while the folder is busy, since others should
  // leave their files alone until then. No disk.
  [[nodiscard]] std::vector<EndedRunFile> take_ended();

  // The run that open() found cut off, once.
  [[nodiscard]] std::optional<CutOffRun> take_cut_off();
  // Of the run that is recorded; empty: none is.
  [[nodiscard]] const std::string& file() const noexcept;
  // The heads to anchor: that of the ledger, and that of the newest run since open(), as of its last commit, also after
  // its end, but for a run that the ledger does not know yet. The caller fills in the instant.
  [[nodiscard]] std::vector<Anchor> heads() const;
  // Whether the ledger has this run with this file. The folder must be open.
  [[nodiscard]] bool knows(std::int64_t run, const std::string& file) const;
  // The next two write into the ledger in the background, after what waits there. The future is ready once the ledger
  // has taken or refused the entry. A person's signature under a closed run.
  [[nodiscard]] std::future<Result<void>> run_signed(std::int64_t run, const PersonalSignature& signature);
  // The deletion of a run, unless the ledger has it already. Only then may the run's file be deleted.
  [[nodiscard]] std::future<Result<void>> run_deleted(std::int64_t run, const std::string& why);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
