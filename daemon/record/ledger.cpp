#include "daemon/record/ledger.hpp"

#include <time.h>

#include <array>
#include <filesystem>
#include <mutex>
#include <optional>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/ledger_book.hpp"
#include "daemon/record/random_id.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

std::int64_t utc_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

struct Ledger::Impl {
  std::string path;
  LedgerBook book;
  std::optional<ChainWriter> file;
  bool key_changed = false;
  std::mutex writing;  // of `file`

  struct Addition {
    const char* kind;
    std::string body;
  };

  // All of them, in one transaction. The book first: it refuses what a reader would refuse.
  Result<void> add(std::initializer_list<Addition> additions, std::int64_t t_ns) {
    const std::lock_guard lock(writing);
    if (key_changed) return fails(path + ": the key has changed: open the ledger with the new one");
    LedgerBook next = book;
    std::int64_t seq = file->committed();
    for (const Addition& addition : additions) {
      const Entry entry{.seq = ++seq, .kind = addition.kind, .t_ns = t_ns, .body = addition.body};
      if (Result<void> taken = next.take(entry); !taken) {
        file->roll_back();
        return fails(path + ": " + taken.error());
      }
      const Result<void> done = file->append(addition.kind, t_ns, addition.body).and_then([&] { return file->sign(); });
      if (!done) return done;
    }
    Result<void> done = file->commit();
    if (done) book = std::move(next);
    return done;
  }
  Result<void> add(const char* kind, std::string body, std::int64_t t_ns) {
    return add({{kind, std::move(body)}}, t_ns);
  }

  Result<void> begin(const SigningKey& key) {
    Result<std::string> id = random_id();
    if (!id) return fails(std::move(id.error()));
    const std::string origin = "dwell/ledger/" + *id;
    Result<ChainWriter> made = std::filesystem::exists(path)
                                   ? ChainWriter::open(path, ChainSort::ledger, origin, key)
                                   : ChainWriter::create(path, ChainSort::ledger, origin, key);
    if (!made) return fails(std::move(made.error()));
    file.emplace(std::move(*made));
    const std::int64_t now_ns = utc_now_ns();
    return add("ledger", ledger_opens(*id, key.public_key(), iso_utc(now_ns)), now_ns);
  }
};

Ledger::Ledger(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Ledger::Ledger(Ledger&&) noexcept = default;
Ledger& Ledger::operator=(Ledger&&) noexcept = default;
Ledger::~Ledger() = default;

Result<Ledger> Ledger::open(const std::string& directory, const SigningKey& key) {
  auto impl = std::make_unique<Impl>();
  impl->path = ledger_in(directory);
  if (std::filesystem::exists(impl->path)) {
    Result<LedgerBook> book = read_book(impl->path);
    if (!book) return fails(std::move(book.error()));
    impl->book = std::move(*book);
  }
  // True too after a crash between making the file and its first entry.
  if (impl->book.empty()) {
    if (Result<void> begun = impl->begin(key); !begun) return fails(std::move(begun.error()));
    return Ledger(std::move(impl));
  }
  if (!(impl->book.keys().back() == key.public_key()))
    return fails(impl->path + ": is signed by the key " + impl->book.keys().back().fingerprint() + ", not by " +
                 key.public_key().fingerprint());
  Result<ChainWriter> file =
      ChainWriter::open(impl->path, ChainSort::ledger, impl->book.origin(), key, impl->book.last_signer());
  if (!file) return fails(std::move(file.error()));
  impl->file.emplace(std::move(*file));
  return Ledger(std::move(impl));
}

std::int64_t Ledger::next_run() const noexcept { return impl_->book.next_run(); }
const std::string& Ledger::newest_head() const noexcept { return impl_->book.newest_head(); }
std::int64_t Ledger::running() const noexcept { return impl_->book.running(); }

std::string Ledger::file_of(std::int64_t run) const {
  const auto known = impl_->book.runs().find(run);
  return known == impl_->book.runs().end() ? std::string() : known->second.file;
}

bool Ledger::is_deleted(std::int64_t run) const {
  const auto known = impl_->book.runs().find(run);
  return known != impl_->book.runs().end() && known->second.deleted && known->second.end->seq > 0;
}

Result<void> Ledger::begin_log() { return impl_->file->begin_log(); }
Result<void> Ledger::merge_log() {
  const std::lock_guard lock(impl_->writing);
  return impl_->file->merge_log();
}

Anchor Ledger::head() const {
  return {{}, impl_->book.origin(), impl_->file->committed(), impl_->file->committed_head()};
}

Result<void> Ledger::run_begins(const RunHeader& header, const std::string& file) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("begins", ledger_begins(header, file, iso_utc(now_ns)), now_ns);
}

Result<void> Ledger::run_ends(const Ending& ended) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("ends", ledger_ends(ended.run, {ended.head, ended.seq, ended.state, iso_utc(now_ns)}), now_ns);
}

Result<void> Ledger::run_follows(const Ending& ended, const RunHeader& header, const std::string& file) {
  const std::int64_t now_ns = utc_now_ns();
  const std::string utc = iso_utc(now_ns);
  return impl_->add({{"ends", ledger_ends(ended.run, {ended.head, ended.seq, ended.state, utc})},
                     {"begins", ledger_begins(header, file, utc)}},
                    now_ns);
}

Result<void> Ledger::run_deleted(std::int64_t run, const std::string& why) {
  const std::int64_t now_ns = utc_now_ns();
  const auto known = impl_->book.runs().find(run);
  // The head at the run's end, whatever was signed afterwards.
  const bool has_head = known != impl_->book.runs().end() && known->second.end;
  return impl_->add("deleted", ledger_deleted(run, has_head ? known->second.end->head : "", why, iso_utc(now_ns)),
                    now_ns);
}

Result<void> Ledger::run_signed(std::int64_t run, const PersonalSignature& signature) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("signed", ledger_signed(run, signature, iso_utc(now_ns)), now_ns);
}

Result<void> Ledger::key_changes(const PublicKey& next) {
  const std::int64_t now_ns = utc_now_ns();
  Result<void> done = impl_->add("key", ledger_key(next, iso_utc(now_ns)), now_ns);
  impl_->key_changed = impl_->key_changed || done.has_value();
  return done;
}

}  // namespace dwell::record
