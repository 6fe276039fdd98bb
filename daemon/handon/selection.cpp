#include "daemon/handon/selection.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "config/units.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::handon {
namespace {

constexpr std::int64_t kRecordsPerProgress = 1 << 16;
// 127 years: added to any instant of a run (record/instants.hpp) it fits 64 bits of ns.
constexpr double kLongest_s = 4e9;

tl::unexpected<std::string> wrong(const std::string& path, const std::string& what) {
  return tl::make_unexpected(path + ": " + what);
}

struct Span {
  double start_s = kNaN, end_s = kNaN;
};

}  // namespace

Result<Selection> Selection::open(const std::string& path, const Range& range) {
  auto reader = record::RunReader::open(path);
  if (!reader) return tl::make_unexpected(reader.error());
  Selection selection(path, std::move(*reader));
  if (auto done = selection.read_rig(); !done) return tl::make_unexpected(done.error());
  if (auto done = selection.find_zero(); !done) return tl::make_unexpected(done.error());
  if (auto done = selection.narrow(range); !done) return tl::make_unexpected(done.error());
  return selection;
}

Result<Selection> Selection::open_damaged(const std::string& path) {
  auto reader = record::RunReader::open(path);
  if (!reader) return tl::make_unexpected(reader.error());
  Selection selection(path, std::move(*reader));
  if (auto done = selection.read_rig(); !done) {
    selection.unreadable_.push_back(done.error());
    selection.has_rig_ = false;
    selection.rig_.rig = Rig();
    constexpr std::size_t kMost = 1000;  // a hostile header may name millions
    for (const std::string& name : selection.header().channels) {
      if (selection.rig_.rig.channels.size() == kMost) break;
      selection.rig_.rig.channels.emplace_back().name = name;
      selection.rig_.rig.channels.back().unit.clear();
    }
  }
  if (auto done = selection.find_zero(); !done) selection.unreadable_.push_back(done.error());
  selection.from_ns_ = INT64_MIN;
  selection.to_ns_ = INT64_MAX;
  return selection;
}

Result<void> Selection::read_rig() {
  auto rig = config::parse(header().rig.text, header().rig.path, {});
  if (!rig) {
    const std::string mistake = rig.error().empty() ? "unknown" : to_string(header().rig.path, rig.error().front());
    return wrong(path_, "the rig file in it cannot be read: " + mistake);
  }
  rig_ = std::move(*rig);
  const auto same = [](const Channel& channel, const std::string& name) { return channel.name == name; };
  if (!std::equal(rig_.rig.channels.begin(), rig_.rig.channels.end(), header().channels.begin(),
                  header().channels.end(), same))
    return wrong(path_, "the channels of the run are not those of the rig file in it");
  return {};
}

Result<void> Selection::find_zero() {
  zero_ns_ = reader_.begin_ns();
  return reader_.stream([this](const Record& record) {
    if (!concerns_pipeline(record.kind)) return true;
    zero_ns_ = record.t_ns;
    return false;
  });
}

Result<void> Selection::narrow(const Range& range) {
  for (const auto& bound : {range.from_s, range.to_s})
    if (bound && !std::isfinite(*bound))
      return wrong(path_, "the range begins or ends at a number that is not finite; expected seconds of the run");
  Span span{range.from_s.value_or(kNaN), range.to_s.value_or(kNaN)};
  if (range.dwell) {
    int last = 0;
    const auto look = [&](const record::StoredResult& result) {
      const auto view = parse_dwell(result.dwell);
      if (!view || !view->dwell.index) return true;
      last = std::max(last, *view->dwell.index);
      if (*view->dwell.index == *range.dwell) span = {view->dwell.start_s, view->dwell.end_s};
      return true;
    };
    // If a run was cut off, the last dwell's end may be missing. Then the dwell lasts to its last result.
    for (const bool finals : {true, false}) {
      if (auto done = reader_.results(finals, look); !done) return done;
      if (std::isfinite(span.start_s) && std::isfinite(span.end_s)) break;
    }
    if (!std::isfinite(span.start_s) || !std::isfinite(span.end_s))
      return wrong(path_, "there is no dwell " + std::to_string(*range.dwell) + " in it" +
                              (last > 0 ? "; expected 1 to " + std::to_string(last) : ": it has no dwells"));
  }
  for (const double end : {span.start_s, span.end_s})
    if (std::fabs(end) > kLongest_s) return wrong(path_, "the range is beyond what a run can last");
  if (span.start_s > span.end_s) return wrong(path_, "the range ends before it begins");
  const auto on_clock = [this](double s, std::int64_t otherwise) {
    return std::isnan(s) ? otherwise : zero_ns_ + std::llround(s * 1e9);
  };
  from_ns_ = on_clock(span.start_s, INT64_MIN);
  to_ns_ = on_clock(span.end_s, INT64_MAX);
  if (from_ns_ > reader_.end_ns() || to_ns_ < reader_.begin_ns())
    return wrong(path_, "the range lies outside of the run, which is from " +
                            seconds_text(axis_s(reader_.begin_ns()), 3) + " to " +
                            seconds_text(axis_s(reader_.end_ns()), 3));
  return {};
}

