// The simulated transducers: what each channel of the driven chain reads at an instant, with the faults of a reading
// (noise, quantization, a stuck value, no number). Virtual time only: the caller says when it is.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/rigsim/bent_chain.hpp"
#include "tests/rigsim/knocks.hpp"
#include "tests/rigsim/options.hpp"
#include "tests/rigsim/reading_faults.hpp"

namespace rigsim {

// Bound to one thread.
class Device {
 public:
  explicit Device(const Options& options);

  // "y0" the table, "y1" … the masses, and for a clamped chain "reaction", the force on the ground.
  [[nodiscard]] const std::vector<std::string>& channels() const noexcept { return channels_; }
  [[nodiscard]] bool is_force(std::size_t channel) const noexcept { return channel > masses_; }

  // What is wrong with Options::lines, or empty; checked before the device serves.
  [[nodiscard]] static std::string fault(const Options& options);

  // The readings of all channels at t (s, at or after the last change of the drive), SI, as station `station` gives
  // them (0: none of the Modbus stations); NaN: no number.
  void read(double t_s, std::span<double> values, int station = 0);

  // One control line's words, effective at t. Empty: done; else what is wrong; none: the verb is not the device's.
  [[nodiscard]] std::optional<std::string> command(double t_s, const std::vector<std::string>& words);

  // The drive as it is now; amplitude and harmonics are those of the running drive even when stopped.
  [[nodiscard]] const dwell::Drive& drive() const noexcept { return drive_; }
  [[nodiscard]] bool running() const noexcept { return running_; }
  Faults faults;
  [[nodiscard]] const ReadingFaults& reading_faults() const noexcept { return reading_faults_; }

 private:
  const dwell::ChainMotion& motion_at(double t_s);
  [[nodiscard]] double measured(std::size_t channel, double truth);
  void truth(double t_s, std::span<double> values);
  void apply_drive(double t_s);
  void catch_up(double t_s);  // with the knocks that are due
  void knock(const Knock& knock);
  [[nodiscard]] std::string knock_now(double t_s, const std::vector<std::string>& words);
  [[nodiscard]] std::string set_stuck(double t_s, const std::vector<std::string>& words);

  std::vector<double> mass_kg_;
  std::size_t masses_;
  bool clamped_;
  dwell::Drive drive_;
  bool running_;
  dwell::DrivenChain chain_;
  std::optional<BentChain> bent_;  // in its place
  Knocker knocker_;
  Ringing ringing_;            // beside chain_; bent_ is knocked itself
  dwell::ChainMotion motion_;  // of both
  std::vector<std::string> channels_;
  std::vector<double> full_;                  // each channel's steady amplitude under the first drive
  std::vector<std::optional<double>> stuck_;  // the value a channel is stuck at
  ReadingFaults reading_faults_;
  struct Held {
    double t_s, value;
  };
  std::map<std::pair<int, std::size_t>, Held> held_;  // by station and channel: the register as refreshed last
  std::mt19937_64 random_;
  std::normal_distribution<double> gauss_;
};

// A finite number from a word of a command; none: it is not.
[[nodiscard]] std::optional<double> number(const std::string& word);

}  // namespace rigsim
