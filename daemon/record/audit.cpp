#include "daemon/record/audit.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>
#include <utility>

#include "daemon/record/block_count.hpp"
#include "daemon/record/chain_audit.hpp"
#include "daemon/record/disk_reserve.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/regular_file.hpp"
#include "daemon/record/result_text.hpp"
#include "daemon/record/signature.hpp"
#include "daemon/record/snapshot.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

// One pass over a run file. Fills `audit`, except its state, as far as the pass comes.
class RunAudit {
 public:
  RunAudit(Audit& audit, const AuditOptions& options, const std::vector<Anchor>& anchors, const CheckedLedger* ledger)
      : audit_(audit), options_(options), anchors_(anchors), ledger_(ledger) {}

  // Whether the run has ended. Fails with the place and what was found there.
  Result<bool> check(ChainAudit& chain);

 private:
  Result<void> take(ChainAudit& chain, const ChainReader::Row& row);
  Result<void> take_run(const ChainReader::Row& row);
  Result<void> take_part(const Entry& entry);
  Result<void> take_signature(ChainAudit& chain, const ChainReader::Row& row);
  [[nodiscard]] Result<void> may_be_empty() const;
  [[nodiscard]] bool is_being_entered() const;
  [[nodiscard]] Result<void> ledger_agrees() const;
  [[nodiscard]] Result<void> ledger_signatures_there() const;
  [[nodiscard]] std::string origin() const { return "dwell/run/" + header_.id; }
  void tell_how_far(std::int64_t t_ns);

  Audit& audit_;
  const AuditOptions& options_;
  const std::vector<Anchor>& anchors_;
  const CheckedLedger* ledger_;  // nullptr: none that verifies
  RunHeader header_;
  PublicKey key_;
  KnownHeads known_;
  BlockCount count_;
  std::vector<PersonalSignature> signatures_;
  std::int64_t begin_ns_ = 0, end_ns_ = 0, end_seq_ = 0, unsigned_from_ = 0;
};

Result<bool> RunAudit::check(ChainAudit& chain) {
  const double all = static_cast<double>(std::max<std::int64_t>(1, options_.progress ? chain.last_seq() : 1));
  std::int64_t last_ns = 0;
  for (;;) {
    const auto row = chain.next();
    if (!row) return fails(row.error());
    if (!*row) break;
    if (Result<void> taken = take(chain, **row); !taken) return fails(std::move(taken.error()));
    last_ns = (*row)->entry.t_ns;
    audit_.head = hex((*row)->head);
    if (options_.progress) options_.progress(static_cast<double>(chain.entries()) / all);
  }
  if (chain.entries() == 0) {
    if (Result<void> may = may_be_empty(); !may) return fails(std::move(may.error()));
  }
  if (unsigned_from_ != 0)
    return fails("from " + entry_name(unsigned_from_) + " to " + entry_name(chain.entries()) + " nothing is signed");
  for (const Result<void>& checked :
       {known_.all_there(chain.entries()), ledger_signatures_there(), chain.newest_note_holds(key_), chain.finish()})
    if (!checked) return fails(checked.error());
  if (end_seq_ == 0 && chain.entries() > 0) tell_how_far(last_ns);
  return end_seq_ != 0;
}

Result<void> RunAudit::take(ChainAudit& chain, const ChainReader::Row& row) {
  const Entry& entry = row.entry;
  if ((entry.kind == "run") != (entry.seq == 1))
    return fails(entry_name(entry.seq) + ": \"" + entry.kind + "\" where " +
                 (entry.seq == 1 ? "\"run\"" : "no \"run\"") + " belongs");
  if (entry.seq == 1) {
    if (Result<void> run = take_run(row); !run) return run;
  }
  if (Result<void> fits = known_.fits(entry.seq, row.head); !fits) return fits;
  if (end_seq_ != 0) {
    return take_signature(chain, row);
  }
  if (unsigned_from_ == 0) unsigned_from_ = entry.seq;
  // Checked before the body is read: an unsigned entry may hold anything.
  if (!row.note.empty()) {
    if (Result<void> holds = chain.note_holds(row, origin(), key_); !holds) return holds;
    unsigned_from_ = 0;
  }
  if (Result<void> part = take_part(entry); !part) return fails(entry_name(entry.seq) + ": " + part.error());
  if (entry.kind == "end") {
    end_seq_ = entry.seq;
    end_ns_ = entry.t_ns;
    if (unsigned_from_ != 0) return fails(entry_name(entry.seq) + ": the end is not signed");
  }
  return {};
}

