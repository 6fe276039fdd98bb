#include "daemon/record/ledger_book.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {
namespace {

using Json = nlohmann::ordered_json;

// Thrown and caught in this file only.
struct Misfit {
  std::string what;
};

// An entry of the ledger is small. Bounds the memory that a hostile entry takes.
constexpr std::size_t kMaxBytes = 1 << 20;

std::string text(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_string()) throw Misfit{std::string("\"") + name + "\" is no text"};
  return found->get<std::string>();
}

std::int64_t number(const Json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end() || !found->is_number_unsigned() || found->get<std::uint64_t>() > INT64_MAX)
    throw Misfit{std::string("\"") + name + "\" is no whole number"};
  return found->get<std::int64_t>();
}

std::string head_of(const Json& object) {
  std::string head = text(object, "head");
  if (!head.empty() && !from_hex(head)) throw Misfit{"\"head\" is not 64 hexadecimal digits"};
  return head;
}

PublicKey key_of(const Json& object) {
  Result<PublicKey> key = PublicKey::parse(text(object, "vkey"));
  if (!key) throw Misfit{"\"vkey\": " + key.error()};
  return std::move(*key);
}

std::string written(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Result<LedgerBook> read_once(const std::string& path) {
  LedgerBook book;
  Result<ChainReader> reader = ChainReader::open(path, ChainSort::ledger);
  if (!reader) return fails(std::move(reader.error()));
  for (;;) {
    const auto row = reader->next();
    if (!row) return fails(row.error());
    if (!*row) return book;
    if (const Result<void> taken = book.take((*row)->entry); !taken)
      return fails(path + ": entry " + std::to_string((*row)->entry.seq) + ": " + taken.error());
  }
}

}  // namespace

// Each kind of entry. Throws before it changes anything.
struct LedgerBook::Taker {
  LedgerBook& book;
  const Json& body;

  LedgerRun& known() const {
    const std::int64_t run = number(body, "run");
    const auto found = book.runs_.find(run);
    if (found == book.runs_.end()) throw Misfit{"run " + std::to_string(run) + " has not begun"};
    return found->second;
  }

  void opens() const {
    if (!book.empty()) throw Misfit{"the ledger is opened a second time"};
    std::string id = text(body, "id");
    if (id.size() != 32) throw Misfit{"\"id\" is not 32 hexadecimal digits"};
    book.keys_.push_back(key_of(body));
    book.id_ = std::move(id);
  }

  void key() const {
    book.keys_.push_back(key_of(body));
    book.key_just_changed_ = true;
  }

  void begins() const {
    LedgerRun run{.run = number(body, "run"),
                  .id = text(body, "id"),
                  .file = text(body, "file"),
                  .label = text(body, "label"),
                  .start_utc = text(body, "start_utc"),
                  .previous_head = text(body, "previous_head"),
                  .vkey = book.keys_.back().vkey(),
                  .end = {},
                  .deleted = {},
                  .signatures = {}};
    const std::string name = "run " + std::to_string(run.run);
    if (run.run != book.next_run()) throw Misfit{name + " begins, expected run " + std::to_string(book.next_run())};
    if (book.running_ != 0) throw Misfit{name + " begins before run " + std::to_string(book.running_) + " has ended"};
    if (run.previous_head != book.newest_head_)
      throw Misfit{name + " does not follow the final head of the run before"};
    book.running_ = run.run;
    book.runs_.emplace(run.run, std::move(run));
  }

  void ends() const {
    LedgerRun& run = known();
    LedgerRun::End end{head_of(body), number(body, "seq"), text(body, "state"), text(body, "utc")};
    if (run.run != book.running_) throw Misfit{"run " + std::to_string(run.run) + " ends a second time"};
    if (end.state != "closed" && end.state != "cut off") throw Misfit{"\"state\" is \"" + end.state + "\""};
    if (end.head.empty() != (end.seq == 0)) throw Misfit{"\"head\" and \"seq\" do not fit"};
    if (!end.head.empty()) book.newest_head_ = end.head;
    book.running_ = 0;
    run.end = std::move(end);
  }

