#include "daemon/record/recorder.hpp"

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <future>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "daemon/clock.hpp"
#include "daemon/record/readiness.hpp"
#include "daemon/record/record_ring.hpp"

namespace dwell::record {
namespace {

// Between two turns. Doubled, the buffer fills more, and a power failure loses more. Halved, there are more wake-ups.
constexpr std::chrono::milliseconds kTurn{20};
// The last anchors may take so long when the service ends. systemd's patience is 15 s.
constexpr std::chrono::seconds kLastAnchor{5};
// If the thread has not turned for so long, it waits for the disk: an alarm.
constexpr std::int64_t kStall_ns = 2'000'000'000;

// Input that does not come through the stream, in its order.
class Inbox {
 public:
  using Letter = std::variant<StoredEvent, Request>;
  struct Mail {
    std::vector<Letter> letters;
    std::uint64_t lost = 0;  // behind the letters
  };

  void put(Letter letter) {
    const std::lock_guard lock(mutex_);
    if (mail_.letters.size() == Recorder::kInbox) {
      ++mail_.lost;
      lost_.fetch_add(1, std::memory_order_relaxed);
    } else {
      mail_.letters.push_back(std::move(letter));
    }
  }
  [[nodiscard]] Mail take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(mail_, {});
  }
  // Since the start.
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  std::mutex mutex_;
  Mail mail_;
  std::atomic<std::uint64_t> lost_{0};
};

bool may_bear_request(const Record& record) {
  return record.channel != 0 && (record.kind == Kind::run || record.kind == Kind::action);
}

std::string stall_text(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f s", static_cast<double>(ns) * 1e-9);
  return text;
}

// A question to the recorder's thread, and its answer.
struct Entering {
  std::int64_t run;
  PersonalSignature signature;
  std::promise<std::future<Result<void>>> entered;
};

}  // namespace

