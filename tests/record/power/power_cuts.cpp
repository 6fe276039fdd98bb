// A recording loses its power, and what is left is checked. tests/vm/scenarios/72-power.sh runs the three steps:
//
//   power_cuts record DIRECTORY DEVICE CUTS SEED   records runs in DIRECTORY; at CUTS random instants marks the log of
//                                                  the device-mapper device DEVICE under it, and prints what was
//                                                  recorded by each mark
//   power_cuts image LOG CUT SEED EXTRA IMAGE      writes into IMAGE, which holds what the device held at first, what
//                                                  was lasting at the cut; of what was under way EXTRA: none, all, some
//   power_cuts check CUTS CUT DIRECTORY            what is left there, after IMAGE was mounted
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <random>
#include <sstream>
#include <thread>

#include "daemon/clock.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/power/block_log.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/synthetic_stream.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kStep_ns = 10'000'000;
constexpr std::int64_t kAllowed_ns = 2'000'000'000;

// Of one run, in the stream's time. ended_ns: up to which it had come, of one that went on.
struct Part {
  std::int64_t begun_ns = 0, ended_ns = 0;
};

// What was recorded by an instant; run 1 first.
struct Recorded {
  std::int64_t reached_ns = 0;
  std::int64_t still_ns = 0;      // the longest that the recorder's thread had waited so far
  std::int64_t reported_run = 0;  // as Recorder::state() told it right before
  std::uint64_t reported_samples = 0;
  std::vector<Part> runs;
};

std::ostream& operator<<(std::ostream& out, const Recorded& recorded) {
  out << recorded.reached_ns << ' ' << recorded.still_ns << ' ' << recorded.reported_run << ' '
      << recorded.reported_samples << ' ' << recorded.runs.size();
  for (const Part& run : recorded.runs) out << ' ' << run.begun_ns << ' ' << run.ended_ns;
  return out;
}

std::istream& operator>>(std::istream& in, Recorded& recorded) {
  std::size_t runs = 0;
  in >> recorded.reached_ns >> recorded.still_ns >> recorded.reported_run >> recorded.reported_samples >> runs;
  recorded.runs.resize(std::min<std::size_t>(runs, 1000));
  for (Part& run : recorded.runs) in >> run.begun_ns >> run.ended_ns;
  return in;
}

std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f s", static_cast<double>(ns) * 1e-9);
  return text;
}

// The longest of some waits for the disk, each after a file has become longer.
std::int64_t longest_wait_ns(const std::string& directory) {
  const std::string path = directory + "/waits";
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  const std::string bytes(16384, 'x');
  std::int64_t longest_ns = 0;
  for (int n = 0; n < 5; ++n) {
    const std::int64_t began_ns = raw_now_ns();
    if (::write(file, bytes.data(), bytes.size()) < 0 || ::fdatasync(file) != 0) break;
    longest_ns = std::max(longest_ns, raw_now_ns() - began_ns);
  }
  ::close(file);
  ::unlink(path.c_str());
  return longest_ns;
}

// Records eight channels at 1 kHz in real time, runs of some seconds with pauses between them.
class Recording {
 public:
  explicit Recording(const std::string& directory, std::uint32_t seed)
      : random_(seed), recorder_(recorder_options(directory, notices_)) {}

  void go_on_until(const std::atomic<bool>& done) {
    const auto began = std::chrono::steady_clock::now();
    for (int step = 1; !done; ++step) {
      {
        const std::lock_guard lock(mutex_);
        turn(step);
      }
      std::this_thread::sleep_until(began + step * std::chrono::nanoseconds(kStep_ns));
    }
  }

  [[nodiscard]] RecorderState state() const { return recorder_.state(raw_now_ns()); }
  [[nodiscard]] Recorded recorded() const {
    const std::lock_guard lock(mutex_);
    return recorded_;
  }

 private:
  void turn(int step) {
    const std::int64_t t_ns = stream_.t_ns();
    if (t_ns >= change_ns_ && runs_) {
      stream_.ends();
      change_ns_ = t_ns + 300'000'000;
      runs_ = false;
    } else if (t_ns >= change_ns_) {
      stream_.armed();
      stream_.begins();
      recorded_.runs.push_back({t_ns, t_ns});
      change_ns_ = t_ns + std::uniform_int_distribution<std::int64_t>(1'000'000'000, 9'000'000'000)(random_);
      runs_ = true;
    }
    stream_.play(0.01);
    if (step % 10 == 0) recorder_.result(stream_.position(), step % 100 == 0, std::make_shared<const Dwell>());
    recorded_.reached_ns = stream_.t_ns();
    recorded_.still_ns = std::max(recorded_.still_ns, raw_now_ns() - recorder_.last_turn_ns());
    if (runs_) recorded_.runs.back().ended_ns = stream_.t_ns();
  }