  void deleted() const {
    LedgerRun& run = known();
    LedgerRun::Deleted deleted{text(body, "why"), text(body, "utc")};
    if (!run.end) throw Misfit{"run " + std::to_string(run.run) + " is deleted before it has ended"};
    if (run.deleted) throw Misfit{"run " + std::to_string(run.run) + " is deleted a second time"};
    if (head_of(body) != run.end->head) throw Misfit{"\"head\" is not that of run " + std::to_string(run.run)};
    run.deleted = std::move(deleted);
  }

  void is_signed() const {
    LedgerRun& run = known();
    const auto found = body.find("signature");
    if (found == body.end() || !found->is_object()) throw Misfit{"\"signature\" is no object"};
    Result<PersonalSignature> signature = parse_personal_signature(written(*found));
    if (!signature) throw Misfit{signature.error()};
    run.signatures.push_back(std::move(*signature));
  }
};

Result<void> LedgerBook::take(const Entry& entry) {
  try {
    if (entry.body.size() > kMaxBytes) throw Misfit{"it holds more than " + std::to_string(kMaxBytes) + " bytes"};
    const Json body = Json::parse(entry.body);
    if (!body.is_object()) throw Misfit{"it is no JSON object"};
    if (empty() && entry.kind != "ledger") throw Misfit{"the ledger begins with a \"" + entry.kind + "\" entry"};
    const bool just_changed = std::exchange(key_just_changed_, false);
    const Taker taker{*this, body};
    try {
      if (entry.kind == "ledger") taker.opens();
      if (entry.kind == "key") taker.key();
      if (entry.kind == "begins") taker.begins();
      if (entry.kind == "ends") taker.ends();
      if (entry.kind == "deleted") taker.deleted();
      if (entry.kind == "signed") taker.is_signed();
    } catch (...) {
      key_just_changed_ = just_changed;
      throw;
    }
    return {};
  } catch (const Misfit& wrong) {
    return tl::unexpected("\"" + entry.kind + "\" entry: " + wrong.what);
  } catch (const Json::exception&) {
    return tl::unexpected("\"" + entry.kind + "\" entry: it is not JSON");
  }
}

Result<LedgerBook> read_book(const std::string& path) {
  return read_until_whole([&] { return read_once(path); });
}

std::string ledger_opens(const std::string& id, const PublicKey& key, const std::string& utc) {
  return written({{"id", id}, {"vkey", key.vkey()}, {"utc", utc}});
}

std::string ledger_key(const PublicKey& next, const std::string& utc) {
  return written({{"vkey", next.vkey()}, {"utc", utc}});
}

std::string ledger_begins(const RunHeader& header, const std::string& file, const std::string& utc) {
  return written({{"run", static_cast<std::uint64_t>(header.run)},
                  {"id", header.id},
                  {"file", file},
                  {"label", header.label},
                  {"start_utc", header.start_utc},
                  {"previous_head", header.previous_head},
                  {"utc", utc}});
}

std::string ledger_ends(std::int64_t run, const LedgerRun::End& end) {
  return written({{"run", static_cast<std::uint64_t>(run)},
                  {"head", end.head},
                  {"seq", static_cast<std::uint64_t>(end.seq)},
                  {"state", end.state},
                  {"utc", end.utc}});
}

std::string ledger_deleted(std::int64_t run, const std::string& head, const std::string& why, const std::string& utc) {
  return written({{"run", static_cast<std::uint64_t>(run)}, {"head", head}, {"why", why}, {"utc", utc}});
}

std::string ledger_signed(std::int64_t run, const PersonalSignature& signature, const std::string& utc) {
  return written(
      {{"run", static_cast<std::uint64_t>(run)}, {"signature", Json::parse(to_json(signature))}, {"utc", utc}});
}

}  // namespace dwell::record
