#include "daemon/record/run_log.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <utility>

namespace dwell::record {
namespace {

std::string why_text(EndOfRun why) {
  switch (why) {
    case EndOfRun::drive_stopped:
      return "drive stopped";
    case EndOfRun::drive_unseen:
      return "drive unseen";
    case EndOfRun::by_operator:
      return "operator";
    case EndOfRun::service_stops:
      return "service stopped";
    case EndOfRun::restarted:
      return "restarted";
  }
  return "unknown";
}

std::string seconds_text(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", static_cast<double>(ns) * 1e-9);
  return text;
}

NewEntry stream_entry(Block block) { return {"stream", block.last_t_ns, std::move(block.body)}; }

void count(RunProgress& run, const Block& block) {
  run.records += block.records;
  run.samples += block.samples;
  run.last_t_ns = block.last_t_ns;
}

std::string named(const RunProgress& run) {
  return "run " + std::to_string(run.header.run) + (run.label.empty() ? "" : " \"" + run.label + "\"");
}

}  // namespace

void RunLog::set_clock(const ClockPair& now) {
  const std::int64_t step_ns = (now.utc_ns - now_.utc_ns) - (now.raw_ns - now_.raw_ns);
  const bool first = now_.utc_ns == 0;
  now_ = now;
  if (!last_.empty() && now_.raw_ns - last_ns_ >= kSilence_ns) write(std::exchange(last_, {}));
  while (const auto lost = labels_.next_lost(now_.raw_ns))
    options_.tell({Notice::Grade::warning,
                   "the label \"" + lost->label + "\" came while no run was recorded: no run has it",
                   0,
                   {}});
  if (first || std::abs(step_ns) < kClockStep_ns) return;
  char text[64];
  std::snprintf(text, sizeof text, "the wall clock was set by %+.3f s", static_cast<double>(step_ns) * 1e-9);
  StoredEvent event = own_event(text);
  event.what = "clock";
  this->event(std::move(event));
}

void RunLog::record(const Record& record) {
  if (!last_.empty() && record.kind != Kind::run) close(take_notes(run_->last_t_ns), run_->ending);
  if (cutter_.is_due_before(record)) cut();
  cutter_.add(record);
  if (run_ && run_->ending.empty()) told_by_stream_.take(record, cutter_.number() + 1 - run_->born);
  if (record.kind != Kind::run && record.kind != Kind::action) return;
  if (record.kind == Kind::action)
    note_request(record);
  else
    edge(record);
  if (record.channel != 0) labels_.saw(record.channel);
  take_labels();
}

void RunLog::edge(const Record& record) {
  switch (static_cast<RunEdge>(record.flags)) {
    case RunEdge::armed:
      if (run_ && run_->ending.empty()) return;
      follows_ = true;
      kept_.pipeline_born(cutter_.number());
      return;
    case RunEdge::begins:
      return begin(record);
    case RunEdge::ends:
      return end(record);
  }
}

void RunLog::request(Request request) {
  if (request.number != 0) return requests_.add(std::move(request));
  labels_.add(std::move(request), now_.raw_ns);
  take_labels();
}

void RunLog::take_labels() {
  if (!run_ || !first_.empty() || !run_->ending.empty()) return;
  while (auto label = labels_.next()) relabel(std::move(*label));
}

void RunLog::relabel(Request request) {
  StoredEvent told = std::move(request.event);
  told.what = "label";
  told.before = std::exchange(run_->label, request.label);
  told.after = std::move(request.label);
  event(std::move(told));
}

void RunLog::note_request(const Record& record) {
  if (const Request* request = requests_.of(record)) event(request->event);
}

void RunLog::result(std::uint64_t position, bool final, const Dwell& dwell) {
  if (!run_) return;
  if (final) ++run_->dwells;
  publish("result", position,
          to_json(StoredResult{position, final, options_.dwell_json(dwell, run_->header.start_utc)}));
}

void RunLog::model(std::uint64_t position, const ModelResult& result) {
  if (!run_) return;
  StoredModel model = options_.model_json(result);
  model.position = position;
  model.utc = utc_now();
  publish(model.kind, position, to_json(model));
}

void RunLog::state(const StateChange& change, const Dwell& after) {
  StoredEvent event;
  event.utc = iso_utc(utc_of(now_, change.t_ns));
  event.what = "state";
  event.text = options_.state_line(change.before, after);
  this->event(std::move(event));
}

void RunLog::publish(std::string kind, std::uint64_t position, std::string body) {
  if (body.size() <= kMaxJson) return notes_.push_back({std::move(kind), 0, std::move(body)});
  caught_up();
  if (!run_) return;
  StoredEvent event = own_event("the " + kind + " here is not recorded: it has " + std::to_string(body.size()) +
                                " bytes; at most " + std::to_string(kMaxJson) + " can be read back");
  event.position = position;
  options_.tell({Notice::Grade::error, named(*run_) + ": " + event.text, run_->header.run, {}});
  note(std::move(event));
}

void RunLog::event(StoredEvent event) {
  if (event.utc.empty()) event.utc = utc_now();
  if (run_) return note(std::move(event));
  early_.add(cutter_.number(), std::move(event));
}

void RunLog::note(StoredEvent event) {
  if (event.position == 0) event.position = cutter_.number() + 1 - run_->born;
  notes_.push_back({"event", 0, to_json(event)});
}

StoredEvent RunLog::own_event(std::string text) const {
  StoredEvent event;
  event.utc = utc_now();
  event.what = "recording";
  event.text = std::move(text);
  return event;
}

void RunLog::gap(std::uint64_t lost) {
  caught_up();
  const std::string why = "recorder fell behind";
  const std::string text = why + ": " + std::to_string(lost) + " records of the stream are lost";
  if (run_) {
    const std::string run = named(*run_);
    const bool goes_on = run_->ending.empty();
    if (goes_on) {
      note(own_event(text));
      keep_label(run_->label, run_->header.comment);
    }
    end_now(why);
    if (goes_on) interrupted(run + " ended: " + text);
    stop(text);  // after the run's end as well: another run may have begun in what is lost
  } else {
    options_.tell({Notice::Grade::error, text, 0, {}});
  }
  cutter_.clear();
  cutter_.skip(lost);
  kept_.clear();
  early_.clear();
  follows_ = false;
}

// A block is complete. Writes it into the file, or keeps it.
void RunLog::cut() {
  if (run_ && run_->ending.empty()) return write_block();
  if (run_) close(take_notes(run_->last_t_ns), run_->ending);
  if (cutter_.empty()) return;
  if (follows_) return kept_.add(cutter_.take());
  cutter_.clear();
}

void RunLog::write_block() {
  if (!cutter_.empty()) write(take_batch());
}

void RunLog::write(std::vector<NewEntry> batch) {
  if (!first_.empty()) return begin_file(std::move(batch));
  if (auto written = store_.write(batch); !written) return fail(std::move(batch), written.error());
  run_->committed_ns = now_.raw_ns;
  for (const NewEntry& entry : batch) run_->bytes += entry.body.size();
}

// The block so far and what belongs to it.
std::vector<NewEntry> RunLog::take_batch() {
  std::vector<NewEntry> batch;
  if (!cutter_.empty()) {
    Block block = cutter_.take();
    count(*run_, block);
    batch.push_back(stream_entry(std::move(block)));
  }
  std::vector<NewEntry> notes = take_notes(run_->last_t_ns);
  std::move(notes.begin(), notes.end(), std::back_inserter(batch));
  return batch;
}

// Like the block beside them they cover the time up to t_ns.
std::vector<NewEntry> RunLog::take_notes(std::int64_t t_ns) {
  const auto utc_at = [this](std::int64_t at_ns) { return iso_utc(utc_of(now_, at_ns)); };
  for (const StoredEvent& told : told_by_stream_.drain(options_.names, utc_at))
    notes_.push_back({"event", 0, to_json(told)});
  std::vector<NewEntry> notes = std::exchange(notes_, {});
  for (NewEntry& note : notes) note.t_ns = t_ns;
  return notes;
}

RunHeader RunLog::make_header(const Request* request, std::int64_t first_t_ns) {
  RunHeader header = options_.header();
  const bool operators = request != nullptr && request->event.person;
  header.begun_by = operators                              ? "operator"
                    : interruption_.may_go_on(now_.raw_ns) ? "service"
                    : request != nullptr                   ? "operator"
                                                           : "drive";
  if (request != nullptr) {
    header.label = request->label;
    header.comment = request->event.comment;
    header.person = request->event.person;
  } else if (header.begun_by == "service") {
    header.label = interruption_.label();
    header.comment = interruption_.comment();
  }
  header.start_utc = iso_utc(utc_of(now_, first_t_ns));
  return header;
}

void RunLog::begin(const Record& edge) {
  caught_up();
  if (run_ && run_->ending.empty()) end_now("another run begins");
  cut();
  const auto ago = static_cast<std::uint64_t>(std::max(edge.value, 0.0));
  const std::uint64_t born = cutter_.number() - std::min(ago, cutter_.number());
  std::deque<Block> blocks = kept_.take_from(born);
  if (!std::exchange(follows_, false) || blocks.empty()) return stop("the time before the run is not in memory");
  RunProgress run;
  run.header = make_header(requests_.of(edge), blocks.front().first_t_ns);
  run.label = run.header.label;
  run.born = born;
  run.first_t_ns = blocks.front().first_t_ns;
  std::vector<NewEntry> batch;
  for (Block& block : blocks) {
    count(run, block);
    for (const auto& [number, told] : block.told) told_by_stream_.take(told, number + 1 - born);
    batch.push_back(stream_entry(std::move(block)));
  }
  add_early_events(born, batch.back().t_ns, batch);
  run_ = std::move(run);
  first_ = std::move(batch);
  note_request(edge);
}

// Makes the file of the run, with its first entries and `more` in one batch. If that fails, there is no run.
void RunLog::begin_file(std::vector<NewEntry> more) {
  std::vector<NewEntry> batch = std::exchange(first_, {});
  std::move(more.begin(), more.end(), std::back_inserter(batch));
  if (auto begun = store_.begin(run_->header, run_->first_t_ns, batch); !begun) {
    keep_label(run_->label, run_->header.comment);
    run_.reset();
    notes_.clear();
    told_by_stream_ = {};
    return stop(begun.error());
  }
  run_->committed_ns = now_.raw_ns;
  for (const NewEntry& entry : batch) run_->bytes += entry.body.size();
  interruption_.over();
  take_labels();
  options_.tell(
      {Notice::Grade::info, "recording " + named(*run_) + ", begun by " + run_->header.begun_by, run_->header.run, {}});
}

void RunLog::add_early_events(std::uint64_t born, std::int64_t t_ns, std::vector<NewEntry>& batch) {
  std::vector<NewEntry> early = early_.take_from(born, t_ns);
  std::move(early.begin(), early.end(), std::back_inserter(batch));
  if (interruption_.interrupted_by().empty()) return;
  StoredEvent event = own_event("goes on after an interruption: " + interruption_.interrupted_by());
  event.position = cutter_.number() + 1 - born;
  batch.push_back({"event", t_ns, to_json(event)});
}

// The last dwell may end with the run, so the file is closed with the next block. The run's last block waits for the
// next record. If that begins another run, both are written with one wait for the disk.
void RunLog::end(const Record& edge) {
  caught_up();
  interruption_.run_ended();
  if (!run_ || !run_->ending.empty()) return cut();
  note_request(edge);
  last_ = take_batch();
  last_ns_ = now_.raw_ns;
  run_->ending = why_text(static_cast<EndOfRun>(edge.value));
}

void RunLog::end_now(const std::string& why) {
  if (run_->ending.empty()) {
    close(take_batch(), why);
  } else {
    close(take_notes(run_->last_t_ns), run_->ending);
  }
}

// The reserve takes the batch that the disk refused, and the reason.
void RunLog::fail(std::vector<NewEntry> batch, const std::string& reason) {
  if (!run_->ending.empty()) {  // the run has ended already: nothing stops
    std::vector<NewEntry> notes = take_notes(run_->last_t_ns);
    batch.insert(batch.end(), std::make_move_iterator(notes.begin()), std::make_move_iterator(notes.end()));
    return close(std::move(batch), run_->ending);
  }
  const std::string run = named(*run_);
  StoredEvent event = own_event("recording stops: " + reason);
  event.position = run_->records;
  batch.push_back({"event", run_->last_t_ns, to_json(event)});
  keep_label(run_->label, run_->header.comment);
  close(std::move(batch), reason);
  interrupted(run + " ended: " + reason);
  stop(reason);
}

void RunLog::close(std::vector<NewEntry> batch, std::string why) {
  const std::int64_t t_ns = run_->last_t_ns;
  batch.insert(batch.begin(), std::make_move_iterator(last_.begin()), std::make_move_iterator(last_.end()));
  last_.clear();
  batch.push_back({"end", t_ns,
                   to_json(RunEnd{why, run_->records, run_->samples, utc_now(),
                                  run_->label == run_->header.label ? std::string() : run_->label})});
  const auto ended = store_.end(batch);
  const RunProgress run = *std::exchange(run_, std::nullopt);
  const std::string text = named(run) + " ended: " + why + "; " + seconds_text(t_ns - run.first_t_ns) + ", " +
                           std::to_string(run.samples) + " samples, " + std::to_string(run.dwells) +
                           (run.dwells == 1 ? " dwell" : " dwells");
  if (ended) return options_.tell({Notice::Grade::info, text, run.header.run, {}});
  options_.tell({Notice::Grade::error, text + "; its end could not be recorded: " + ended.error(), run.header.run, {}});
}

void RunLog::stop(const std::string& why) {
  interruption_.stopped(why, now_.raw_ns);
  kept_.clear();
  follows_ = false;
  options_.tell({Notice::Grade::error, "recording stops: " + why + "; measuring goes on", 0, {}});
}

void RunLog::finish() {
  caught_up();
  if (run_) end_now("service stopped");
}

}  // namespace dwell::record