  std::mt19937 random_;
  Notices notices_;
  Recorder recorder_;
  SyntheticStream stream_{8, 1000.0, [this](const Record& record) { recorder_.record(record); }};
  mutable std::mutex mutex_;
  Recorded recorded_;
  std::int64_t change_ns_ = 0;
  bool runs_ = false;
};

int record_and_mark(const std::string& directory, const std::string& device, int cuts, std::uint32_t seed) {
  std::fprintf(stderr, "the disk: fdatasync within %s\n", seconds(longest_wait_ns(directory)).c_str());
  std::mt19937 random(seed);
  Recording recording(directory, seed);
  std::atomic<bool> done{false};
  std::thread player([&] { recording.go_on_until(done); });
  int code = 0;
  for (int cut = 1; cut <= cuts && code == 0; ++cut) {
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 2'500'000));
    const RecorderState before = recording.state();
    if (const auto marked = mark_block_log(device, "cut" + std::to_string(cut)); !marked) {
      std::fprintf(stderr, "%s\n", marked.error().c_str());
      code = 2;
    }
    Recorded recorded = recording.recorded();
    recorded.reported_run = before.recording ? before.run.run : 0;
    recorded.reported_samples = before.run.samples;
    std::cout << recorded << std::endl;
  }
  // So that what was under way at the last cut stands in the log as well.
  std::this_thread::sleep_for(std::chrono::seconds(2));
  done = true;
  player.join();
  return code;
}

// Writes that were under way, as a device may leave them: each sector is the new or the old one.
class UnderWay {
 public:
  UnderWay(const std::string& extra, std::uint32_t seed) : random_(seed) {
    part_ = extra == "all" ? 1.0 : extra == "some" ? std::uniform_real_distribution<>(0.1, 0.9)(random_) : 0.0;
  }
  bool arrives() { return std::uniform_real_distribution<>(0.0, 1.0)(random_) < part_; }

 private:
  std::mt19937 random_;
  double part_;
};

int make_image(const std::string& log, const std::string& cut, std::uint32_t seed, const std::string& extra,
               const std::string& image) {
  constexpr std::size_t kSector = 512;
  const int file = ::open(image.c_str(), O_WRONLY | O_CLOEXEC);
  UnderWay under_way(extra, seed);
  std::size_t lasting = 0, arrived = 0, lost = 0;
  bool written = file >= 0;
  const auto read = read_block_log(log, "cut" + cut, [&](const LoggedWrite& write) {
    for (std::size_t at = 0; at < write.bytes.size(); at += kSector) {
      const std::size_t size = write.lasting ? write.bytes.size() : kSector;
      const bool arrives = write.lasting || under_way.arrives();
      ++(write.lasting ? lasting : arrives ? arrived : lost);
      if (arrives)
        written = written && ::pwrite(file, write.bytes.data() + at, size, static_cast<off_t>(write.offset + at)) ==
                                 static_cast<ssize_t>(size);
      if (write.lasting) break;
    }
  });
  if (file >= 0) ::close(file);
  if (!read || !written) {
    std::fprintf(stderr, "%s\n", read ? (image + ": " + std::strerror(errno)).c_str() : read.error().c_str());
    return 2;
  }
  std::printf("%zu lasting writes, of those under way %zu sectors arrived, %zu did not\n", lasting, arrived, lost);
  return 0;
}

// Prints what is wrong, and remembers that something was.
class Findings {
 public:
  void add(const std::string& what) {
    std::printf("%s\n", what.c_str());
    any_ = true;
  }
  [[nodiscard]] int code() const noexcept { return any_ ? 1 : 0; }

 private:
  bool any_ = false;
};

std::map<std::int64_t, std::string> run_files(const std::string& directory) {
  std::map<std::int64_t, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(directory))
    if (const std::int64_t run = run_of_file_name(entry.path().filename().string()); run > 0)
      files[run] = entry.path().string();
  return files;
}

// How much of the newest run, or of one that ended shortly before, is not there: back from the cut.
std::int64_t check_runs(const Recorded& recorded, const std::string& directory, Findings& findings) {
  const auto files = run_files(directory);
  AuditOptions options;
  options.ledger = directory + "/ledger.dwell-ledger";
  std::int64_t worst_ns = 0;
  for (std::size_t k = 0; k < recorded.runs.size(); ++k) {
    const Part& run = recorded.runs[k];
    const auto number = static_cast<std::int64_t>(k + 1);
    const std::string name = "run " + std::to_string(number);
    const auto file = files.find(number);
    std::int64_t held_ns = run.begun_ns;
    std::uint64_t samples = 0;
    if (file != files.end()) {
      auto audit = audit_run(file->second, options);
      // Cut off between its file and its entry in the ledger: go_on() must enter it.
      if (!audit && audit.error().cause() == Cause::not_entered) audit = audit_run(file->second, {});
      if (!audit || audit->state == AuditState::tampered)
        findings.add(name + ": " + (audit ? "tampered: " + audit->where : std::string(audit.error())));
      if (audit) samples = audit->samples;
      const auto reader = RunReader::open(file->second);
      if (reader) held_ns = std::max(held_ns, reader->end_ns());
      // Nothing but the bare tables: the first commit had not come.
      if (!reader && (!audit || audit->samples > 0)) findings.add(name + ": " + reader.error());
    }
    if (recorded.reported_run == number && samples < recorded.reported_samples)
      findings.add(name + ": " + std::to_string(recorded.reported_samples) + " samples were reported as written, " +
                   std::to_string(samples) + " are there");
    if (held_ns < run.ended_ns) worst_ns = std::max(worst_ns, recorded.reached_ns - held_ns);
  }
  if (worst_ns > kAllowed_ns) findings.add(seconds(worst_ns) + " are lost");
  return worst_ns;
}

