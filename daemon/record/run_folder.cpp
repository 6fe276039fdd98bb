#include "daemon/record/run_folder.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <functional>
#include <future>
#include <memory>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/directory_lock.hpp"
#include "daemon/record/disk_jobs.hpp"
#include "daemon/record/disk_reserve.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/kept_jobs.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/record/prepared_runs.hpp"
#include "daemon/record/random_id.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

constexpr const char* kClosed = "closed";
constexpr const char* kCutOff = "cut off";
// Most entries that wait for the ledger as a run begins: those of 12 runs. With fewer, a disk that is slow for some
// seconds would keep an operator from starting; more only take memory.
constexpr std::size_t kMostKept = 60;

Result<void> append_and_commit(ChainWriter& file, std::span<const NewEntry> entries, bool last = false) {
  for (const NewEntry& entry : entries) {
    if (auto appended = file.append(entry.kind, entry.t_ns, entry.body); !appended) {
      file.roll_back();
      return appended;
    }
  }
  auto committed = last ? file.commit_last() : file.commit();
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
  ~Impl() {
    if (ledger_jobs.size() > 0) ledger_jobs.again();  // the last try
    disk_jobs.settle();
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const FolderOptions options;
  DirectoryLock lock;
  DiskReserve reserve;
  std::optional<KeyAndLedger> signs;  // none: not open
  bool key_is_new = false;
  std::optional<CutOffRun> cut_off;
  PreparedRuns prepared;
  // Of the next run, also while the ledger does not know yet of those before.
  std::int64_t next_run = 0;
  std::string previous_head;
  // Of the run that is recorded.
  std::optional<ChainWriter> file;
  std::string name, origin;
  std::int64_t run = 0;
  // Which of its two names the run's file has. A file at a name that it does not have belongs to somebody else.
  bool has_first_name = false, has_name = false;
  std::optional<Anchor> last_head;  // of the run before
  std::vector<EndedRunFile> ended_files;
  DiskJobs disk_jobs;
  KeptJobs ledger_jobs{disk_jobs};

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

  [[nodiscard]] std::optional<Anchor> head() const {
    return Anchor{{}, origin, file->committed(), file->committed_head()};
  }

  // Gives its own name to a run that a crash left at its first one; it has both then. Returns its own.
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
    return full;
  }

  Result<void> drop_first_name(std::int64_t number, const std::string& its_name) const {
    return ChainWriter::drop_name(prepared.path_of(number), options.directory + "/" + its_name);
  }

  // Enters a run that a crash left without an entry, with its end.
  Result<void> adopt(const RunHeader& header, const std::string& its_name) {
    const auto told = signs->ledger.run_begins(header, its_name).and_then([&] { return tell_of_cut_off(); });
    if (!told) return tl::unexpected(std::string(told.error()) + "; to record here, move " + its_name + " elsewhere");
    return drop_first_name(header.run, its_name);
  }

  // Completes what a crash interrupted. First every file gets its name. Then the ledger gets the end of the run that it
  // takes to be going on. Last it gets the runs that have followed and have no entry yet; only then they lose their
  // first names, so whatever comes in between, the next start finds them.
  Result<void> tell_of_crash() {
    std::vector<std::pair<RunHeader, std::string>> unknown;
    std::vector<std::int64_t> left_over = prepared.left_over();
    std::sort(left_over.begin(), left_over.end());
    for (const std::int64_t number : left_over) {
      const auto header = prepared.header_of(number);
      if (!header) return tl::unexpected(header.error());
      if (!*header) {
        prepared.remove(number);
        continue;
      }
      const auto given = give_name(number, **header);
      if (!given) return tl::unexpected(given.error());
      if (signs->ledger.file_of(number).empty())
        unknown.emplace_back(**header, *given);
      else if (auto dropped = drop_first_name(number, *given); !dropped)
        return dropped;
    }
    // Made while the ledger is written, since a run may begin at once.
    if (unknown.empty()) prepared.make(signs->ledger.next_run());
    if (auto told = tell_of_cut_off(); !told) return told;
    for (const auto& [header, its_name] : unknown)
      if (auto adopted = adopt(header, its_name); !adopted) return adopted;
    return {};
  }

  // hold: takes the reserve back.
  Result<void> has_room(bool hold = true) {
    const auto room = free_bytes(options.directory);
    if (!room) return tl::unexpected(room.error());
    const std::int64_t needed = options.room_bytes + (reserve.is_held() ? 0 : options.reserve_bytes);
    if (*room >= needed) return hold ? reserve.hold() : Result<void>();
    const auto megabytes = [](std::int64_t bytes) { return std::to_string((bytes + 999'999) / 1'000'000) + " MB"; };
    return tl::unexpected("disk full: " + std::to_string(*room / 1'000'000) + " MB are free in " + options.directory +
                          ", a run needs " + megabytes(needed) + " to begin: free " + megabytes(needed - *room) +
                          " more there");
  }

  // Why the ledger refuses the entries of the runs so far.
  Result<void> ledger_takes() const {
    std::string refused = ledger_jobs.refused();
    if (refused.empty()) return {};
    std::error_code ignored;
    if (std::filesystem::is_directory(options.directory, ignored) &&
        !std::filesystem::exists(ledger_in(options.directory), ignored))
      refused += "; put it back, or restart the service to begin a new one";
    return tl::unexpected(std::move(refused));
  }

  // Has the ledger take an entry after those of the runs so far; fails if it refuses those.
  std::future<Result<void>> enter(std::function<Result<void>(Ledger&)> entry) {
    auto done = std::make_shared<std::promise<Result<void>>>();
    std::future<Result<void>> outcome = done->get_future();
    if (!signs) {
      done->set_value(tl::unexpected(std::string("the ledger is not open")));
      return outcome;
    }
    disk_jobs.start([this, entry = std::move(entry), done]() -> Result<void> {
      done->set_value(ledger_takes().and_then([&] { return entry(signs->ledger); }));
      return {};
    });
    return outcome;
  }

  void remove_file() {
    file.reset();
    if (has_name)
      for (const char* part : {"", "-wal", "-shm"}) unlink((options.directory + "/" + name + part).c_str());
    if (has_first_name) prepared.remove(run);
    name.clear();
  }

  Result<void> fill_file(const RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) {
    auto made = prepared.take(run);
    has_first_name = made && made->in_its_place();
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
RunFolder::~RunFolder() = default;

Result<void> RunFolder::open() {
  Impl& self = *impl_;
  if (self.signs) return {};
  std::error_code ignored;  // the lock says what is wrong with the directory
  std::filesystem::create_directories(self.options.directory, ignored);
  if (auto locked = self.lock.take(self.options.directory); !locked) return locked;
  auto signs = open_key_and_ledger(self.options.directory, self.options.key_name);
  if (!signs) return tl::unexpected(signs.error());
  self.signs.emplace(std::move(*signs));
  self.key_is_new = self.key_is_new || self.signs->made;
  auto told = self.tell_of_crash();
  if (told) {
    self.next_run = self.signs->ledger.next_run();
    self.previous_head = self.signs->ledger.newest_head();
    self.prepared.make(self.next_run);
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
bool RunFolder::key_is_new() const noexcept { return impl_->key_is_new; }

Result<void> RunFolder::ready() {
  Impl& self = *impl_;
  if (auto opened = open(); !opened) return opened;
  if (self.file) return {};
  self.prepared.make(self.next_run);
  if (auto takes = self.ledger_takes(); !takes) {
    self.ledger_jobs.again();
    return takes;
  }
  return self.has_room(!busy());
}

Result<void> RunFolder::begin(RunHeader& header, std::int64_t t_ns, std::span<const NewEntry> first) {
  Impl& self = *impl_;
  if (!self.signs) return tl::unexpected(self.options.directory + " is not open yet");
  auto can = self.ledger_takes().and_then([&] { return self.has_room(); });
  if (!can) return can;
  if (self.ledger_jobs.size() > kMostKept)
    return tl::unexpected(std::string("the ledger lacks the entries of the last runs, for its disk does not answer"));
  auto id = random_id();
  if (!id) return tl::unexpected(id.error());
  header.id = std::move(*id);
  header.run = self.next_run;
  header.previous_head = self.previous_head;
  header.vkey = self.signs->key.public_key().vkey();
  self.run = header.run;
  self.origin = "dwell/run/" + header.id;
  self.name = run_file_name(self.options.rig, header.run, compact_utc(header.start_utc));
  auto begun = self.fill_file(header, t_ns, first);
  if (!begun) {
    self.remove_file();
    return begun;
  }
  ++self.next_run;
  self.prepared.make(self.next_run);
  // The file first: a ledger that knows the run is right to miss it where its file is gone.
  self.ledger_jobs.add(
      [ledger = &self.signs->ledger, header, name = self.name] { return ledger->run_begins(header, name); });
  self.ledger_jobs.add([first_name = self.prepared.path_of(self.run), kept = self.options.directory + "/" + self.name] {
    return ChainWriter::drop_name(first_name, kept);
  });
  return begun;
}

Result<void> RunFolder::write(std::span<const NewEntry> batch) {
  auto written = impl_->ledger_takes().and_then([&] { return append_and_commit(*impl_->file, batch); });
  // The reason is in the run's own file.
  const std::string path = impl_->options.directory + "/" + impl_->name + ": ";
  if (!written && written.error().substr(0, path.size()) == path)
    return tl::unexpected(written.error().substr(path.size()));
  return written;
}

// The reserve is for the last entries, for what moves from the -wal into the file, and for the ledger's entry and log:
// ready() takes it back only after that; begin() at once, since it asks for more room. A copy of the ledger's file
// alone would lack the entries in its log; if the log cannot be merged, they stay there.
Result<void> RunFolder::end(std::span<const NewEntry> last) {
  Impl& self = *impl_;
  self.reserve.release();
  const auto written = append_and_commit(*self.file, last, true);
  self.last_head = self.head();
  if (self.ended_files.size() == kMostEnded) self.ended_files.erase(self.ended_files.begin());
  self.ended_files.push_back({self.name, *self.last_head});
  self.previous_head = hex(self.last_head->head);
  Ledger* const ledger = &self.signs->ledger;
  self.ledger_jobs.add(
      [ledger, ending = Ledger::Ending{self.run, self.previous_head, self.last_head->seq,
                                       written ? kClosed : kCutOff}] { return ledger->run_ends(ending); });
  // Not before the file has lost its first name: its log has that name too.
  if (written)
    self.ledger_jobs.add([file = std::make_shared<ChainWriter>(std::move(*self.file)), name = self.name,
                          jobs = &self.disk_jobs]() -> Result<void> {
      if (const auto closed = file->close(); !closed)
        jobs->failed(name + " could not be closed: " + std::string(closed.error()));
      return {};
    });
  self.file.reset();
  self.name.clear();
  self.ledger_jobs.add([ledger]() -> Result<void> {
    [[maybe_unused]] const auto merged = ledger->merge_log();
    return {};
  });
  return written;
}

bool RunFolder::busy() const { return !impl_->disk_jobs.idle() || impl_->ledger_jobs.size() > 0; }
void RunFolder::settle() {
  Impl& self = *impl_;
  if (self.ledger_jobs.size() > 0) self.ledger_jobs.again();
  self.prepared.wait();
  self.disk_jobs.settle();
  if (const auto takes = self.ledger_takes(); !takes)
    self.disk_jobs.failed("the ledger has not taken its last entries: " + std::string(takes.error()) +
                          "; it gets them later, or at the next start");
}
std::vector<std::string> RunFolder::take_failures() { return impl_->disk_jobs.take_failures(); }

std::vector<EndedRunFile> RunFolder::take_ended() {
  if (busy()) return {};
  return std::exchange(impl_->ended_files, {});
}
std::optional<CutOffRun> RunFolder::take_cut_off() { return std::exchange(impl_->cut_off, std::nullopt); }
const std::string& RunFolder::file() const noexcept { return impl_->name; }

std::vector<Anchor> RunFolder::heads() const {
  std::vector<Anchor> heads;
  // Of a run that the ledger does not know yet an anchor would say that it was taken out of the ledger.
  const bool known = impl_->file ? knows(impl_->run, impl_->name) : !busy();
  const auto head = impl_->file ? impl_->head() : impl_->last_head;
  if (known && head) heads.push_back(*head);
  if (impl_->signs) heads.push_back(impl_->signs->ledger.head());
  return heads;
}

bool RunFolder::knows(std::int64_t run, const std::string& file) const {
  return impl_->signs->ledger.file_of(run) == file;
}

std::future<Result<void>> RunFolder::run_signed(std::int64_t run, const PersonalSignature& signature) {
  return impl_->enter([run, signature](Ledger& ledger) { return ledger.run_signed(run, signature); });
}

// It may have the deletion already: a crash, a stop or a failure came between that entry and the removal of the file.
std::future<Result<void>> RunFolder::run_deleted(std::int64_t run, const std::string& why) {
  return impl_->enter(
      [run, why](Ledger& ledger) { return ledger.is_deleted(run) ? Result<void>() : ledger.run_deleted(run, why); });
}

}  // namespace dwell::record
