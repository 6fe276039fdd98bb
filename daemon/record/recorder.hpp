// Records the runs of one rig. Takes the ordered stream from the estimation thread and writes each run into its own
// file, on a thread of its own. The estimation never waits for it.
//
// If the disk is full, or falls behind for longer than the buffer lasts, recording stops: with an event in the file, a
// line in the log and an alarm in the health. Measuring goes on. As soon as there is room again, the recorder asks for
// a new run, see take_restart().
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/record/housekeeper.hpp"
#include "daemon/record/request.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_list.hpp"
#include "daemon/record/run_log.hpp"
#include "daemon/record/stream_sink.hpp"

namespace dwell::record {

struct RecorderOptions {
  FolderOptions folder;
  RetentionPolicy retention;
  AnchorTarget anchor;
  double rate_hz = 0.0;  // samples per second of all channels together: sizes the buffer
  // These five are called on the recorder's thread and must not wait. The first four: see RunLogOptions.
  std::function<RunHeader()> header;
  std::function<std::string(const Dwell&, const std::string& start_utc)> dwell_json;
  std::function<StoredModel(const ModelResult&)> model_json;
  std::function<std::string(State before, const Dwell& after)> state_line;
  Tell tell;
  StreamNames names;
  // HousekeepingOptions
  std::function<bool()> clock_synchronized = record::clock_synchronized;
};

// Why runs are not recorded as they should.
struct RecorderAlarm {
  const char* name = "";  // of the kind: "recording", "runs", "anchor", "disk"
  std::string text;       // one line
};

// The state of the recording.
struct RecorderState {
  std::string directory;  // of the runs
  bool recording = false;
  std::string why_not;  // while it does not record: "no run goes on", or another reason
  Obstacle obstacle;
  std::uint16_t newest_start = 0;  // number of the operator's newest start that has come through the stream; 0: none
  ListedRun run;                   // the one being recorded
  double buffer_fill = 0.0;        // 0 … 1
  std::uint64_t buffer_records = 0;
  std::int64_t committed_ns = 0;                                      // CLOCK_MONOTONIC_RAW, the last commit of the run
  std::uint64_t lost_records = 0, lost_results = 0, lost_events = 0;  // since the service began
  std::vector<RecorderAlarm> alarms;
};

class Recorder final : public StreamSink, public RequestSink {
 public:
  // Most events and requests that wait. Further ones are lost; run and log say how many.
  static constexpr std::size_t kInbox = 256;

  // Starts its thread. Never fails: if it cannot record, it raises an alarm and tries again.
  explicit Recorder(RecorderOptions options);
  // As finish().
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void record(const Record& record) noexcept override;
  void result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) override;
  void model(std::uint64_t position, ModelResult result) override;
  void state(const StateChange& change, std::shared_ptr<const Dwell> after) override;
  void request(Request request) override;
  [[nodiscard]] Obstacle obstacle() const override;
  // Stores the event in the file of the current run, or of the next run if that reaches back so far. Thread-safe, short
  // lock.
  void event(StoredEvent event);

  // Waits, at most `limit`, until the first run's file is made or cannot be made; false: neither is known by then. Data
  // that arrive earlier are in memory only. Thread-safe.
  [[nodiscard]] bool await_first_file(std::chrono::milliseconds limit) const;

  // Writes everything received so far, ends the run, and gives the last anchors up to 5 s to arrive. Afterwards nothing
  // is taken any more. Not thread-safe; may be called again.
  void finish();

  // Adds a person's signature to the ledger. Thread-safe; waits until the ledger has it, after all that waits there.
  // Fails once the recorder has been told to finish.
  [[nodiscard]] Result<void> run_signed(std::int64_t run, const PersonalSignature& signature);

  // Whether the recorder wants a new run: it had to stop recording this one, and could record again. True once.
  // Thread-safe.
  [[nodiscard]] bool take_restart() noexcept;

  // Thread-safe, short lock. now_ns: CLOCK_MONOTONIC_RAW.
  [[nodiscard]] RecorderState state(std::int64_t now_ns) const;
  [[nodiscard]] std::shared_ptr<const ListedRuns> runs() const;
  [[nodiscard]] std::shared_ptr<const RunVerdicts> audits() const;
  // When its thread last turned; any thread.
  [[nodiscard]] std::int64_t last_turn_ns() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
