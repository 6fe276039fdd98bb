#include "tests/rigsim/device.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/forward.hpp"

namespace rigsim {
namespace {

dwell::Drive effective(const dwell::Drive& drive, bool running) {
  if (running) return drive;
  dwell::Drive standing = drive;
  standing.amplitude = 0.0;
  standing.harmonics.clear();
  return standing;
}

}  // namespace

std::optional<double> number(const std::string& word) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

Device::Device(const Options& options)
    : faults(options.faults),
      masses_(options.chain.masses.size()),
      clamped_(options.chain.boundary == dwell::Boundary::clamped),
      drive_(options.drive),
      running_(!options.stopped),
      chain_(options.chain, effective(options.drive, running_),
             options.from_steady ? dwell::DrivenChain::Start::steady : dwell::DrivenChain::Start::rest),
      random_(options.seed) {
  const auto steady =
      dwell::steady_response(options.chain, 2.0 * std::numbers::pi * drive_.frequency_hz, drive_.amplitude);
  for (std::size_t k = 0; k <= masses_; ++k) {
    channels_.push_back(std::string(1, 'y').append(std::to_string(k)));  // g++ 12 misreads "y" + … (-Wrestrict)
    full_.push_back(std::abs(steady.Y[k]));
  }
  if (clamped_) {
    channels_.emplace_back("reaction");
    full_.push_back(std::abs(steady.F));
  }
  stuck_.resize(channels_.size());
}

void Device::truth(double t_s, std::span<double> values) {
  const dwell::ChainMotion& motion = chain_.at(t_s);
  std::copy(motion.y.begin(), motion.y.end(), values.begin());
  if (clamped_) values[masses_ + 1] = motion.ground_force;
}

void Device::read(double t_s, std::span<double> values) {
  truth(t_s, values);
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (stuck_[i]) {
      values[i] = *stuck_[i];
      continue;
    }
    if (faults.noise > 0.0) values[i] += faults.noise * full_[i] * gauss_(random_);
    if (const double step = faults.quantize * full_[i]; step > 0.0) values[i] = step * std::nearbyint(values[i] / step);
    if (faults.invalid > 0.0 && std::bernoulli_distribution(faults.invalid)(random_))
      values[i] = std::numeric_limits<double>::quiet_NaN();
  }
}

void Device::apply_drive(double t_s) { chain_.set_drive(t_s, effective(drive_, running_)); }

std::string Device::set_stuck(double t_s, const std::vector<std::string>& words) {
  if (words.size() != 3 || (words[2] != "on" && words[2] != "off")) return "expected: stuck CHANNEL on|off";
  const auto found = std::find(channels_.begin(), channels_.end(), words[1]);
  if (found == channels_.end()) return "no channel " + words[1] + ": expected y0 ... " + channels_.back();
  const auto i = static_cast<std::size_t>(found - channels_.begin());
  if (words[2] == "off") {
    stuck_[i].reset();
    return {};
  }
  std::vector<double> values(channels_.size());
  truth(t_s, values);
  stuck_[i] = values[i];
  return {};
}

std::optional<std::string> Device::command(double t_s, const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  if (verb == "stuck") return set_stuck(t_s, words);
  if (verb == "start" || verb == "stop") {
    if (words.size() != 1) return verb + " takes nothing more";
    running_ = verb == "start";
    apply_drive(t_s);
    return std::string();
  }
  struct DriveKey {
    const char* name;
    double dwell::Drive::*member;
    double lowest, highest;
  };
  static constexpr DriveKey kDriveKeys[] = {{"frequency", &dwell::Drive::frequency_hz, 0.0, 1e4},
                                            {"amplitude", &dwell::Drive::amplitude, 0.0, 1e3},
                                            {"offset", &dwell::Drive::offset, -1e3, 1e3},
                                            {"ramp", &dwell::Drive::ramp_s, 0.0, 1e3}};
  for (const DriveKey& key : kDriveKeys) {
    if (verb != key.name) continue;
    const auto value = words.size() == 2 ? number(words[1]) : std::nullopt;
    if (!value || *value < key.lowest || *value > key.highest) return "expected: " + verb + " NUMBER within its range";
    drive_.*key.member = *value;
    // A new ramp time is for changes to come, not a change itself.
    if (verb != "ramp") apply_drive(t_s);
    return std::string();
  }
  return std::nullopt;
}

}  // namespace rigsim