Result<void> RunAudit::take_run(const ChainReader::Row& row) {
  Result<RunHeader> header = parse_run_header(row.entry.body);
  if (!header) return fails("entry 1: " + header.error());
  header_ = std::move(*header);
  Result<PublicKey> key = PublicKey::parse(header_.vkey);
  if (!key) return fails("entry 1: its key: " + key.error());
  key_ = std::move(*key);
  begin_ns_ = row.entry.t_ns;
  audit_.run = header_.run;
  audit_.id = header_.id;
  audit_.key = key_.fingerprint();
  audit_.anchored_heads = known_.add(anchors_, origin());
  audit_.of_ledger = ledger_ != nullptr && ledger_->knows(key_);
  // A ledger by a pinned key connects the keys: all of them signed it in turn, and each vouches for the entries before
  // it. Without a pinned key a ledger vouches for itself alone: whoever forges the runs forges the ledger with them.
  const bool pinned = std::find(options_.keys.begin(), options_.keys.end(), key_) != options_.keys.end();
  audit_.trusted = pinned || (!options_.keys.empty() && audit_.of_ledger);
  if (!options_.keys.empty() && !audit_.trusted)
    return fails("signed by " + audit_.key + ", not by " + asked_for(options_.keys));
  if (ledger_ == nullptr || header_.run == 0) return {};
  if (Result<void> agrees = ledger_agrees(); !agrees) return agrees;
  if (const auto& end = ledger_->find(header_.run)->end; end && !end->head.empty())
    known_.add(end->seq, *from_hex(end->head), "the ledger");
  return {};
}

// A crash before the first commit leaves a file without entries. So does whoever takes all of them away: only the
// ledger and the anchors know which it is, and only by the file's name.
Result<void> RunAudit::may_be_empty() const {
  if (ledger_ == nullptr)
    return options_.keys.empty() ? Result<void>()
                                 : fails("it has no entry, so nothing in it is signed by " + asked_for(options_.keys));
  const LedgerRun* run = ledger_->find(std::filesystem::path(audit_.file).filename().string());
  if (run == nullptr) return {};  // if it is a run's file by another name, the ledger misses that run
  KnownHeads known;
  known.add(anchors_, "dwell/run/" + run->id);
  if (run->end && !run->end->head.empty()) known.add(run->end->seq, *from_hex(run->end->head), "the ledger");
  return known.all_there(0);
}

// The file loses its first name once the ledger knows the run.
bool RunAudit::is_being_entered() const {
  const std::filesystem::path file = audit_.file;
  std::error_code none;
  return std::filesystem::equivalent(file, file.parent_path() / first_name_of_run(header_.run), none);
}

Result<void> RunAudit::ledger_agrees() const {
  const LedgerRun* run = ledger_->find(header_.run);
  const std::string name = "run " + std::to_string(header_.run);
  if (run == nullptr) {
    audit_.unknown = true;
    if (!is_being_entered()) return fails("the ledger does not know " + name);
    return fails(
        {"the ledger has no entry of " + name +
             " yet: the service writes it as the run begins, after a crash at its next start; audit it again then",
         Cause::not_entered});
  }
  if (run->id != header_.id) return fails("the ledger knows another run as " + name);
  if (run->previous_head != header_.previous_head)
    return fails("entry 1: the run before " + name + " is another one in the ledger");
  if (run->vkey != header_.vkey) return fails("entry 1: the ledger's key at the time of " + name + " was another one");
  return {};
}

Result<void> RunAudit::take_part(const Entry& entry) {
  if (entry.kind == "stream") {
    const Result<std::uint64_t> samples = count_.samples(entry.body);
    if (!samples) return fails(samples.error());
    audit_.samples += *samples;
    return {};
  }
  if (entry.kind == "signature") return fails("a signature before the end of the run");
  const auto wrong = [](const auto& parsed) { return parsed ? Result<void>() : fails(parsed.error()); };
  if (entry.kind == "result") return check_result(entry.body);
  if (entry.kind == "estimate" || entry.kind == "verification") return wrong(parse_model(entry.kind, entry.body));
  if (entry.kind == "event") return wrong(parse_event(entry.body));
  if (entry.kind == "end") return wrong(parse_run_end(entry.body));
  return {};
}

