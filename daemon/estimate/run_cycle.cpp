#include "daemon/estimate/run_cycle.hpp"

#include <algorithm>
#include <utility>

namespace dwell {
namespace {

constexpr double kLeast_s = 10.0, kPeriods = 8.0;  // see RunCycle::span_ns()
constexpr std::size_t kMostLive = 2;
// While held: why nothing is measured although the drive is on.
constexpr const char* kStopped =
    "the run was stopped: the next one begins with \"dwellctl start\", or with the drive once it has rested";

Record edge_of_run(RunEdge edge, std::int64_t t_ns) {
  return {.t_ns = t_ns, .kind = Kind::run, .flags = static_cast<std::uint8_t>(edge)};
}

}  // namespace

std::int64_t RunCycle::span_ns(const Rig& rig) noexcept {
  return static_cast<std::int64_t>(1e9 * std::max(kLeast_s, kPeriods / rig.excitation.search_low_hz));
}

RunCycle::RunCycle(const Rig& rig, const RunOptions& options, const KeptDwells& kept,
                   const std::shared_ptr<LongWork>& work, Tell tell)
    : bracketed_(options.bracketed),
      span_ns_(span_ns(rig)),
      tell_(std::move(tell)),
      tap_(options.sink, options.every_s),
      nursery_(
          [this, rig, kept, work] {
            return std::make_unique<RunPipeline>(
                rig, kept, work, [this](RunPipeline& by, RunEvent event) { told(by, std::move(event)); });
          },
          options.bracketed && options.births_aside),
      accounts_(rig.channels.size()),
      states_(rig.channels.size()) {
  run_.bracketed = bracketed_;
  live_.reserve(kMostLive + 1);
  live_.push_back(nursery_.take_now());
  accounts_.follow(*live_.front());
}

void RunCycle::set_clocks(std::int64_t now_ns, std::int64_t utc_ns) noexcept {
  utc_less_now_ns_ = utc_ns - now_ns;
  if (first_utc_ns_ == 0) first_utc_ns_ = utc_ns;
}

// Records stamped before the session began, such as the level of the interlock, still come after the first birth.
void RunCycle::take(const Record& record) {
  newest_ns_ = record.t_ns;
  if (live_.front()->position() == 0) {
    live_.front()->born(newest_ns_, first_utc_ns_, accounts_.given());
    announce_birth();
    if (!bracketed_) begin(0);
  }
  if (record.kind == Kind::run) return obey(record);
  states_.take(record);
  give(record);
  if (bracketed_) follow_course();
}

// While a dwell of a run is on, one pipeline lives, and follow_course() would change nothing.
std::size_t RunCycle::take_samples(std::span<const Record> records) {
  RunPipeline& shown = *live_.front();
  if (!run_.on || !shown.sees_drive()) return 0;
  const std::size_t n = shown.take_samples(records.first(tap_.until_look(records)));
  if (n == 0) return 0;
  for (const Record& record : records.first(n)) {
    tap_.record(record);
    accounts_.give(record);
  }
  newest_ns_ = records[n - 1].t_ns;
  tap_.look(shown, newest_ns_);
  return n;
}

void RunCycle::finish(std::int64_t t_ns) {
  newest_ns_ = std::max(newest_ns_, t_ns);
  if (run_.on) return end(EndOfRun::service_stops, 0);
  live_.front()->finish();  // what waits in it is accounted for
}

void RunCycle::give(const Record& record) {
  tap_.record(record);
  accounts_.give(record);
  for (const auto& pipeline : live_) pipeline->take(record);
  // Not at the run's end: from then on only dwells that have ended are handed over.
  if (run_.on && record.kind != Kind::run) tap_.look(*live_.front(), record.t_ns);
}

void RunCycle::follow_course() {
  const RunPipeline& elder = *live_.front();
  if (run_.on) {
    if (run_.by_operator || !nothing_waits()) return;
    const bool idle = elder.idle_for_ns(newest_ns_) >= span_ns_;
    if (!idle && elder.unseen_for_ns(newest_ns_) < kUnseenSpans * span_ns_) return;
    auto newborn = nursery_.take();
    if (!newborn) return;
    end(idle ? EndOfRun::drive_stopped : EndOfRun::drive_unseen, 0);
    return replace(std::move(newborn));
  }
  if (run_.held && elder.idle_for_ns(newest_ns_) >= span_ns_) run_.held = false;
  if (!run_.held && elder.sees_drive()) return begin(0);
  renew();
}

// A stop or a restart while no run goes on came too late: the run has ended by itself.
void RunCycle::obey(const Record& request) {
  const bool start = is_edge(request, RunEdge::begins), restart = start && request.channel == 0;
  if (!bracketed_ || (!run_.on && (!start || restart))) return;
  const bool by_operator = run_.by_operator;
  drive_was_on_ = drive_on();
  if (run_.on) end(restart ? EndOfRun::restarted : EndOfRun::by_operator, request.channel);
  replace(nursery_.take_now());
  if (start) {
    begin(request.channel);
    if (restart) run_.by_operator = by_operator;
  } else {
    run_.held = drive_was_on_;
  }
}

// A pipeline that has been idle since its birth knows nothing of the drive before it has lived for a span.
bool RunCycle::drive_on() const {
  const RunPipeline& shown = *live_.front();
  if (shown.measurement().state() != State::idle) return true;
  const std::int64_t age_ns = shown.age_ns(newest_ns_);
  return drive_was_on_ && age_ns < span_ns_ && shown.idle_for_ns(newest_ns_) == age_ns;
}

void RunCycle::remember_earlier() {
  const FinishedDwells& all = *live_.front()->measurement().finished().list();
  const auto newest =
      std::find_if(all.rbegin(), all.rend(), [](const auto& dwell) { return has_coefficients(*dwell); });
  if (newest != all.rend()) earlier_ = {*newest, live_.front()->start_utc_ns()};
}

void RunCycle::begin(std::uint16_t request) {
  while (live_.size() > 1) drop(live_.size() - 1);
  past_ = {};
  run_.by_operator = request != 0;
  run_.held = false;
  told_ = live_.front()->measurement().state();  // a newborn one is idle, whatever was shown before
  ++run_.number;
  tap_.begin(newest_ns_);
  Record record = edge_of_run(RunEdge::begins, newest_ns_);
  record.value = static_cast<double>(live_.front()->position());
  record.channel = request;
  give(record);
  run_.on = true;
  // Dwells that ended before, within the records that the run reaches back to: a drive that went on when its run was
  // stopped, and rested then.
  for (RunPipeline::Ended& ended : live_.front()->take_for_run()) tap_.ended(ended.position, std::move(ended.dwell));
}

void RunCycle::end(EndOfRun why, std::uint16_t request) {
  Record record = edge_of_run(RunEdge::ends, newest_ns_);
  record.value = static_cast<double>(why);
  record.channel = request;
  give(record);
  live_.front()->finish();
  remember_earlier();
  run_.on = false;
}

// If the elder has been idle for its whole life, or no run may begin, the younger one knows as much: it takes the
// elder's place, and a new one is born. While none is ready, or work is in progress, the elder stays.
void RunCycle::renew() {
  if (live_.back()->age_ns(newest_ns_) < span_ns_ || !nothing_waits()) return;
  auto newborn = nursery_.take();
  if (!newborn) return;
  if (live_.size() == kMostLive) {
    accounts_.follow(*live_.back());
    drop(0);
  }
  add(std::move(newborn));
  announce_birth();
  tell_state();
}

void RunCycle::add(std::unique_ptr<RunPipeline> newborn) {
  newborn->born(newest_ns_, newest_ns_ + utc_less_now_ns_, accounts_.given());
  live_.push_back(std::move(newborn));
}

void RunCycle::announce_birth() {
  give(edge_of_run(RunEdge::armed, newest_ns_));
  states_.tell(newest_ns_, [this](const Record& record) { give(record); });
}

void RunCycle::replace(std::unique_ptr<RunPipeline> newborn) {
  if (!past_.finished) past_ = left_by(*live_.front());
  add(std::move(newborn));
  accounts_.follow(*live_.back());
  while (live_.size() > 1) drop(0);
  announce_birth();
}

RunCycle::Past RunCycle::left_by(RunPipeline& run) {
  Measurement& measurement = run.measurement();
  const auto& finished = measurement.finished().list();
  Past past{finished,
            measurement.finished().forgotten(),
            finished->empty() ? measurement.current() : *finished->back(),
            run.start_utc_ns(),
            run.origin_ns(),
            run.release_model()};
  past.last.settling_reason = kStopped;
  return past;
}

void RunCycle::drop(std::size_t pipeline) {
  const auto place = live_.begin() + static_cast<std::ptrdiff_t>(pipeline);
  nursery_.give_up(std::move(*place));
  live_.erase(place);
}

// Only events of the shown pipeline pass, and none while a stopped run hides it.
void RunCycle::told(RunPipeline& by, RunEvent event) {
  if (event.kind == RunEvent::Kind::dwell_finished && !run_.on) by.keep_for_run(event.dwell);
  if (&by != live_.front().get() || run_.held) return;
  if (event.kind == RunEvent::Kind::dwell_finished) {
    if (run_.on) tap_.ended(by.position(), event.dwell);
    if (by.model() != nullptr) by.model()->ended(*event.dwell, by.position());
  } else {
    event.before = std::exchange(told_, event.dwell->state);
    if (event.before == told_) return;
    tap_.state({newest_ns_, event.before}, event.dwell);
  }
  tell_(std::move(event));
}

// Where another pipeline is shown from now on.
void RunCycle::tell_state() {
  Measurement& shown = live_.front()->measurement();
  if (run_.held || shown.state() == told_) return;
  const State before = std::exchange(told_, shown.state());
  auto after = std::make_shared<const Dwell>(shown.current());
  tap_.state({newest_ns_, before}, after);
  tell_({RunEvent::Kind::state_changed, before, std::move(after)});
}

bool RunCycle::nothing_waits() const noexcept {
  return std::all_of(live_.begin(), live_.end(),
                     [](const auto& pipeline) { return pipeline->measurement().waiting() == 0; });
}

// Finished dwells are on the axis of their own run. So its t = 0 is shown until the next run begins.
void RunCycle::show(Snapshot& to) {
  RunPipeline& shown = *live_.front();
  const bool past = !run_.on && past_.finished;
  const KeptDwells& finished = shown.measurement().finished();
  to.run = run_;
  to.start_utc_ns = past ? past_.start_utc_ns : shown.position() == 0 ? first_utc_ns_ : shown.start_utc_ns();
  to.origin_ns = past ? past_.origin_ns : shown.origin_ns();
  to.dwell = run_.held ? past_.last : shown.measurement().current();
  to.finished = past ? past_.finished : finished.list();
  to.forgotten = past ? past_.forgotten : finished.forgotten();
  to.earlier = earlier_;
  for (const auto& pipeline : live_)
    if (pipeline->model() != nullptr)
      pipeline->model()->gather(pipeline->measurement().readings(), pipeline->origin_ns());
  if (ModelWork* const model = past && past_.model ? past_.model.get() : shown.model()) {
    model->turn(to.dwell, shown.measurement().current_at(), shown.measurement().pipeline());
    model->show(to.dwell, to);
    if (auto news = model->take_news(); news && run_.on) tap_.model(shown, std::move(*news));
  }
}

}  // namespace dwell
