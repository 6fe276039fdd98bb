// audit: whether run files are as they were recorded. Needs neither the service nor a private key.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/pinned_key.hpp"
#include "daemon/ctl/progress.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

using record::AuditState;

std::string verdict(const record::Audit& audit) {
  if (audit.state == AuditState::tampered) return "tampered: " + audit.where;
  if (audit.head.empty()) return "open, without any entry: it has no end";
  std::string text = "intact";
  if (audit.state == AuditState::open) {
    text = "open until " + (audit.until_s ? seconds_text(*audit.until_s, 3) : std::string(kNoNumber));
    if (!audit.until_utc.empty()) text += " (" + audit.until_utc + ")";
    text += ": it has no end (crashed, running, or cut off)";
  }
  return audit.trusted ? text : text + ", " + key_verdict(audit);
}

// The ledger in the folder of these files. Fails where they have no folder in common.
record::Result<std::string> ledger_beside(const std::vector<std::string>& files) {
  if (files.empty())
    return tl::unexpected(std::string("expected the name of a ledger, or run files that lie beside it"));
  const auto folder_of = [](const std::string& file) { return std::filesystem::path(file).parent_path(); };
  for (const std::string& file : files)
    if (folder_of(file) != folder_of(files.front()))
      return tl::unexpected("expected the name of a ledger: " + files.front() + " and " + file +
                            " lie in different folders");
  return record::ledger_in(folder_of(files.front()).string());
}

std::string ledger_verdict(const record::LedgerAudit& ledger) {
  if (!ledger.unbroken) return "broken: " + ledger.where;
  return ledger.missing.empty() ? "unbroken" : "missing: " + ledger.missing.front();
}

// Of the anchor files, which are the same for all.
std::size_t skipped_anchor_lines(const std::vector<record::Audit>& audits,
                                 const std::optional<record::LedgerAudit>& ledger) {
  if (ledger) return ledger->skipped_anchor_lines;
  return audits.empty() ? 0 : audits.front().skipped_anchor_lines;
}

// How many anchored heads were compared, and hold. A file of anchors that names none of `what` proves nothing of it.
std::string anchors_line(std::size_t heads, const std::string& what) {
  if (heads == 0) return "  anchors: none of " + what + ", so nothing was compared\n";
  return "  anchors: " + std::to_string(heads) + (heads == 1 ? " head of " : " heads of ") + what +
         (heads == 1 ? " was compared, and holds\n" : " were compared, and hold\n");
}

std::string page(const std::vector<record::Audit>& audits, const AuditRequest& request,
                 const std::optional<record::LedgerAudit>& ledger) {
  std::string text;
  for (const record::Audit& audit : audits) {
    text += printable(audit.file + ": " + verdict(audit)) + "\n";
    for (const record::AuditedSignature& one : audit.signatures) text += "  signed: " + printable(one.text) + "\n";
    if (!request.anchors.empty() && audit.state != AuditState::tampered)
      text += anchors_line(audit.anchored_heads, "this run");
  }
  if (const std::size_t lines = skipped_anchor_lines(audits, ledger); lines > 0)
    text += "anchors: " + std::to_string(lines) +
            (lines == 1 ? " line names a run or a ledger and does not have the form of an anchor: it was skipped\n"
                        : " lines name a run or a ledger and do not have the form of an anchor: they were skipped\n");
  if (!ledger) return text;
  if (!ledger->unbroken || ledger->missing.empty())
    text += printable(request.ledger + ": " + (ledger->unbroken ? "unbroken" : "broken: " + ledger->where) +
                      (ledger->unbroken && !ledger->trusted ? ", key " + ledger->key + " not trusted" : "")) +
            "\n";
  for (const std::string& line : ledger->missing) text += printable(request.ledger + ": missing: " + line) + "\n";
  for (const std::string& line : ledger->deleted) text += "  deleted: " + printable(line) + "\n";
  if (!request.anchors.empty() && ledger->unbroken) text += anchors_line(ledger->anchored_heads, "this ledger");
  if (ledger->foreign_anchors > 0)
    text += "  anchors: " + std::to_string(ledger->foreign_anchors) +
            (ledger->foreign_anchors == 1 ? " line is" : " lines are") +
            " of another ledger, so nothing was compared with " + (ledger->foreign_anchors == 1 ? "it\n" : "them\n");
  return text;
}

