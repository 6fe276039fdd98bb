#include "daemon/record/run_folder.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <future>
#include <memory>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/directory_lock.hpp"
#include "daemon/record/disk_jobs.hpp"
#include "daemon/record/disk_reserve.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/record/prepared_run.hpp"
#include "daemon/record/random_id.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

constexpr const char* kClosed = "closed";
constexpr const char* kCutOff = "cut off";

Result<void> append_and_commit(ChainWriter& file, std::span<const NewEntry> entries) {
  for (const NewEntry& entry : entries) {
    if (auto appended = file.append(entry.kind, entry.t_ns, entry.body); !appended) {
      file.roll_back();
      return appended;
    }
  }
  auto committed = file.commit();
  if (!committed) file.roll_back();
  return committed;
}

}  // namespace

// The lock first: it is released last.
struct RunFolder::Impl {
  explicit Impl(FolderOptions the_options)
      : options(std::move(the_options)),
        reserve(options.directory + "/" + kReserveName, options.reserve_bytes),
        prepared(options.directory) {}

  const FolderOptions options;
  DirectoryLock lock;
  DiskReserve reserve;
  std::optional<KeyAndLedger> signs;  // none: not open
  std::optional<CutOffRun> cut_off;
  PreparedRun prepared;
  std::optional<Ledger::Ending> ended;  // the end of the last run, not in the ledger yet
  // What a run's end has left to be done: first the ledger's entry, which it may refuse, then its log moves into its
  // file.
  enum class Left : std::uint8_t { nothing, entry, refused_entry, log };
  Left left = Left::nothing;
  // Of the run that is recorded.
  std::optional<ChainWriter> file;
  std::string name, origin;
  std::int64_t run = 0;
  // Which of its two names the run's file has. A file at a name that it does not have belongs to somebody else.
  bool has_first_name = false, has_name = false;
  std::optional<Anchor> last_head;  // of the run before
  std::vector<EndedRunFile> ended_files;
  DiskJobs disk_jobs;

  // The file that was cut off is not altered.
  Result<void> tell_of_cut_off() {
    Ledger& ledger = signs->ledger;
    if (ledger.running() == 0) return {};
    FileEnd found;
    found.run.run = ledger.running();
    if (std::string known = ledger.file_of(found.run.run); is_there(options.directory, known)) {
      found.run.file = std::move(known);
      if (auto seen = end_of_file(options.directory, found.run))
        found = std::move(*seen);
      else
        found.run.trouble = seen.error();
    }
    Result<void> told = ledger.run_ends({found.run.run, found.head, found.seq, found.closed ? kClosed : kCutOff});
    if (told && !found.closed) cut_off = std::move(found.run);
    return told;
  }

  // A run that never had a file must not look like a run whose file was removed.
  Result<void> enter_runs_without_file() {
    const auto runs = runs_without_file(options.directory);
    if (!runs) return tl::unexpected(runs.error());
    for (const std::int64_t number : *runs)
      if (auto told = signs->ledger.run_deleted(number, "it was cut off before it had a file"); !told) return told;
    return {};
  }

  [[nodiscard]] std::optional<Anchor> head() const {
    return Anchor{{}, origin, file->committed(), file->committed_head()};
  }

  // Gives its own name to a run that a crash left at its first one. Returns that name.
  Result<std::string> give_name(std::int64_t number, const RunHeader& header) {
    std::string full = signs->ledger.file_of(number);
    if (full.empty()) full = file_of_run(options.directory, number);
    if (full.empty()) full = run_file_name(options.rig, number, compact_utc(header.start_utc));
    const std::string path = prepared.path_of(number), to = options.directory + "/" + full;
    for (const char* part : {"-wal", ""})
      if (are_two_files(to + part, path + part))
        return tl::unexpected(to + part + ": is not the run that a crash left at " + path + part +
                              ", but stands at its name: move it elsewhere");
    for (const char* part : {"-wal", ""})
      if (link((path + part).c_str(), (to + part).c_str()) != 0 && errno != EEXIST && errno != ENOENT)
        return tl::unexpected(to + part + ": " + std::strerror(errno));
    if (auto kept = ChainWriter::drop_name(path, to); !kept) return tl::unexpected(kept.error());
    return full;
  }

  // Completes what a crash interrupted. First every file gets its name. Then the ledger gets the end of the run that
  // was going on. Last it gets the run that had just followed and has no entry yet, with its end.
  Result<void> tell_of_crash() {
    std::vector<std::pair<RunHeader, std::string>> unknown;
    for (const std::int64_t number : prepared.left_over()) {
      const auto header = prepared.header_of(number);
      if (!header) return tl::unexpected(header.error());
      if (*header) {
        const auto given = give_name(number, **header);
        if (!given) return tl::unexpected(given.error());
        if (signs->ledger.file_of(number).empty()) unknown.emplace_back(**header, *given);
      }
      prepared.remove(number);
    }
    // Made while the ledger is written, since a run may begin at once.
    if (unknown.empty()) prepared.make(signs->ledger.next_run());
    if (auto told = tell_of_cut_off(); !told) return told;
    for (const auto& [header, its_name] : unknown) {
      auto told = signs->ledger.run_begins(header, its_name).and_then([&] { return tell_of_cut_off(); });
      if (!told) return told;
    }
    return enter_runs_without_file();
  }

