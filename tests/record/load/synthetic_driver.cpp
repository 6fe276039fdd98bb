// A device that costs next to nothing: a block of channels that share each instant, sines on 16 bits with noise,
// exactly at its rate. To see what the service takes at rates that no simulated bus reaches; service_load.py uses it.
#include <cmath>
#include <dwell_driver.hpp>
#include <random>

namespace {

using namespace dwell::driver;

constexpr double kTwoPi = 6.283185307179586;
constexpr double kNoise = 20.0;               // standard deviation, steps of the converter
constexpr std::int64_t kWake_ns = 1'000'000;  // scans are handed in so often

constexpr dwell_key kKeys[] = {
    required(real_key(DWELL_DEVICE, "frequency", 1e-3, 1e3, "Hz", "frequency of all sines")),
    required(real_key(DWELL_DEVICE, "rate", 1.0, 1e5, "Hz", "scans per second")),
    real_key(DWELL_DEVICE, "lag", 0.0, 1.0, "s", "of this device's scans behind those of others; default 0"),
    real_key(DWELL_CHANNEL, "amplitude", 0.0, 30000.0, "", "in steps; default 0"),
    real_key(DWELL_CHANNEL, "phase", -kUnbounded, kUnbounded, "rad", "phase; default 0"),
};

class Synthetic {
 public:
  Synthetic(const Settings& settings, const Host& host)
      : host_(host),
        omega_(kTwoPi * settings.get<double>("frequency", 1.0)),
        period_s_(1.0 / settings.get<double>("rate", 1.0)),
        lag_ns_(to_ns(settings.get<double>("lag", 0.0))) {
    for (const ChannelSettings& channel : settings.channels())
      waves_.push_back({channel.index, channel.get<double>("amplitude", 0.0), channel.get<double>("phase", 0.0)});
    scan_.resize(waves_.size());
    std::mt19937 random(7);
    std::normal_distribution<double> noise(0.0, kNoise);
    for (double& value : noise_) value = noise(random);
  }

  // Phases count from one instant for all devices: a whole second of the raw clock.
  void run(Stop& stop) {
    host_.state(-1, DWELL_FAULT_NONE);
    const std::int64_t begin_ns = raw_ns() / 1'000'000'000 * 1'000'000'000 + 1'000'000'000 + lag_ns_;
    std::int64_t n = 0;
    for (std::int64_t wake_ns = monotonic_ns(); stop.sleep_until(wake_ns); wake_ns += kWake_ns) {
      const std::int64_t now_ns = raw_ns();
      for (;; ++n) {
        const std::int64_t t_ns = begin_ns + std::llround(1e9 * period_s_ * static_cast<double>(n));
        if (t_ns > now_ns) break;
        push(t_ns);
      }
    }
  }

  static void describe(const Settings& settings, dwell_traits& traits) {
    traits.rate_hz = settings.get<double>("rate", 1.0);
    traits.age_ns = 20'000'000;
  }

 private:
  struct Wave {
    std::uint16_t index;
    double amplitude, phase;
  };

  void push(std::int64_t t_ns) {
    // A whole number of periods is left out, so that the angle keeps its digits.
    const double angle = std::fmod(omega_ * static_cast<double>(t_ns % 1'000'000'000'000) * 1e-9, kTwoPi);
    const double sine = std::sin(angle), cosine = std::cos(angle);
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      const Wave& wave = waves_[i];
      const double value =
          wave.amplitude * (sine * std::cos(wave.phase) + cosine * std::sin(wave.phase)) + next_noise();
      scan_[i] = {t_ns, std::round(value), 500, wave.index, 0};
    }
    host_.push(scan_);
  }

  // Drawn at random from a table: walked through in order, it would repeat itself.
  double next_noise() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return noise_[state_ >> 48];
  }

  Host host_;
  double omega_, period_s_;
  std::int64_t lag_ns_;
  std::vector<Wave> waves_;
  std::vector<dwell_sample> scan_;
  double noise_[65536];
  std::uint64_t state_ = 88172645463325252u;
};

}  // namespace

DWELL_DRIVER(Synthetic, "synthetic", "1.0.0", "sines at any rate, for measuring the service", kKeys)
