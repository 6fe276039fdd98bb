// What real devices and gateways do to readings: registers refreshed at a rate of their own, clipping, converters that
// end, registers that freeze for a while, and zeros, repeats or garbage in place of readings. At which moment of its
// turnaround a station samples. And what a rig file may state wrongly: channels that are late, of another scale, or
// swapped. Virtual time.
//
// Control lines (rigsim.1), TARGET being "all", a channel's name or a station's number:
//   refresh TARGET S · sample all|STATION request|middle|answer · clip CHANNEL LOW HIGH ·
//   converter CHANNEL BITS REACH · low-byte CHANNEL CODE · zeros all|CHANNEL P · repeats all|CHANNEL P ·
//   stale all|CHANNEL N · freeze all|CHANNEL P S · garbage all|CHANNEL P · glitch CHANNEL X [P] ·
//   scale CHANNEL FACTOR [P] · lag CHANNEL S [SPREAD] · swap CHANNEL CHANNEL
#pragma once

#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace rigsim {

// Bound to one thread.
class ReadingFaults {
 public:
  // full: each channel's steady amplitude, SI, which clip and converter are relative to.
  ReadingFaults(std::vector<std::string> channels, std::vector<double> full);

  // One control line's words. Empty: done; else what is wrong; none: the verb is another's.
  [[nodiscard]] std::optional<std::string> command(const std::vector<std::string>& words);

  // When the register of this channel at this station took the value that it holds at t, s; this may be t itself. None:
  // the register has no refresh, so every reading is a new value. Station 0: no station.
  [[nodiscard]] std::optional<double> taken_at(std::size_t channel, int station, double t_s) const;
  // How far the channel's next reading lags behind the motion, s.
  [[nodiscard]] double lag_s(std::size_t channel, std::mt19937_64& random) const;
  // What scale, clipping and the converter leave of a value, SI.
  [[nodiscard]] double converted(std::size_t channel, double value, std::mt19937_64& random) const;
  // Error of the next reading, added after all rounding, SI; 0: none. Each call counts as one reading.
  [[nodiscard]] double glitch(std::size_t channel, std::mt19937_64& random);
  // Applies swapped channels, zeros, repeats, freezes and garbage, by station. values: in, what the registers hold;
  // out, what is passed on. SI.
  void pass_on(double t_s, int station, std::span<double> values, std::mt19937_64& random);
  // The moment of sampling: this part of the turnaround, 0 … 1.
  [[nodiscard]] double sampled_at(int station) const;

 private:
  struct Line {  // one channel
    double refresh_s = 0.0, low, high;
    int bits = 0;  // 0: no converter
    double reach = 0.0;
    double zeros = 0.0, repeats = 0.0, garbage = 0.0;
    double freeze = 0.0, freeze_s = 0.0;     // probability that a freeze begins; how long it lasts
    int stale = 0;                           // every so many readings one repeats; 0: none
    int low_byte = -1;                       // of the converter's code; -1: as it converts
    double glitch = 0.0, glitch_part = 0.0;  // SI; probability
    bool glitch_once = false;
    double scale = 1.0, scale_part = 1.0;  // of the readings, the part that it applies to
    double lag_s = 0.0, lag_spread_s = 0.0;
  };
  struct PassedOn {  // of one channel at one station
    double value = 0.0;
    bool any = false;
    long long readings = 0;
    double frozen_until_s = -1.0;
  };
  [[nodiscard]] std::optional<std::size_t> find(const std::string& channel) const;
  [[nodiscard]] std::string set_refresh(const std::string& target, double seconds);
  // The lines that "all" or the name of a channel stands for; empty: there is no such channel.
  [[nodiscard]] std::vector<Line*> meant(const std::string& target);
  [[nodiscard]] std::optional<std::string> set_gateway(const std::vector<std::string>& words);
  [[nodiscard]] std::optional<std::string> set_transducer(const std::vector<std::string>& words);
  [[nodiscard]] std::string set_sample(const std::string& target, const std::string& moment);

  std::vector<std::string> channels_;
  std::vector<double> full_;
  std::vector<Line> lines_;
  double refresh_s_ = 0.0, zeros_ = 0.0, repeats_ = 0.0, sampled_at_ = 0.5;  // of all
  std::map<int, double> station_refresh_s_, station_sampled_at_;
  std::map<int, std::vector<PassedOn>> passed_on_;  // by station
  std::vector<std::pair<std::size_t, std::size_t>> swapped_;
};

}  // namespace rigsim