Json text_or_null(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json json_of(const record::Audit& audit) {
  Json signatures = Json::array(), keys = Json::array();
  for (const record::AuditedSignature& one : audit.signatures) {
    signatures.push_back(one.text);
    keys.push_back({{"key", text_or_null(one.key)}, {"trusted", one.trusted}});
  }
  return {{"file", audit.file},
          {"state", to_string(audit.state)},
          {"until_s", audit.until_s ? json_number(*audit.until_s) : Json(nullptr)},
          {"until_utc", text_or_null(audit.until_utc)},
          {"where", text_or_null(audit.where)},
          {"run", audit.run > 0 ? Json(audit.run) : Json(nullptr)},
          {"id", text_or_null(audit.id)},
          {"samples", audit.samples},
          {"head", text_or_null(audit.head)},
          {"key", text_or_null(audit.key)},
          {"trusted", audit.trusted},
          {"known_to_ledger", audit.of_ledger},
          {"signatures", std::move(signatures)},
          {"signature_keys", std::move(keys)},
          {"anchored_heads", audit.anchored_heads}};
}

Json json_of(const std::vector<record::Audit>& audits, const std::optional<record::LedgerAudit>& ledger) {
  Json files = Json::array();
  for (const record::Audit& audit : audits) files.push_back(json_of(audit));
  Json document{{"files", std::move(files)}, {"ledger", nullptr}};
  if (ledger) {
    document["ledger"] = ledger_verdict(*ledger);
    document["ledger_trusted"] = ledger->trusted;
    document["missing"] = ledger->missing;
    document["deleted"] = ledger->deleted;
    document["anchored_heads"] = ledger->anchored_heads;
    document["foreign_anchors"] = ledger->foreign_anchors;
  }
  document["skipped_anchor_lines"] = skipped_anchor_lines(audits, ledger);
  return document;
}

int usage_error(const std::string& why) {
  tell_error(why);
  return kUsage;
}

}  // namespace

int audit_files(const AuditRequest& asked) {
  AuditRequest request = asked;
  if (asked.ledger_beside) {
    auto beside = ledger_beside(asked.files);
    if (!beside) return usage_error("--ledger: " + beside.error());
    request.ledger = std::move(*beside);
  }
  if (request.files.empty() && request.ledger.empty())
    return usage_error("nothing to audit: expected run files, or --ledger FILE");
  record::AuditOptions options;
  options.ledger = request.ledger;
  options.anchors = request.anchors;
  options.every_signature = request.every_signature;
  auto keys = pinned_keys(request.keys), persons = pinned_keys(request.persons);
  if (!keys) return usage_error("--key: " + keys.error());
  if (!persons) return usage_error("--person: " + persons.error());
  options.keys = std::move(*keys);
  options.persons = std::move(*persons);
  int code = kDone;
  if (!request.ledger.empty()) {
    auto checked = record::check_ledger(request.ledger, options);
    if (!checked) return usage_error(checked.error());
    options.checked = std::make_shared<const record::CheckedLedger>(std::move(*checked));
  }
  // A tampered file outweighs one that cannot be audited: then the exit code is kNo, not kUsage.
  bool unusable = false;
  std::vector<record::Audit> audits;
  for (const std::string& file : request.files) {
    ProgressBar bar("checking " + std::filesystem::path(file).filename().string());
    options.progress = bar.progress();
    auto audit = record::audit_run(file, options);
    if (!audit) {
      tell_error(audit.error());
      unusable = true;
      continue;
    }
    const bool not_closed = request.closed && audit->state == AuditState::open;
    if (audit->state == AuditState::tampered || not_closed) code = kNo;
    audits.push_back(std::move(*audit));
  }
  std::optional<record::LedgerAudit> ledger;
  if (!request.ledger.empty()) {
    ProgressBar bar("checking the ledger");
    options.progress = bar.progress();
    // The runs lie beside the ledger itself, not beside a link to it.
    std::error_code failed;
    const std::filesystem::path real = std::filesystem::canonical(request.ledger, failed);
    if (failed) return usage_error(request.ledger + ": " + failed.message());
    auto checked = record::audit_ledger(request.ledger, real.parent_path().string(), options);
    if (!checked) return usage_error(checked.error());
    if (!checked->unbroken || !checked->missing.empty()) code = kNo;
    ledger = std::move(*checked);
  }
  const std::string text = request.json ? dump(json_of(audits, ledger), 2) + "\n" : page(audits, request, ledger);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return code == kDone && unusable ? kUsage : code;
}

}  // namespace dwell::ctl