Result<void> RunAudit::take_signature(ChainAudit& chain, const ChainReader::Row& row) {
  const std::string place = entry_name(row.entry.seq) + ": ";
  if (row.entry.kind != "signature") return fails(place + "\"" + row.entry.kind + "\" after the end of the run");
  Result<PersonalSignature> read = parse_personal_signature(row.entry.body);
  if (!read) return fails(place + read.error());
  const PersonalSignature& signature = *read;
  if (signature.seq != row.entry.seq - 1 || signature.head != audit_.head)
    return fails(place + "signs another head than that of the entry before it");
  if (row.entry.t_ns != end_ns_) return fails(place + "its t_ns differs from that of the \"end\" entry");
  // No note covers this entry, and the person's own note not all of it.
  if (!signature.vkey.empty() && row.entry.body != to_json(signature))
    return fails(place + "its body is not exactly that of a signature by a person's own key");
  const Result<std::string> text = signature_text(header_.id, signature);
  if (!text) return fails(place + text.error());

  // Who vouches stands before the person's words: these could be worded like a voucher.
  std::string line;
  AuditedSignature audited;
  if (signature.vkey.empty()) {
    if (!signature.person || !signature.person->uid) return fails(place + "nobody vouches for this signature");
    if (Result<void> holds = chain.note_holds(row, origin(), key_); !holds) return holds;
    line += "countersigned by the service for user " + std::to_string(*signature.person->uid);
    if (!signature.person->name.empty()) line += " (" + signature.person->name + ")";
    audited.trusted = audit_.trusted;
  } else {
    const Result<PublicKey> own = PublicKey::parse(signature.vkey);
    if (!own) return fails(place + "its key: " + own.error());
    const Result<std::string> opened = own->open(signature.note);
    if (!opened) return fails(place + opened.error());
    if (*opened != *text) return fails(place + "its own note signs something else");
    if (!row.note.empty()) return fails(place + "it has a note beside its own");
    audited.key = own->fingerprint();
    audited.trusted = std::find(options_.persons.begin(), options_.persons.end(), *own) != options_.persons.end();
    line += (audited.trusted ? "with the pinned key " : "with the key ") + own->name() + " " + audited.key +
            (audited.trusted ? "" : ", not trusted");
  }
  line += ": " + signature.name + ": " + signature.meaning;
  if (!signature.reason.empty()) line += " (" + signature.reason + ")";
  audited.text = line + ", " + signature.utc;
  audit_.signatures.push_back(std::move(audited));
  signatures_.push_back(std::move(*read));
  return {};
}

Result<void> RunAudit::ledger_signatures_there() const {
  const LedgerRun* run = ledger_ == nullptr ? nullptr : ledger_->find(header_.run);
  if (run == nullptr) return {};
  for (const PersonalSignature& known : run->signatures) {
    const std::string body = to_json(known);
    if (std::none_of(signatures_.begin(), signatures_.end(),
                     [&body](const PersonalSignature& one) { return to_json(one) == body; }))
      return fails("the signature of " + known.name + " (" + known.utc + "), which the ledger knows, is missing");
  }
  return {};
}

void RunAudit::tell_how_far(std::int64_t t_ns) {
  audit_.until_s = static_cast<double>(t_ns - begin_ns_) * 1e-9;
  if (const auto start_ns = parse_utc(header_.start_utc)) audit_.until_utc = iso_utc(*start_ns + t_ns - begin_ns_);
}

// One pass. Fails where the file was written to while it was read.
Result<Audit> look(const std::string& path, const AuditOptions& options, bool every_signature,
                   const std::vector<Anchor>& anchors, const CheckedLedger* ledger) {
  Audit audit;
  audit.file = path;
  Result<ChainAudit> chain = ChainAudit::open(path, ChainSort::run, every_signature, options.stop);
  RunAudit run(audit, options, anchors, ledger);
  const Result<bool> ended = chain ? run.check(*chain) : fails(chain.error());
  if (chain ? chain->stopped() : chain.error().cause() == Cause::stopped) return fails({kAuditStopped, Cause::stopped});
  if (chain ? !chain->unchanged() : chain.error().cause() == Cause::read_again) return fails(read_again(path + ": "));
  if (!ended && ended.error().cause() == Cause::not_entered)
    return fails({path + ": " + std::string(ended.error()), Cause::not_entered});
  if (!ended && ended.error().cause() == Cause::newer)
    return fails({path + ": cannot be audited: " + ended.error(), Cause::newer});
  audit.state = !ended ? AuditState::tampered : *ended ? AuditState::intact : AuditState::open;
  if (!ended) {
    audit.where = ended.error();
    audit.trusted = audit.of_ledger = false;
  }
  return audit;
}

