#include "tests/rigsim/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ostream>
#include <random>

#include "tests/rigsim/control.hpp"

namespace rigsim {
namespace {

struct Action {
  double t_s;
  std::vector<std::string> words;
};

void write(std::ostream& out, double value) {
  char buffer[40];
  out.write(buffer, std::snprintf(buffer, sizeof buffer, "%.17g", value));
}

std::string parse_script(const std::vector<std::string>& script, std::vector<Action>& actions) {
  for (const std::string& line : script) {
    auto words = split_words(line);
    const auto t_s = words.empty() ? std::nullopt : number(words[0]);
    if (!t_s || words.size() < 2 || (!actions.empty() && *t_s < actions.back().t_s))
      return "--at '" + line + "': expected SECONDS CONTROL LINE, in the order of time";
    words.erase(words.begin());
    actions.push_back({*t_s, std::move(words)});
  }
  return {};
}

// The device, and the actions that come due while it is read in the order of time.
class Scripted {
 public:
  Scripted(const Options& rig, std::vector<Action> actions) : device(rig), actions_(std::move(actions)) {}

  // Reads all channels at t ≥ the t before; what is wrong with an action, or empty.
  std::string read(double t_s, std::vector<double>& values) {
    for (; next_ < actions_.size() && actions_[next_].t_s <= t_s; ++next_) {
      const auto answer = execute(device, actions_[next_].t_s, actions_[next_].words);
      if (!answer || *answer != "ok")
        return answer ? *answer : "not possible in a recording: " + actions_[next_].words[0];
    }
    // A scan without skew and jitter is one reading of all channels.
    if (t_s != read_s_) device.read(t_s, values);
    read_s_ = t_s;
    return {};
  }

  Device device;

 private:
  std::vector<Action> actions_;
  std::size_t next_ = 0;
  double read_s_ = -1.0;
};

}  // namespace

std::string write_recording(std::ostream& out, const Options& rig, const RecordingOptions& recording) {
  std::vector<Action> actions;
  if (std::string wrong = parse_script(recording.script, actions); !wrong.empty()) return wrong;
  Scripted scripted(rig, std::move(actions));
  const auto& channels = scripted.device.channels();
  const std::size_t count = channels.size();
  const double interval_s = 1.0 / recording.rate_hz;
  const auto scans = static_cast<long long>(std::floor(recording.duration_s * recording.rate_hz * (1 + 1e-12))) + 1;

  std::mt19937_64 random(rig.seed ^ 0x9E3779B97F4A7C15ULL);
  std::uniform_real_distribution<double> jitter(-recording.jitter * interval_s, recording.jitter * interval_s);
  struct Sample {
    double t_s;
    long long scan;
  };
  std::vector<Sample> next(count);
  const auto plan = [&](std::size_t i, long long scan) {
    const double lag_s = count > 1 ? recording.skew_s * static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
    next[i] = {std::max(0.0, static_cast<double>(scan) / recording.rate_hz + lag_s + jitter(random)), scan};
  };
  for (std::size_t i = 0; i < count; ++i) plan(i, 0);

  out << (recording.long_form ? "t,channel,value" : "t");
  if (!recording.long_form)
    for (const std::string& channel : channels) out << ',' << channel;
  out << '\n';

  // Samples are taken in the order of time over all channels, since the script acts in that order. Wide rows wait until
  // their last channel has been sampled.
  std::vector<double> values(count);
  struct Row {
    std::vector<double> values;
    std::size_t missing;
  };
  std::vector<Row> rows;  // from scan `first_row` on
  long long first_row = 0;
  while (true) {
    const auto earliest = std::min_element(next.begin(), next.end(), [scans](const Sample& a, const Sample& b) {
      if ((a.scan < scans) != (b.scan < scans)) return a.scan < scans;
      return a.t_s < b.t_s;
    });
    if (earliest->scan >= scans) return {};
    const auto i = static_cast<std::size_t>(earliest - next.begin());
    const Sample sample = *earliest;
    plan(i, sample.scan + 1);
    if (std::string wrong = scripted.read(sample.t_s, values); !wrong.empty()) return wrong;
    const double value = values[i] * (scripted.device.is_force(i) || !rig.millimetres ? 1.0 : 1e3);
    if (recording.long_form) {
      if (std::isnan(value)) continue;
      write(out, sample.t_s);
      out << ',' << channels[i] << ',';
      write(out, value);
      out << '\n';
      continue;
    }
    while (first_row + static_cast<long long>(rows.size()) <= sample.scan)
      rows.push_back({std::vector<double>(count), count});
    Row& row = rows[static_cast<std::size_t>(sample.scan - first_row)];
    row.values[i] = value;
    --row.missing;
    while (!rows.empty() && rows.front().missing == 0) {
      write(out, static_cast<double>(first_row) / recording.rate_hz);
      for (const double cell : rows.front().values) {
        out << ',';
        if (!std::isnan(cell)) write(out, cell);
      }
      out << '\n';
      rows.erase(rows.begin());
      ++first_row;
    }
  }
}

}  // namespace rigsim