// The thread last: it uses all other members.
struct Recorder::Impl {
  explicit Impl(RecorderOptions options)
      : directory(options.folder.directory),
        tell(options.tell),
        ring(ring_records(options.rate_hz)),
        folder(options.folder),
        keeper({options.folder.directory, options.retention, options.anchor, options.clock_synchronized}, folder, list,
               options.tell),
        log(folder,
            {options.header, options.dwell_json, options.model_json, options.state_line, options.tell, options.names}),
        thread([this] { run(); }) {}
  ~Impl() { finish(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  const std::string directory;
  const Tell tell;
  RecordRing ring;
  Inbox inbox;
  // The recorder's thread alone, from here …
  const std::shared_ptr<RunList> list = std::make_shared<RunList>();
  RunFolder folder;
  Housekeeper keeper;
  RunLog log;
  ListedRun recorded;              // the run that is recorded
  std::uint16_t newest_start = 0;  // RecorderState
  Readiness readiness{folder, log, tell};
  // … to here.
  std::atomic<bool> restart{false};
  std::atomic<std::int64_t> turned_ns{raw_now_ns()};
  // What other threads ask for and are told. `mutex` guards the rest of it.
  struct Shared {
    std::mutex mutex;
    std::condition_variable wake;
    bool stop = false;
    RecorderState state;
    std::vector<Entering> signatures;  // for the ledger
  };
  Shared shared;
  std::promise<void> first_file_tried;  // set once the first file is made, or cannot be
  const std::shared_future<void> first_file = first_file_tried.get_future().share();
  std::thread thread;

  void finish() {
    {
      const std::lock_guard lock(shared.mutex);
      shared.stop = true;
    }
    shared.wake.notify_all();
    if (thread.joinable()) thread.join();
  }

  void run() {
    pthread_setname_np(pthread_self(), "recorder");
    turn({raw_now_ns(), utc_now_ns()});
    folder.settle();
    first_file_tried.set_value();
    for (bool last = false; !last;) {
      {
        std::unique_lock lock(shared.mutex);
        last = shared.wake.wait_for(lock, kTurn, [this] { return shared.stop; });
      }
      turn({raw_now_ns(), utc_now_ns()});
    }
    log.finish();
    // So that the list and the last anchor get the end of the run.
    folder.settle();
    tell_failures();
    if (readiness.open()) keeper.turn({raw_now_ns(), utc_now_ns()}, nullptr);
    keeper.settle({raw_now_ns(), utc_now_ns()}, kLastAnchor);
  }

  void turn(const ClockPair& now) {
    const bool recorded_before = log.progress() != nullptr;
    log.set_clock(now);
    if (readiness.turn(now)) restart.store(true, std::memory_order_relaxed);
    read_inbox();
    ring.drain({[this, &now](const Record& record) {
                  if (may_bear_request(record)) read_inbox();
                  const bool begins = is_edge(record, RunEdge::begins);
                  if (begins && record.channel != 0) newest_start = record.channel;
                  // A run begins in an open directory only: what a crash left there must be told first.
                  if (begins && !readiness.open() && readiness.look(now))
                    restart.store(true, std::memory_order_relaxed);
                  log.record(record);
                },
                [this](const RingResult& result) {
                  if (result.change)
                    log.state(*result.change, *result.dwell);
                  else if (result.dwell)
                    log.result(result.position, result.final, *result.dwell);
                  else
                    log.model(result.position, result.model);
                },
                [this](std::uint64_t lost) { log.gap(lost); }});
    if (const std::uint64_t lost = ring.take_lost_results(); lost > 0)
      tell_loss(std::to_string(lost) + " results are lost: the recorder fell behind");
    log.caught_up();
    // Is it the disk, and how much room is missing?
    if (recorded_before && !log.stopped().empty() && readiness.look(now))
      restart.store(true, std::memory_order_relaxed);
    refresh_recorded();
    tell_failures();
    if (readiness.open()) keeper.turn(now, recorded.file.empty() ? nullptr : &recorded);
    enter_signatures();
    publish();
    turned_ns.store(now.raw_ns, std::memory_order_relaxed);
  }

  void tell_failures() {
    for (const std::string& failure : folder.take_failures()) tell({Notice::Grade::error, failure, 0, {}});
  }

  void enter_signatures() {
    std::vector<Entering> asked;
    {
      const std::lock_guard lock(shared.mutex);
      asked.swap(shared.signatures);
    }
    for (Entering& entering : asked) entering.entered.set_value(folder.run_signed(entering.run, entering.signature));
  }

  void read_inbox() {
    Inbox::Mail mail = inbox.take();
    for (Inbox::Letter& letter : mail.letters) {
      if (auto* request = std::get_if<Request>(&letter)) {
        log.request(std::move(*request));
      } else {
        log.event(std::move(std::get<StoredEvent>(letter)));
      }
    }
    if (mail.lost > 0)
      tell_loss(std::to_string(mail.lost) + " events are lost: more than " + std::to_string(kInbox) +
                " waited for the recorder");
  }

  void tell_loss(std::string text) {
    log.caught_up();
    StoredEvent event;
    event.what = "loss";
    event.text = std::move(text);
    const std::int64_t run = log.progress() != nullptr ? log.progress()->header.run : 0;
    tell({Notice::Grade::error, event.text, run, {}});
    log.event(std::move(event));
  }

  void refresh_recorded() {
    const RunProgress* progress = log.progress();
    if (progress == nullptr) {
      recorded = {};
      return;
    }
    recorded.run = progress->header.run;
    recorded.file = folder.file();
    recorded.label = progress->label;
    recorded.begun_by = progress->header.begun_by;
    recorded.begun_utc = progress->header.start_utc;
    recorded.state = "recording";
    recorded.bytes = progress->bytes;
    recorded.samples = progress->samples;
    recorded.dwells = progress->dwells;
  }

  void publish() {
    RecorderState fresh;
    fresh.directory = directory;
    fresh.recording = log.progress() != nullptr;
    const std::string why = readiness.why_not();
    if (!fresh.recording) fresh.why_not = why;
    if (!fresh.recording && fresh.why_not.empty()) fresh.why_not = readiness.open() ? "no run goes on" : "starting";
    if (!fresh.recording) fresh.obstacle = {why, !readiness.trouble().empty()};
    fresh.newest_start = newest_start;
    fresh.run = recorded;
    fresh.buffer_fill = ring.fill();
    fresh.buffer_records = ring.capacity();
    fresh.committed_ns = fresh.recording ? log.progress()->committed_ns : 0;
    fresh.lost_records = ring.lost_records();
    fresh.lost_results = ring.lost_results();
    fresh.lost_events = inbox.lost();
    if (!log.stopped().empty())
      fresh.alarms.push_back({"recording", "the run is not recorded: " + why});
    else if (!readiness.trouble().empty())
      fresh.alarms.push_back({"runs", "runs cannot be recorded: " + why});
    if (!keeper.anchor_trouble().empty())
      fresh.alarms.push_back({"anchor", "heads are not anchored: " + keeper.anchor_trouble()});
    const std::lock_guard lock(shared.mutex);
    shared.state = std::move(fresh);
  }
};

Recorder::Recorder(RecorderOptions options) : impl_(std::make_unique<Impl>(std::move(options))) {}
Recorder::~Recorder() = default;

void Recorder::record(const Record& record) noexcept { impl_->ring.push(record); }
void Recorder::result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) {
  impl_->ring.push(position, final, std::move(dwell));
}
void Recorder::model(std::uint64_t position, ModelResult result) { impl_->ring.push(position, std::move(result)); }
void Recorder::state(const StateChange& change, std::shared_ptr<const Dwell> after) {
  impl_->ring.push(change, std::move(after));
}
void Recorder::request(Request request) { impl_->inbox.put(std::move(request)); }
Obstacle Recorder::obstacle() const {
  const std::lock_guard lock(impl_->shared.mutex);
  return impl_->shared.state.obstacle;
}
void Recorder::event(StoredEvent event) { impl_->inbox.put(std::move(event)); }

Result<void> Recorder::run_signed(std::int64_t run, const PersonalSignature& signature) {
  Entering entering{run, signature, {}};
  std::future<std::future<Result<void>>> entered = entering.entered.get_future();
  {
    const std::lock_guard lock(impl_->shared.mutex);
    if (impl_->shared.stop) return tl::unexpected(std::string("the service is stopping"));
    impl_->shared.signatures.push_back(std::move(entering));
  }
  return entered.get().get();
}

bool Recorder::await_first_file(std::chrono::milliseconds limit) const {
  return impl_->first_file.wait_for(limit) == std::future_status::ready;
}
void Recorder::finish() { impl_->finish(); }

bool Recorder::take_restart() noexcept { return impl_->restart.exchange(false, std::memory_order_relaxed); }

RecorderState Recorder::state(std::int64_t now_ns) const {
  RecorderState state;
  {
    const std::lock_guard lock(impl_->shared.mutex);
    state = impl_->shared.state;
  }
  state.lost_records = impl_->ring.lost_records();
  const std::int64_t still_ns = now_ns - last_turn_ns();
  if (still_ns > kStall_ns) state.alarms.push_back({"disk", "the disk has not answered for " + stall_text(still_ns)});
  return state;
}

std::shared_ptr<const ListedRuns> Recorder::runs() const { return impl_->list->all(); }
std::shared_ptr<const RunVerdicts> Recorder::audits() const { return impl_->keeper.audits(); }
std::int64_t Recorder::last_turn_ns() const noexcept { return impl_->turned_ns.load(std::memory_order_relaxed); }

}  // namespace dwell::record