  Result<void> has_room() {
    const auto room = free_bytes(options.directory);
    if (!room) return tl::unexpected(room.error());
    const std::int64_t needed = options.room_bytes + (reserve.is_held() ? 0 : options.reserve_bytes);
    if (*room >= needed) return reserve.hold();
    const auto megabytes = [](std::int64_t bytes) { return std::to_string((bytes + 999'999) / 1'000'000) + " MB"; };
    return tl::unexpected("disk full: " + std::to_string(*room / 1'000'000) + " MB are free in " + options.directory +
                          ", a run needs " + megabytes(needed) + " to begin: free " + megabytes(needed - *room) +
                          " more there");
  }

  // Enters the end of the last run into the ledger, if it is not there yet.
  Result<void> tell_of_end() {
    if (!ended) return {};
    auto told = signs->ledger.run_ends(*ended);
    left = told ? Left::log : Left::refused_entry;
    if (told) ended.reset();
    return told;
  }

  // A copy of the ledger's file alone would lack the entries in the log. If the merge fails, they stay there. Any
  // thread.
  void merge_log() { [[maybe_unused]] const auto merged = signs->ledger.merge_log(); }

  // Enters the run that begins; with it the end of the one before, if that is not in the ledger yet. Any thread, while
  // no other uses the ledger.
  Result<void> enter(const RunHeader& header) {
    return ended ? signs->ledger.run_follows(*ended, header, name) : signs->ledger.run_begins(header, name);
  }

  void remove_file() {
    file.reset();
    if (has_name)
      for (const char* part : {"", "-wal", "-shm"}) unlink((options.directory + "/" + name + part).c_str());
    if (has_first_name) prepared.remove(run);
  }

  // Enters a run without a file into the ledger, with the reason.
  void give_up(const std::string& why) {
    remove_file();
    reserve.release();
    const Ledger::Ending without_entry{run, {}, 0, kCutOff};
    auto told = signs->ledger.run_ends(without_entry);
    if (!told) {
      ended = without_entry;  // tell_of_end() tries again; the next start enters it as deleted
      left = Left::refused_entry;
    }
    if (told) told = signs->ledger.run_deleted(run, "its file could not be made: " + why);
    name.clear();
    [[maybe_unused]] auto held = reserve.hold();
  }

  Result<void> fill_file(const RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) {
    auto made = prepared.take(run);
    has_first_name = made.has_value();
    has_name = false;
    if (!made) return tl::unexpected(made.error());
    file.emplace(std::move(*made));
    if (auto named = file->take_name(options.directory + "/" + name, origin, signs->key); !named) return named;
    has_name = true;
    if (auto appended = file->append("run", t_ns, to_json(header)); !appended) return appended;
    return append_and_commit(*file, first);
  }
};

RunFolder::RunFolder(FolderOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
RunFolder::~RunFolder() {
  impl_->disk_jobs.settle();
  if (impl_->signs) [[maybe_unused]]
    const auto told = impl_->tell_of_end();
}

Result<void> RunFolder::open() {
  Impl& self = *impl_;
  if (self.signs) return {};
  std::error_code ignored;  // the lock says what is wrong with the directory
  std::filesystem::create_directories(self.options.directory, ignored);
  if (auto locked = self.lock.take(self.options.directory); !locked) return locked;
  auto signs = open_key_and_ledger(self.options.directory, self.options.key_name);
  if (!signs) return tl::unexpected(signs.error());
  self.signs.emplace(std::move(*signs));
  auto told = self.tell_of_crash();
  if (told) {
    self.prepared.make(self.signs->ledger.next_run());
    told = self.signs->ledger.merge_log();
  }
  if (!told) {
    self.signs.reset();
    self.prepared.discard();  // it would be taken for what a crash left
  }
  return told;
}

bool RunFolder::is_open() const noexcept { return impl_->signs.has_value(); }
const PublicKey& RunFolder::key() const noexcept { return impl_->signs->key.public_key(); }

Result<void> RunFolder::ready() {
  Impl& self = *impl_;
  if (auto opened = open(); !opened) return opened;
  if (self.file) return {};
  if (self.ended) {
    if (auto told = self.tell_of_end(); !told) return told;
  } else if (self.left == Impl::Left::log) {
    self.left = Impl::Left::nothing;
    self.disk_jobs.start([&self]() -> Result<void> {
      self.merge_log();
      return {};
    });
  }
  auto can = self.has_room();
  if (can) self.prepared.make(self.signs->ledger.next_run());
  return can;
}

Result<void> RunFolder::begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) {
  Impl& self = *impl_;
  auto can = open().and_then([&] { return self.has_room(); });
  if (!can) return can;
  auto id = random_id();
  if (!id) return tl::unexpected(id.error());
  header.id = std::move(*id);
  header.run = self.signs->ledger.next_run();
  // A run without an entry has no head.
  header.previous_head = self.ended && !self.ended->head.empty() ? self.ended->head : self.signs->ledger.newest_head();
  header.vkey = self.signs->key.public_key().vkey();
  self.run = header.run;
  self.origin = "dwell/run/" + header.id;
  self.name = run_file_name(self.options.rig, header.run, compact_utc(header.start_utc));
  // Ledger and file at once, since each waits for the disk. A crash may leave one without the other: open() knows both.
  auto entered = std::async([&] { return self.enter(header); });
  auto begun = self.fill_file(header, t_ns, first);
  const auto told = entered.get();
  if (told) {
    self.ended.reset();
    self.left = Impl::Left::nothing;
  }
  if (told && begun) {
    self.disk_jobs.start(
        [first_name = self.prepared.path_of(self.run), kept = self.options.directory + "/" + self.name] {
          return ChainWriter::drop_name(first_name, kept);
        });
    return begun;
  }
  if (told) {
    self.give_up(begun.error());
    return begun;
  }
  self.remove_file();
  self.name.clear();
  return told;
}

Result<void> RunFolder::write(std::span<const NewEntry> batch) {
  auto written = append_and_commit(*impl_->file, batch);
  if (written) impl_->prepared.make(impl_->run + 1);
  // The reason is in the run's own file.
  const std::string path = impl_->options.directory + "/" + impl_->name + ": ";
  if (!written && written.error().substr(0, path.size()) == path)
    return tl::unexpected(written.error().substr(path.size()));
  return written;
}

// The reserve is for the last entries, for what moves from the -wal into the file, and for the ledger's entry: ready()
// takes it back only after that.
Result<void> RunFolder::end(std::span<const NewEntry> last) {
  Impl& self = *impl_;
  self.reserve.release();
  const auto written = append_and_commit(*self.file, last);
  self.last_head = self.head();
  if (self.ended_files.size() == kMostEnded) self.ended_files.erase(self.ended_files.begin());
  self.ended_files.push_back({self.name, *self.last_head});
  self.ended = {self.run, hex(self.last_head->head), self.last_head->seq, written ? kClosed : kCutOff};
  if (written)
    self.disk_jobs.start([file = std::make_unique<ChainWriter>(std::move(*self.file)), name = self.name] {
      return file->close().map_error(
          [&](const Failure& why) { return Failure(name + " could not be closed: " + why); });
    });
  self.file.reset();
  self.name.clear();
  self.left = Impl::Left::entry;
  return written;
}

std::shared_future<void> RunFolder::closed() const { return impl_->disk_jobs.done(); }
void RunFolder::settle() {
  if (impl_->left != Impl::Left::nothing)
    impl_->disk_jobs.start([self = impl_.get()] { return self->tell_of_end().map([self] { self->merge_log(); }); });
  impl_->prepared.wait();
  impl_->disk_jobs.settle();
  if (!impl_->ended) impl_->left = Impl::Left::nothing;
}
std::vector<std::string> RunFolder::take_failures() { return impl_->disk_jobs.take_failures(); }

std::vector<EndedRunFile> RunFolder::take_ended() {
  if (impl_->left == Impl::Left::entry) return {};
  return std::exchange(impl_->ended_files, {});
}
std::optional<CutOffRun> RunFolder::take_cut_off() { return std::exchange(impl_->cut_off, std::nullopt); }
const std::string& RunFolder::file() const noexcept { return impl_->name; }

std::vector<Anchor> RunFolder::heads() const {
  std::vector<Anchor> heads;
  if (const auto head = impl_->file ? impl_->head() : impl_->last_head) heads.push_back(*head);
  if (impl_->signs) heads.push_back(impl_->signs->ledger.head());
  return heads;
}

bool RunFolder::knows(std::int64_t run, const std::string& file) const {
  return impl_->signs->ledger.file_of(run) == file;
}

Result<void> RunFolder::run_deleted(std::int64_t run, const std::string& why) {
  if (!impl_->signs) return tl::unexpected(std::string("the ledger is not open"));
  // A crash, a stop or a failure came between that entry and the removal of the file.
  if (impl_->signs->ledger.is_deleted(run)) return {};
  return impl_->tell_of_end().and_then([&] { return impl_->signs->ledger.run_deleted(run, why); });
}

Result<void> RunFolder::run_signed(std::int64_t run, const PersonalSignature& signature) {
  if (!impl_->signs) return tl::unexpected(std::string("the ledger is not open"));
  return impl_->tell_of_end().and_then([&] { return impl_->signs->ledger.run_signed(run, signature); });
}

}  // namespace dwell::record
