#include "daemon/record/ledger.hpp"

#include <time.h>

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
  std::mutex writing;  // guards file and key_changed; locked while an entry waits for the disk
  std::optional<ChainWriter> file;
  bool key_changed = false;
  mutable std::mutex known;  // guards book and head; nobody waits for the disk with it
  LedgerBook book;
  Anchor head;

  template <class Question>
  auto ask(const Question& question) const {
    const std::lock_guard lock(known);
    return question(book);
  }

  // The book first: it refuses what a reader would refuse.
  Result<void> add(const char* kind, const std::string& body, std::int64_t t_ns) {
    const std::lock_guard lock(writing);
    if (key_changed) return fails(path + ": the key has changed: open the ledger with the new one");
    LedgerBook next = book;
    const Entry entry{.seq = file->committed() + 1, .kind = kind, .t_ns = t_ns, .body = body};
    if (Result<void> taken = next.take(entry); !taken) return fails(path + ": " + taken.error());
    Result<void> done = file->append(kind, t_ns, body).and_then([&] { return file->commit(); });
    if (done) learn(std::move(next));
    key_changed = done && entry.kind == "key";
    return done;
  }
  void learn(LedgerBook next) {
    const std::lock_guard lock(known);
    book = std::move(next);
    head = {{}, book.origin(), file->committed(), file->committed_head()};
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
  impl->learn(std::move(impl->book));
  return Ledger(std::move(impl));
}

std::int64_t Ledger::next_run() const noexcept {
  return impl_->ask([](const LedgerBook& book) { return book.next_run(); });
}
std::string Ledger::newest_head() const {
  return impl_->ask([](const LedgerBook& book) { return book.newest_head(); });
}
std::int64_t Ledger::running() const noexcept {
  return impl_->ask([](const LedgerBook& book) { return book.running(); });
}

std::string Ledger::file_of(std::int64_t run) const {
  return impl_->ask([run](const LedgerBook& book) {
    const auto found = book.runs().find(run);
    return found == book.runs().end() ? std::string() : found->second.file;
  });
}

bool Ledger::is_deleted(std::int64_t run) const {
  return impl_->ask([run](const LedgerBook& book) {
    const auto found = book.runs().find(run);
    return found != book.runs().end() && found->second.deleted && found->second.end->seq > 0;
  });
}

Result<void> Ledger::merge_log() {
  const std::lock_guard lock(impl_->writing);
  return impl_->file->merge_log();
}

Anchor Ledger::head() const {
  const std::lock_guard lock(impl_->known);
  return impl_->head;
}

Result<void> Ledger::run_begins(const RunHeader& header, const std::string& file) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("begins", ledger_begins(header, file, iso_utc(now_ns)), now_ns);
}

Result<void> Ledger::run_ends(const Ending& ended) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("ends", ledger_ends(ended.run, {ended.head, ended.seq, ended.state, iso_utc(now_ns)}), now_ns);
}

Result<void> Ledger::run_deleted(std::int64_t run, const std::string& why) {
  const std::int64_t now_ns = utc_now_ns();
  // The head at the run's end, whatever was signed afterwards.
  const std::string head = impl_->ask([run](const LedgerBook& book) {
    const auto found = book.runs().find(run);
    return found != book.runs().end() && found->second.end ? found->second.end->head : std::string();
  });
  return impl_->add("deleted", ledger_deleted(run, head, why, iso_utc(now_ns)), now_ns);
}

Result<void> Ledger::run_signed(std::int64_t run, const PersonalSignature& signature) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("signed", ledger_signed(run, signature, iso_utc(now_ns)), now_ns);
}

Result<void> Ledger::key_changes(const PublicKey& next) {
  const std::int64_t now_ns = utc_now_ns();
  return impl_->add("key", ledger_key(next, iso_utc(now_ns)), now_ns);
}

}  // namespace dwell::record
