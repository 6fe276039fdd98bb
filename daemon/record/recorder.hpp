// Records the runs of one rig: takes the ordered stream from the estimation thread and writes each run into a file of
// its own, on a thread of its own. The estimation never waits for it.
//
// Where the disk is full, or falls behind for longer than the buffer lasts, recording stops with an event in the file,
// a line in the log and an alarm in the health; measuring goes on. As soon as there is room again it asks for a new
// run, see take_restart().
#pragma once

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
  double rate_hz = 0.0;               // samples per second of all channels together: sizes the buffer
  std::function<RunHeader()> header;  // RunLogOptions; called on the recorder's thread, as is …
  std::function<std::string(const Dwell&, const std::string& start_utc)> dwell_json;
  Tell tell;  // … this
  StreamNames names;
};

// How the recording stands.
struct RecorderState {
  bool recording = false;
  std::string why_not;       // of one that does not record: "no run goes on", or what keeps it from it
  ListedRun run;             // that is recorded
  double buffer_fill = 0.0;  // 0 … 1
  std::uint64_t buffer_records = 0;
  std::int64_t committed_ns = 0;                                      // CLOCK_MONOTONIC_RAW, the last commit of the run
  std::uint64_t lost_records = 0, lost_results = 0, lost_events = 0;  // since the service began
  std::vector<std::string> alarms;                                    // one line each
};

class Recorder final : public StreamSink, public RequestSink {
 public:
  // Events and requests that wait at most; further ones are lost, and counted.
  static constexpr std::size_t kInbox = 256;
  // The recorder looks again whether it can record so often, and asks for a new run no more often than that: each ends
  // a dwell.
  static constexpr std::int64_t kRetry_ns = 30'000'000'000;

  // Starts its thread. Never fails: what keeps it from recording is an alarm, and tried again.
  explicit Recorder(RecorderOptions options);
  // Writes what has come and ends the run.
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;

  void record(const Record& record) noexcept override;
  void result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) override;
  void request(Request request) override;
  // Into the file of the run that goes on, or of the next one that reaches back so far. Thread-safe, short lock.
  void event(StoredEvent event);

  // Enters a person's signature into the ledger. Thread-safe; waits for the recorder's thread, and so for the disk.
  [[nodiscard]] Result<void> run_signed(std::int64_t run, const PersonalSignature& signature);

  // Whether a new run is wanted, since this one is not recorded any more and could be again: once. Thread-safe.
  [[nodiscard]] bool take_restart() noexcept;

  // Thread-safe, short lock. now_ns: CLOCK_MONOTONIC_RAW.
  [[nodiscard]] RecorderState state(std::int64_t now_ns) const;
  [[nodiscard]] std::shared_ptr<const ListedRuns> runs() const;
  // When its thread last turned; any thread.
  [[nodiscard]] std::int64_t last_turn_ns() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
