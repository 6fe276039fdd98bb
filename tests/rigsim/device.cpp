#include "tests/rigsim/device.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/model/forward.hpp"
#include "tests/rigsim/control.hpp"

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
      mass_kg_(options.chain.masses),
      masses_(mass_kg_.size()),
      clamped_(options.chain.boundary == dwell::Boundary::clamped),
      drive_(options.drive),
      running_(!options.stopped),
      chain_(options.chain, effective(options.drive, running_),
             options.from_steady ? dwell::DrivenChain::Start::steady : dwell::DrivenChain::Start::rest),
      knocker_(options.knocks, options.seed),
      ringing_(options.chain),
      reading_faults_({}, {}),
      random_(options.seed) {
  if (options.bend.any()) bent_.emplace(options.chain, options.bend, effective(drive_, running_), options.from_steady);
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
  reading_faults_ = ReadingFaults(channels_, full_);
  for (const std::string& line : options.lines) (void)command(0.0, split_words(line));
}

std::string Device::fault(const Options& options) {
  Options without = options;
  without.lines.clear();
  Device device(without);
  for (const std::string& line : options.lines) {
    const auto words = split_words(line);
    const auto answer = words.empty() ? std::nullopt : device.command(0.0, words);
    if (!answer || !answer->empty()) return line + ": " + answer.value_or("cannot make out");
  }
  return {};
}

const dwell::ChainMotion& Device::motion_at(double t_s) {
  catch_up(t_s);
  if (bent_) return bent_->at(t_s);
  motion_ = chain_.at(t_s);
  ringing_.add_to(t_s, motion_);
  return motion_;
}

void Device::catch_up(double t_s) {
  while (const auto due = knocker_.due(t_s)) knock(*due);
}

void Device::knock(const Knock& knock) {
  const double velocity = knock.impulse / mass_kg_[static_cast<std::size_t>(knock.mass - 1)];
  if (bent_)
    bent_->knock(knock.t_s, knock.mass, velocity);
  else
    ringing_.knock(knock.t_s, knock.mass, velocity);
}

std::string Device::knock_now(double t_s, const std::vector<std::string>& words) {
  const auto mass = words.size() == 3 ? number(words[1]) : std::nullopt;
  const auto impulse = words.size() == 3 ? number(words[2]) : std::nullopt;
  if (!mass || !impulse) return "expected: knock MASS N*S";
  if (*mass != std::floor(*mass) || *mass < 1 || *mass > static_cast<double>(masses_))
    return "no mass " + words[1] + ": expected 1 ... " + std::to_string(masses_);
  catch_up(t_s);
  knock({t_s, static_cast<int>(*mass), *impulse});
  return {};
}

void Device::truth(double t_s, std::span<double> values) {
  const dwell::ChainMotion& motion = motion_at(t_s);
  std::copy(motion.y.begin(), motion.y.end(), values.begin());
  if (clamped_) values[masses_ + 1] = motion.ground_force;
}

double Device::measured(std::size_t channel, double truth) {
  if (faults.noise > 0.0) truth += faults.noise * full_[channel] * gauss_(random_);
  truth = reading_faults_.converted(channel, truth, random_);
  if (const double step = faults.quantize * full_[channel]; step > 0.0) truth = step * std::nearbyint(truth / step);
  truth += reading_faults_.glitch(channel, random_);
  if (faults.invalid > 0.0 && std::bernoulli_distribution(faults.invalid)(random_))
    truth = std::numeric_limits<double>::quiet_NaN();
  return truth;
}

void Device::read(double t_s, std::span<double> values, int station) {
  truth(t_s, values);
  std::vector<double> before;
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    if (stuck_[i]) {
      values[i] = *stuck_[i];
      continue;
    }
    const std::optional<double> taken_s = reading_faults_.taken_at(i, station, t_s);
    const double lag_s = reading_faults_.lag_s(i, random_);
    const auto truth_at = [&](double s) {
      before.resize(channels_.size());
      truth(std::max(0.0, s - lag_s), before);
      return before[i];
    };
    if (!taken_s) {
      values[i] = measured(i, lag_s > 0 ? truth_at(t_s) : values[i]);
      continue;
    }
    Held& held = held_.try_emplace({station, i}, Held{-1.0, 0.0}).first->second;
    if (held.t_s != *taken_s) {
      const double value = measured(i, truth_at(*taken_s));
      held = {*taken_s, value};
    }
    values[i] = held.value;
  }
  reading_faults_.pass_on(t_s, station, values, random_);
}

void Device::apply_drive(double t_s) {
  catch_up(t_s);
  if (bent_)
    bent_->set_drive(t_s, effective(drive_, running_));
  else
    chain_.set_drive(t_s, effective(drive_, running_));
}

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
  if (verb == "knock") return knock_now(t_s, words);
  if (auto answer = reading_faults_.command(words)) return answer;
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