// What the file is, if name and content show another file of a recording directory; empty: it may be a run file. A file
// with a run's name and such a content is no mistake of the caller, so it counts as tampered.
std::string what_else(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  if (name.ends_with(kRunSuffix)) return {};
  const auto file = open_regular(path);
  std::array<char, 100> bytes{};
  if (!file) return {};
  const ssize_t count = ::pread(file->get(), bytes.data(), bytes.size(), 0);
  const std::string_view begin(bytes.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  constexpr std::size_t kApplicationId = 68;  // its place in SQLite's header; four bytes, the highest first
  if (begin.size() == bytes.size() && begin.substr(kApplicationId, 4) == "DWLG")
    return "is a ledger, no run file; `dwellctl audit --ledger` takes it";
  // The two magic numbers of a write-ahead log of SQLite.
  if (name.ends_with("-wal") && (begin.empty() || begin.substr(0, 4) == std::string_view("\x37\x7f\x06\x82", 4) ||
                                 begin.substr(0, 4) == std::string_view("\x37\x7f\x06\x83", 4)))
    return "is the -wal of a run or a ledger and is read together with that file; expected the file itself";
  if (name == kReserveName && begin.find_first_not_of('\0') == std::string_view::npos)
    return "is the room that the service reserves on the disk, no run file";
  return {};
}

}  // namespace

const char* to_string(AuditState state) noexcept {
  switch (state) {
    case AuditState::intact:
      return "intact";
    case AuditState::open:
      return "open";
    case AuditState::tampered:
      break;
  }
  return "tampered";
}

std::string key_verdict(const Audit& audit) {
  return "key " + audit.key +
         (audit.trusted     ? " trusted"
          : audit.of_ledger ? " not trusted (known to this ledger)"
                            : " not trusted");
}

Result<Audit> audit_run(const std::string& path, const AuditOptions& options) {
  if (Result<void> there = readable_file(path); !there) return fails(std::move(there.error()));
  const Result<Anchors> anchors = read_all_anchors(options.anchors);
  if (!anchors) return fails(anchors.error());
  if (const std::string other = what_else(path); !other.empty()) return fails(path + ": " + other);
  std::shared_ptr<const CheckedLedger> ledger = options.checked;
  if (!ledger && !options.ledger.empty()) {
    Result<CheckedLedger> checked = check_ledger(options.ledger, options);
    if (!checked) return fails(std::move(checked.error()));
    ledger = std::make_shared<const CheckedLedger>(std::move(*checked));
  }
  bool every_signature = options.every_signature, ledger_is_new = false;
  for (int tries = 1;;) {
    Result<Audit> audit =
        look(path, options, every_signature, anchors->all, ledger && ledger->verifies() ? ledger.get() : nullptr);
    const bool unknown = audit ? audit->unknown : audit.error().cause() == Cause::not_entered;
    if (unknown && !options.ledger.empty() && !std::exchange(ledger_is_new, true)) {
      // The service may have entered the run since the ledger was read.
      Result<CheckedLedger> checked = check_ledger(options.ledger, options);
      if (!checked) return fails(std::move(checked.error()));
      ledger = std::make_shared<const CheckedLedger>(std::move(*checked));
    } else if (!audit) {
      if (audit.error().cause() != Cause::read_again || ++tries > kReadTries) return audit;
    } else if (audit->state == AuditState::tampered && !every_signature) {
      // The newest signature alone does not tell where the first thing is that does not hold.
      every_signature = true;
    } else {
      if (ledger) audit->broken_ledger = ledger->broken;
      audit->skipped_anchor_lines = anchors->skipped;
      return audit;
    }
  }
}

}  // namespace dwell::record