Result<void> Selection::records(const std::function<bool(const Record&)>& take, const Progress& progress) {
  const std::int64_t first = std::max(from_ns_, reader_.begin_ns());
  const double length = std::max(1.0, static_cast<double>(std::min(to_ns_, reader_.end_ns()) - first));
  std::int64_t until_progress = kRecordsPerProgress;
  std::string error;
  const auto each = [&](const Record& record) {
    if (record.t_ns < from_ns_) return true;
    if (record.t_ns > to_ns_) return false;
    if (progress && --until_progress == 0) {
      until_progress = kRecordsPerProgress;
      progress(std::clamp(static_cast<double>(record.t_ns - first) / length, 0.0, 1.0));
    }
    if (record.kind == Kind::sample && record.channel >= rig().channels.size()) {
      error = "a sample of channel " + std::to_string(record.channel) + "; the rig has " +
              std::to_string(rig().channels.size());
      return false;
    }
    return take(record);
  };
  auto done = from_ns_ == INT64_MIN ? reader_.stream(each) : reader_.stream_from(from_ns_, each);
  if (done && !error.empty()) return wrong(path_, error);
  return done;
}

Result<void> Selection::samples(const std::function<bool(const Record&)>& take, const Progress& progress) {
  return records([&take](const Record& record) { return record.kind != Kind::sample || take(record); }, progress);
}

bool Selection::overlaps(double start_s, double end_s) const noexcept {
  const auto before = [this](double s, std::int64_t t_ns) { return s < axis_s(t_ns); };
  if (from_ns_ != INT64_MIN && before(end_s, from_ns_)) return false;
  return to_ns_ == INT64_MAX || !(start_s > axis_s(to_ns_));
}

std::string head_text(const Provenance& provenance) {
  return provenance.head.empty() ? "not checked" : provenance.head;
}

std::string clock_text(const record::Origin& origin) {
  if (!std::isfinite(origin.clock_error_s)) return "in an unknown state";
  if (!origin.clock_synchronized) return "not synchronized";
  return "synchronized within " + seconds_text(origin.clock_error_s, 6);
}

namespace {

std::string file_line(const record::Audit& audit) {
  std::string line;
  switch (audit.state) {
    case record::AuditState::intact:
      line = "intact";
      break;
    case record::AuditState::open:
      if (audit.head.empty()) return "open, without any entry";
      line = "open, valid up to " + seconds_text(audit.until_s.value_or(kNaN), 3);
      break;
    case record::AuditState::tampered:
      return "tampered: " + audit.where;
  }
  return line + ", " + key_verdict(audit);
}

}  // namespace

std::string audit_line(const record::Audit& audit) {
  if (audit.broken_ledger.empty()) return file_line(audit);
  return file_line(audit) + "; compared with no ledger, since the one asked for is broken: " + audit.broken_ledger;
}

std::string place_text(int at) {
  return at == kGround ? "the ground" : at == 0 ? "the table" : "mass " + std::to_string(at);
}

std::string measurand_text(const Channel& channel) {
  std::string text = config::to_string(channel.measures);
  if (channel.measures == Quantity::auxiliary) return text;
  text += (channel.measures == Quantity::force ? " at " : " of ") + place_text(channel.at);
  if (channel.relative_to) text += " relative to " + place_text(*channel.relative_to);
  return text;
}

}  // namespace dwell::handon
