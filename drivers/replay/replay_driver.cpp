// Plays a CSV recording as if a device delivered it. The recording's own instants are laid on CLOCK_MONOTONIC_RAW from
// the moment playing begins and keep their spacing whatever the speed: a faster replay measures the same frequency, it
// only arrives sooner, with stamps that run ahead of the clock.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "drivers/common/delivery.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/replay/csv_recording.hpp"

namespace dwell::driver {
namespace {

constexpr std::int64_t kRoom_ns = 1'000'000;  // before a full ring is asked again

constexpr dwell_key kKeys[] = {
    required(text_key(DWELL_DEVICE, "file", nullptr, "the recording, CSV: t,NAME,… or t,channel,value")),
    real_key(DWELL_DEVICE, "speed", 0.0, 1e6, "", "times real time; 0: as fast as it is taken; default 1"),
    flag_key(DWELL_DEVICE, "loop", "begin anew at the end; default false"),
    text_key(DWELL_CHANNEL, "column", nullptr, "the recording's name of the channel; default: the channel's own"),
};

std::string column_of(const ChannelSettings& channel) {
  return channel.get<std::string>("column", std::string(channel.name));
}

tl::expected<CsvRecording, std::string> read_file(const std::string& path, const std::function<bool()>& go_on = {}) {
  // Opening a pipe would wait for its other end, beyond the reach of stop.
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error))
    return tl::make_unexpected(path + ":1:1: is not a file");
  return read_csv(path, go_on);
}

std::string no_column(const std::string& column, const CsvRecording& recording) {
  std::string text = "the recording has no channel `" + column + "`; it has";
  for (std::size_t i = 0; i < recording.channels.size() && i < 8; ++i)
    text += (i > 0 ? ", " : " ") + recording.channels[i];
  return text + (recording.channels.size() > 8 ? ", …" : "");
}

class Replay {
 public:
  Replay(const Settings& settings, const Host& host)
      : host_(host),
        path_(settings.path(settings.get<std::string>("file", ""))),
        speed_(settings.get<double>("speed", 1.0)),
        loop_(settings.get<bool>("loop", false)),
        delivery_(host, settings.channels()) {
    for (const ChannelSettings& channel : settings.channels()) columns_.push_back(column_of(channel));
  }

  static void describe(const Settings& settings, dwell_traits& traits) {
    const auto speed = settings.get<double>("speed", 1.0);
    traits.recorded = 1;
    traits.leads = speed != 1.0 ? 1 : 0;
    traits.age_ns = speed > 0.0 && speed < 1.0 ? DWELL_AGE_UNBOUNDED : kRoom_ns;
  }

