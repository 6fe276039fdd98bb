#include "daemon/ctl/replay_check.hpp"

#include <memory>
#include <utility>

#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

std::string index_in(const std::string& dwell) {
  const Json value = Json::parse(dwell, nullptr, false);
  const auto index = value.is_object() ? value.find("index") : value.end();
  return value.is_object() && index != value.end() && index->is_number_integer() ? index->dump() : "none";
}

// A difference that concerns a result as a whole.
Difference whole(std::string stored, std::string replayed) {
  return {"result", std::move(stored), std::move(replayed), kNaN, false};
}

}  // namespace

void ReplayFindings::add(Finding finding) {
  ++different;
  if (!finding.difference.tolerable) {
    ++intolerable;
  } else if (finding.difference.in_u >= 0.0 &&
             (largest.position == 0 || finding.difference.in_u > largest.difference.in_u)) {
    largest = finding;
  }
  std::vector<Finding>& to = finding.difference.tolerable ? tolerable_ : beyond_;
  if (to.size() < kListed) to.push_back(std::move(finding));
}

std::vector<Finding> ReplayFindings::listed() const {
  std::vector<Finding> all = beyond_;
  all.insert(all.end(), tolerable_.begin(), tolerable_.end());
  if (all.size() > kListed) all.resize(kListed);
  return all;
}

void ReplayCheck::look(const Replay& replay) {
  std::size_t ended = 0;
  for (; stored_.now() != nullptr && stored_.now()->position <= replay.position(); stored_.next()) {
    // Both are large: they are handed over, not copied.
    const auto stored = std::make_shared<const StoredResults::Entry>(stored_.take());
    const auto compare_with = [&](DwellDraft draft) {
      later([this, stored, replayed = std::make_shared<DwellDraft>(std::move(draft))] {
        compare(*stored, to_json_(replayed->finish()));
      });
    };
    const auto find_whole = [&](const char* is, const char* would_be) {
      later([this, stored, is, would_be] { find(*stored, whole(is, would_be)); });
    };
    if (stored->position < replay.position()) {
      find_whole("stored after a result of a later record", "");
    } else if (stored->final) {
      if (ended < replay.ended().size())
        compare_with(DwellDraft(replay.ended()[ended++]));
      else
        find_whole("a dwell ends here", "none does");
    } else if (auto draft = replay.draft()) {
      compare_with(std::move(*draft));
    } else {
      find_whole("published here", "nothing: the pipeline is in a long piece of work");
    }
    ++(stored->final ? finals_ : results_);
  }
  const bool cut_off = !closed_ && stored_.now() == nullptr;
  for (; ended < replay.ended().size(); ++ended)
    later([this, cut_off, position = replay.position(), dwell = replay.ended()[ended]] {
      const std::string index = index_in(to_json_(dwell));
      if (cut_off)
        findings_.notes.push_back("the run was cut off before dwell " + index + ", which ended there, was stored");
      else
        findings_.add({position, true, index, whole("none", "a dwell ends here")});
    });
}

record::Result<ReplayFindings> ReplayCheck::finish() {
  hand_over();
  work_.get();
  findings_.finals = finals_;
  findings_.results = results_;
  for (; stored_.now() != nullptr; stored_.next()) {
    const StoredResults::Entry& stored = *stored_.now();
    const std::string at = "record " + std::to_string(stored.position);
    if (closed_)
      find(stored, whole("a result at " + at, "the stream ends before"));
    else
      findings_.notes.push_back("the run was cut off before " + at + ", at which a result is stored");
  }
  if (!stored_.error().empty()) return tl::unexpected(stored_.error());
  return std::move(findings_);
}

void ReplayCheck::later(std::function<void()> work) {
  put_off_.push_back(std::move(work));
  if (put_off_.size() >= kTogether) hand_over();
}

void ReplayCheck::hand_over() {
  if (work_.valid()) work_.get();
  work_ = std::async(std::launch::async, [work = std::exchange(put_off_, {})] {
    for (const auto& piece : work) piece();
  });
}

void ReplayCheck::compare(const StoredResults::Entry& stored, const std::string& replayed) {
  // The same bytes as stored: nothing differs.
  if (stored.body == to_json(record::StoredResult{stored.position, stored.final, replayed})) {
    findings_.numbers += numbers_in(replayed);
    return;
  }
  const auto parsed = record::parse_result(stored.body);
  if (!parsed) return find(stored, whole(parsed.error(), ""));
  if (parsed->position != stored.position || parsed->final != stored.final)
    return find(stored, whole("two positions in one result", ""));
  auto comparison = compare_results(parsed->dwell, replayed);
  if (!comparison) return find(stored, whole(comparison.error(), ""));
  findings_.numbers += comparison->numbers;
  const std::string index = index_in(parsed->dwell);
  for (Difference& difference : comparison->differences)
    findings_.add({stored.position, stored.final, index, std::move(difference)});
}

void ReplayCheck::find(const StoredResults::Entry& stored, Difference difference) {
  const auto parsed = record::parse_result(stored.body);
  const std::string index = parsed ? index_in(parsed->dwell) : "none";
  findings_.add({stored.position, stored.final, index, std::move(difference)});
}

}  // namespace dwell::ctl
