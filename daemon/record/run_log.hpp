// Decides what is written and when: the blocks that a run begins with, the commits, the end of a run, what happens if
// the disk is full. Pure: it gets its time from the caller, and its disk is a RunStore.
//
// While no run goes on, it keeps the blocks that a run may reach back to. During a run, each block is written in one
// batch with its results and events, about once a second. So a loss of power costs the current block and the
// uncommitted ones: less than two seconds if the disk answers within half a second.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"
#include "daemon/record/awaiting_run.hpp"
#include "daemon/record/block_cutter.hpp"
#include "daemon/record/interruption.hpp"
#include "daemon/record/notice.hpp"
#include "daemon/record/request.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_store.hpp"
#include "daemon/record/stream_events.hpp"
#include "daemon/record/stream_sink.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {

// The run that is being recorded. Counts what is written.
struct RunProgress {
  RunHeader header;        // as its file has it
  std::string label;       // as of now; the header's is of the run's beginning
  std::uint64_t born = 0;  // number of its first record since the service began
  std::int64_t first_t_ns = 0, last_t_ns = 0;
  std::uint64_t records = 0, samples = 0, dwells = 0, bytes = 0;  // bytes: of the entries' bodies
  std::int64_t committed_ns = 0;                                  // the raw clock at the last commit
  // Why it has ended; empty: it goes on. Until the file is closed, final results of its last dwell may come.
  std::string ending;
};

struct RunLogOptions {
  std::function<RunHeader()> header;  // the members that do not depend on the run; called as a run begins
  // The JSON object of a dwell. The instant in UTC: the beginning of the run.
  std::function<std::string(const Dwell&, const std::string& start_utc)> dwell_json;
  // The entry of an estimate or a verification, without position and utc.
  std::function<StoredModel(const ModelResult&)> model_json;
  // A change of state, in one line.
  std::function<std::string(State before, const Dwell& after)> state_line;
  Tell tell;
  StreamNames names;
};

// Bound to one thread. Throws std::bad_alloc only.
class RunLog {
 public:
  // If the wall clock moves this far against the raw clock between two turns, it was set. An NTP slew of at most 500
  // ppm takes 20 s for it.
  static constexpr std::int64_t kClockStep_ns = 10'000'000;
  // The last block of an ended run waits for the next record, and no longer than this. If that record begins another
  // run, both are written with one wait for the disk. Longer: a loss of power costs more. Shorter: a run that follows
  // at once takes one more wait for the disk.
  static constexpr std::int64_t kSilence_ns = 500'000'000;

  // The store must outlive it.
  RunLog(RunStore& store, RunLogOptions options) : store_(store), options_(std::move(options)) {}
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  // Both clocks at one instant. Call it regularly: it stores an event if the wall clock was set, and writes the last
  // block of an ended run after kSilence_ns without a record.
  void set_clock(const ClockPair& now);
  void record(const Record& record);
  void result(std::uint64_t position, bool final, const Dwell& dwell);
  void model(std::uint64_t position, const ModelResult& result);
  // After the record that came last.
  void state(const StateChange& change, const Dwell& after);
  // Fills in the event's position and instant if they are not given.
  void event(StoredEvent event);
  // `lost` records of the stream are missing here: the run ends.
  void gap(std::uint64_t lost);
  // The request whose number a later record will have. Must come before that record.
  void request(Request request);
  // Recording was interrupted, for instance by a crash: the next run says so.
  void interrupted(std::string how) { interruption_.interrupted_by(std::move(how)); }
  // Of the interrupted run: the one that goes on has them too.
  void keep_label(std::string label, std::string comment) {
    interruption_.keep_label(std::move(label), std::move(comment));
  }
  // Call it after each turn, once the stream is read to its end. Makes the file of a run that has begun, unless a block
  // was completed since. Such a block goes into the first batch, which saves one wait for the disk.
  void caught_up() {
    if (!first_.empty()) begin_file({});
  }
  // See Interruption::goes_on().
  void goes_on() noexcept { interruption_.goes_on(now_.raw_ns); }
  // The service ends: so does the run.
  void finish();

  // What is being recorded; null: nothing. Between a run's beginning and caught_up() its header has no number yet.
  [[nodiscard]] const RunProgress* progress() const noexcept { return run_ ? &*run_ : nullptr; }
  // Why the current run is not recorded (any more); empty: it is, or there is none.
  [[nodiscard]] const std::string& stopped() const noexcept { return interruption_.why(); }
  [[nodiscard]] std::int64_t stopped_ns() const noexcept { return interruption_.stopped_ns(); }
  [[nodiscard]] std::size_t kept_bytes() const noexcept { return kept_.bytes(); }

 private:
  void cut();
  void write_block();
  void write(std::vector<NewEntry> batch);
  void begin(const Record& edge);
  void begin_file(std::vector<NewEntry> more);
  void end(const Record& edge);
  void end_now(const std::string& why);
  void stop(const std::string& why);
  void fail(std::vector<NewEntry> batch, const std::string& reason);
  void edge(const Record& record);
  // Gives the run that goes on the labels that wait for it.
  void take_labels();
  void relabel(Request request);
  void close(std::vector<NewEntry> batch, std::string why);
  [[nodiscard]] std::vector<NewEntry> take_batch();
  [[nodiscard]] std::vector<NewEntry> take_notes(std::int64_t t_ns);
  void note(StoredEvent event);
  void publish(std::string kind, std::uint64_t position, std::string body);
  void note_request(const Record& record);
  [[nodiscard]] RunHeader make_header(const Request* request, std::int64_t first_t_ns);
  void add_early_events(std::uint64_t born, std::int64_t t_ns, std::vector<NewEntry>& batch);
  [[nodiscard]] StoredEvent own_event(std::string text) const;
  [[nodiscard]] std::string utc_now() const { return iso_utc(now_.utc_ns); }

  RunStore& store_;
  const RunLogOptions options_;
  ClockPair now_;
  BlockCutter cutter_;
  KeptBlocks kept_;
  bool follows_ = false;  // kept_ and cutter_ hold the whole stream since the birth of a waiting pipeline
  EarlyEvents early_;
  StreamEvents told_by_stream_;
  std::vector<NewEntry> first_;  // what a run begins with, until its file is begun
  std::vector<NewEntry> notes_;  // results and events since the last block
  std::vector<NewEntry> last_;   // the last block of a run that has just ended, not written yet
  std::int64_t last_ns_ = 0;     // when that run ended, ns of the raw clock
  std::optional<RunProgress> run_;
  AwaitedRequests requests_;
  AwaitedLabels labels_;
  Interruption interruption_;
};

}  // namespace dwell::record