// A run has its file before it enters the ledger, so none is ever missing.
void check_ledger(const std::string& directory, bool started, Findings& findings) {
  const char* const when = started ? "after the next start: " : "at the cut: ";
  const auto ledger = audit_ledger(directory + "/ledger.dwell-ledger", directory, {});
  if (!ledger) return findings.add(when + ledger.error());
  if (!ledger->unbroken) findings.add(when + ("the ledger: " + ledger->where));
  for (const std::string& missing : ledger->missing) findings.add(when + ("missing: " + missing));
}

// The service starts again, the drive being on.
void go_on(const std::string& directory, Findings& findings) {
  std::int64_t before = 0;
  bool open = false;
  for (const auto& [run, file] : run_files(directory)) {
    const auto reader = RunReader::open(file);
    open = reader && !reader->end();
    before = run;
  }
  Notices notices;
  {
    Recorder recorder(recorder_options(directory, notices));
    SyntheticStream stream(8, 1000.0, [&](const Record& record) { recorder.record(record); });
    stream.armed();
    stream.begins();
    stream.play(1.5);
    stream.ends();
  }
  if (open && !notices.hold("was cut off")) findings.add("the start after the cut: " + notices.text());
  const auto files = run_files(directory);
  if (files.empty() || files.rbegin()->first <= before) return findings.add("no new run: " + notices.text());
  const std::string file = files.rbegin()->second;
  const auto audit = audit_run(file, {});
  if (!audit || audit->state != AuditState::intact) findings.add("the new run is not intact");
  auto reader = RunReader::open(file);
  bool told = false;
  if (reader) [[maybe_unused]]
    auto read = reader->events([&](const StoredEvent& event) {
      told = told || event.text.find("goes on after an interruption") != std::string::npos;
      return true;
    });
  if (open && !told) findings.add("the new run does not tell of the one that was cut off");
}

// After the next start the ledger knows each run that has a file.
void check_entered(const std::string& directory, Findings& findings) {
  AuditOptions options;
  options.ledger = directory + "/ledger.dwell-ledger";
  for (const auto& [run, file] : run_files(directory)) {
    const auto audit = audit_run(file, options);
    if (!audit || audit->state == AuditState::tampered)
      findings.add("after the next start: run " + std::to_string(run) + ": " +
                   (audit ? "tampered: " + audit->where : std::string(audit.error())));
  }
}

int check(const std::string& cuts, int cut, const std::string& directory) {
  std::ifstream file(cuts);
  Recorded recorded;
  std::string line;
  for (int n = 0; n < cut; ++n) std::getline(file, line);
  if (!file || !(std::istringstream(line) >> recorded)) {
    std::fprintf(stderr, "%s: has no line %d\n", cuts.c_str(), cut);
    return 2;
  }
  Findings findings;
  const std::int64_t lost_ns = check_runs(recorded, directory, findings);
  if (std::filesystem::exists(directory + "/ledger.dwell-ledger")) check_ledger(directory, false, findings);
  go_on(directory, findings);
  check_ledger(directory, true, findings);
  check_entered(directory, findings);
  std::printf("cut %d: run %zu, lost %s, longest wait %s\n", cut, recorded.runs.size(), seconds(lost_ns).c_str(),
              seconds(recorded.still_ns).c_str());
  return findings.code();
}

}  // namespace
}  // namespace dwell::record

int main(int argc, char** argv) {
  using namespace dwell::record;
  const std::string verb = argc > 1 ? argv[1] : "";
  const auto number = [&](int n) { return static_cast<std::uint32_t>(std::strtoul(argv[n], nullptr, 10)); };
  if (verb == "record" && argc == 6) return record_and_mark(argv[2], argv[3], static_cast<int>(number(4)), number(5));
  if (verb == "image" && argc == 7) return make_image(argv[2], argv[3], number(4), argv[5], argv[6]);
  if (verb == "check" && argc == 5) return check(argv[2], static_cast<int>(number(3)), argv[4]);
  std::fprintf(stderr,
               "usage: power_cuts record DIRECTORY DEVICE CUTS SEED | image LOG CUT SEED none|all|some IMAGE | "
               "check CUTS CUT DIRECTORY\n");
  return 2;
}
