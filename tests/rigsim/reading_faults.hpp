// What real devices and gateways do to readings: registers refreshed at a rate of their own, clipping, converters that
// end, zeros and repeats in place of readings; and at which moment of its turnaround a station samples. Virtual time.
//
// Control lines (rigsim.1), TARGET being "all", a channel's name or a station's number:
//   refresh TARGET S · sample all|STATION request|middle|answer · clip CHANNEL LOW HIGH ·
//   converter CHANNEL BITS REACH · zeros all|CHANNEL P · repeats all|CHANNEL P
#pragma once

#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace rigsim {

// Bound to one thread.
class ReadingFaults {
 public:
  // full: each channel's steady amplitude, SI, which clip and converter are relative to.
  ReadingFaults(std::vector<std::string> channels, std::vector<double> full);

  // One control line's words. Empty: done; else what is wrong; none: the verb is another's.
  [[nodiscard]] std::optional<std::string> command(const std::vector<std::string>& words);

  // When the register of this channel at this station took the value that it holds at t, s, which may be t itself.
  // None: it has no refresh, every reading is a new value. Station 0: none of them.
  [[nodiscard]] std::optional<double> taken_at(std::size_t channel, int station, double t_s) const;
  // What clipping and the converter leave of a value, SI.
  [[nodiscard]] double converted(std::size_t channel, double value) const;
  // Zeros and repeats, by station; the values become what is passed on.
  void pass_on(int station, std::span<double> values, std::mt19937_64& random);
  // The moment of sampling: this part of the turnaround, 0 … 1.
  [[nodiscard]] double sampled_at(int station) const;

 private:
  struct Line {  // one channel
    double refresh_s = 0.0, low, high;
    int bits = 0;  // 0: no converter
    double reach = 0.0;
    double zeros = 0.0, repeats = 0.0;
  };
  [[nodiscard]] std::optional<std::size_t> find(const std::string& channel) const;
  [[nodiscard]] std::string set_refresh(const std::string& target, double seconds);
  [[nodiscard]] std::string set_sample(const std::string& target, const std::string& moment);

  std::vector<std::string> channels_;
  std::vector<double> full_;
  std::vector<Line> lines_;
  double refresh_s_ = 0.0, zeros_ = 0.0, repeats_ = 0.0, sampled_at_ = 0.5;  // of all
  std::map<int, double> station_refresh_s_, station_sampled_at_;
  std::map<int, std::vector<double>> passed_on_;  // by station
};

}  // namespace rigsim