  void run(Stop& stop) {
    const auto recording = read_file(path_, [&] {
      stop.turn();
      return !stop.requested();
    });
    if (stop.requested()) return;
    if (!recording) throw std::runtime_error(recording.error());  // the wrapper tells it and tries again
    std::vector<int> channels(recording->channels.size(), -1);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const auto& names = recording->channels;
      const auto place = std::find(names.begin(), names.end(), columns_[i]);
      if (place == names.end())
        delivery_.tell(i, DWELL_FAULT_DISCONNECTED, no_column(columns_[i], *recording));
      else
        channels[static_cast<std::size_t>(place - names.begin())] = static_cast<int>(i);
    }
    play(recording->samples, channels, stop);
    if (!stop.requested()) delivery_.hold(DWELL_FAULT_END_OF_DATA, "the recording has been played to its end");
  }

  static void check(const Settings& settings, Report& report) {
    const auto recording = read_file(settings.path(settings.get<std::string>("file", "")));
    if (!recording) report.device("file", recording.error());
    std::set<std::string> taken;
    for (std::size_t i = 0; i < settings.channels().size(); ++i) {
      const std::string column = column_of(settings.channels()[i]);
      if (!taken.insert(column).second) report.channel(i, "column", "another channel takes `" + column + "` already");
      if (!recording) continue;
      const auto& names = recording->channels;
      if (std::find(names.begin(), names.end(), column) == names.end())
        report.channel(i, "column", no_column(column, *recording));
    }
  }

  static void probe(const Settings& settings, Probed& probed) {
    const auto recording = read_file(settings.path(settings.get<std::string>("file", "")));
    for (std::size_t i = 0; i < settings.channels().size(); ++i) {
      if (!recording) {
        probed.error(i, recording.error());
        continue;
      }
      const std::string column = column_of(settings.channels()[i]);
      const auto& samples = recording->samples;
      const auto first = std::find_if(samples.begin(), samples.end(), [&](const CsvRecording::Sample& sample) {
        return recording->channels[sample.column] == column;
      });
      if (first == samples.end())
        probed.error(i, no_column(column, *recording));
      else
        probed.value(i, first->value, 0);
    }
  }

 private:
  // `channels`: of each column, as the delivery counts them; -1: not wanted.
  void play(const std::vector<CsvRecording::Sample>& samples, const std::vector<int>& channels, Stop& stop) {
    const double first_s = samples.front().t_s;
    const double length_s = samples.back().t_s - first_s;
    std::size_t instants = 1;
    for (std::size_t i = 1; i < samples.size(); ++i) instants += samples[i].t_s > samples[i - 1].t_s ? 1U : 0U;
    // One mean step between the last instant of a pass and the first of the next.
    const double step_s = instants > 1 ? length_s / static_cast<double>(instants - 1) : 1.0;
    const std::int64_t start_ns = raw_ns();
    std::int64_t pass_ns = 0;
    bool delivered = false;  // a recording that has nothing of ours must not be looped without a pause
    do {
      for (std::size_t next = 0; next < samples.size();) {
        const std::int64_t since_start_ns = pass_ns + std::llround((samples[next].t_s - first_s) * 1e9);
        next = collect(samples, next, start_ns + since_start_ns, channels);
        if (delivery_.size() == 0) continue;
        delivered = true;
        if (speed_ > 0.0) {
          // The stamps' own clock decides when: the one that can be slept on is slewed against it, 20 ppm are 0.1 s in
          // an hour and a half, and what is stamped so long ago is late.
          const auto due_ns = start_ns + static_cast<std::int64_t>(static_cast<double>(since_start_ns) / speed_);
          if (!stop.sleep_for(due_ns - raw_ns())) return;
        } else if (!wait_for_room(stop)) {
          return;
        }
        delivery_.push();
      }
      pass_ns += std::max<std::int64_t>(1, std::llround((length_s + step_s) * 1e9));
      delivery_.lost();  // what follows does so after a jump in the recording
    } while (loop_ && delivered);
  }

  // Fills the scan with the samples of one instant; returns where the next instant begins.
  std::size_t collect(const std::vector<CsvRecording::Sample>& samples, std::size_t next, std::int64_t t_ns,
                      const std::vector<int>& channels) {
    const double t_s = samples[next].t_s;
    int last = -1;
    std::size_t end = next;
    for (; end < samples.size() && samples[end].t_s == t_s; ++end) {
      const int channel = channels[samples[end].column];
      if (channel < 0) continue;
      // A channel given twice at one instant belongs into a scan of its own.
      if (std::exchange(last, channel) == channel) break;
      delivery_.add(static_cast<std::size_t>(channel), {t_ns}, samples[end].value);
    }
    return end;
  }

  // Nothing is lost where the source can wait. false: shall end.
  bool wait_for_room(const Stop& stop) {
    stop.turn();
    while (host_.room() < delivery_.size() && stop.sleep_for(kRoom_ns)) continue;
    return !stop.requested();
  }

  Host host_;
  std::string path_;
  double speed_;
  bool loop_;
  std::vector<std::string> columns_;  // of each channel
  Delivery delivery_;
};

}  // namespace
}  // namespace dwell::driver

DWELL_DRIVER(dwell::driver::Replay, "replay", "1.0.0", "plays a CSV recording", dwell::driver::kKeys)
