// An example of a driver: every channel is a sine of its own amplitude and phase, sampled at a common rate. Copy it to
// begin a driver of your own; what reads your device takes the place of the sine.
#include <cmath>
#include <dwell_driver.hpp>

namespace {

using namespace dwell::driver;

constexpr double kTwoPi = 6.283185307179586;

// What the rig file may say; the host checks types, bounds and choices, and reports unknown keys.
constexpr dwell_key kKeys[] = {
    required(real_key(DWELL_DEVICE, "frequency", 1e-3, 1e3, "Hz", "frequency of all sines")),
    real_key(DWELL_DEVICE, "rate", 1e-3, 1e5, "Hz", "samples per second; default 100"),
    real_key(DWELL_CHANNEL, "amplitude", 0.0, kUnbounded, "", "amplitude; default 1"),
    real_key(DWELL_CHANNEL, "phase", -kUnbounded, kUnbounded, "rad", "phase; default 0"),
};

class Sine {
 public:
  // Copies what it needs, as the settings are gone afterwards; throws to refuse; does not touch the device.
  Sine(const Settings& settings, const Host& host)
      : host_(host),
        frequency_hz_(settings.get<double>("frequency", 1.0)),
        rate_hz_(settings.get<double>("rate", 100.0)) {
    for (const ChannelSettings& channel : settings.channels())
      waves_.push_back({channel.index, channel.get<double>("amplitude", 1.0), channel.get<double>("phase", 0.0)});
    scan_.resize(waves_.size());
  }

  // Delivers until stop; allocates nothing per sample. A real driver also reports what does not work: state() when a
  // channel ceases or begins to deliver, count() for every fault, and it connects again for ever by itself.
  void run(Stop& stop) {
    host_.state(-1, DWELL_FAULT_NONE);
    const std::int64_t start_ns = monotonic_ns();
    for (std::int64_t n = 0; stop.sleep_until(start_ns + to_ns(static_cast<double>(n) / rate_hz_)); ++n) {
      const std::int64_t before_ns = raw_ns();
      // … here the device would be asked …
      const std::int64_t after_ns = raw_ns();
      const std::int64_t t_ns = before_ns + (after_ns - before_ns) / 2;
      for (std::size_t i = 0; i < waves_.size(); ++i) {
        const double angle = kTwoPi * frequency_hz_ * static_cast<double>(t_ns) * 1e-9 + waves_[i].phase;
        scan_[i] = {t_ns, waves_[i].amplitude * std::sin(angle),
                    static_cast<std::uint32_t>(after_ns - before_ns) / 2 + 1, waves_[i].index, 0};
      }
      host_.push(scan_);
    }
  }

  // How old a sample may be when it is pushed: the host waits so long. Here it is pushed as soon as it is read; a
  // driver that waits for an answer states its timeout.
  static void describe(const Settings& settings, dwell_traits& traits) {
    traits.rate_hz = settings.get<double>("rate", 100.0);
    traits.age_ns = 1'000'000;
  }

  // What the key schema cannot say.
  static void check(const Settings& settings, Report& report) {
    if (settings.get<double>("rate", 100.0) < 2.0 * settings.get<double>("frequency", 1.0))
      report.device("rate", "the rate is below twice the frequency; expected more");
  }

  static void probe(const Settings& settings, Probed& probed) {
    for (std::size_t i = 0; i < settings.channels().size(); ++i) probed.value(i, 0.0, 0);
  }

 private:
  struct Wave {
    std::uint16_t index;
    double amplitude;
    double phase;
  };
  Host host_;
  double frequency_hz_;
  double rate_hz_;
  std::vector<Wave> waves_;
  std::vector<dwell_sample> scan_;
};

}  // namespace

DWELL_DRIVER(Sine, "sine", "1.0.0", "sines, an example of a driver", kKeys)
