#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "tests/study/draw_parts.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {
namespace {

constexpr double kSecond = 0.15;  // of the dwells have a second disturbance, of the readings
constexpr double kRigid = 0.15;   // of the rigs have no mass: an element between table and load cell

bool needs_masses(Kind kind) {
  return kind == Kind::side_ground || kind == Kind::side_between || kind == Kind::mass_off || kind == Kind::swapped;
}
bool needs_clamped(Kind kind) { return kind == Kind::reversed; }
// Repeats and zeros of whole scans, and sampling at a multiple of the drive: all channels at one rate.
bool needs_one_rate(Kind kind) {
  return kind == Kind::refresh_all || kind == Kind::zeros_all || kind == Kind::repeats_all || kind == Kind::folded ||
         kind == Kind::stations;
}

void draw_rigid(Draws& draws, Case& about) {
  about.chain = {Boundary::clamped, {}, {draws.log_uniform(1e4, 1e6)}, {}};
  const double omega = kTwoPi * about.frequency_hz;
  about.chain.damping.push_back(about.chain.stiffness[0] / omega * draws.log_uniform(0.01, 1));
  about.rig.boundary = Boundary::clamped;
}

const std::string& channel_name(const Case& about, int c) {
  return about.rig.channels[static_cast<std::size_t>(c)].name;
}

// Draws the disturbances of a case, in the order in which its parts come to be.
class Disturber {
 public:
  Disturber(Draws& draws, Case& about) : draws_(draws), about_(about) {}

  // What is off from the beginning: the drive's settings, the chain and what the rig file says of it.
  void rig(Kind kind) {
    switch (kind) {
      case Kind::fixed_off:
        return frequency();
      case Kind::hunting:
      case Kind::hunting_short:
      case Kind::drift:
        return amplitude(kind);
      case Kind::folded:
        return harmonics();
      case Kind::side_ground:
      case Kind::side_between:
        return side(kind);
      case Kind::mass_off:
        return mass();
      case Kind::wrong_scale:
      case Kind::late:
      case Kind::swapped:
      case Kind::reversed:
        return transducer(kind);
      default:
        break;
    }
  }
  // What needs the motion: sampling, noise and what devices make of readings.
  void readings(Kind kind) {
    about_.mishaps.resize(about_.lines.size());
    switch (kind) {
      case Kind::refresh_one:
      case Kind::refresh_all:
        return refresh(kind);
      case Kind::clip_both:
      case Kind::clip_one:
        return clip(kind);
      case Kind::end_codes:
        return codes();
      case Kind::zeros_one:
      case Kind::zeros_all:
      case Kind::repeats_one:
      case Kind::repeats_all:
      case Kind::bursts:
      case Kind::alternate:
        return gateway(kind);
      case Kind::glitch_rounded:
        return glitch();
      case Kind::low_byte:
        return low_byte();
      case Kind::folded:
        return fold();
      case Kind::stations:
        return stations();
      case Kind::friction:
      case Kind::cubic:
        return nonlinear(kind);
      default:
        break;
    }
  }

 private:
  int any_channel() { return draws_.integer(0, about_.channels() - 1); }
  Line& line(int c) { return about_.lines[static_cast<std::size_t>(c)]; }
  Mishap& mishap(int c) { return about_.mishaps[static_cast<std::size_t>(c)]; }
  Sensor& sensor(int c) { return about_.sensors[static_cast<std::size_t>(c)]; }
  // Of the fundamental.
  double amplitude_of(int c) { return std::abs(about_.motion->phasor(c, 1)); }
  std::vector<int> all_channels() {
    std::vector<int> all;
    for (int c = 0; c < about_.channels(); ++c) all.push_back(c);
    return all;
  }
  std::vector<int> all_elements() {
    std::vector<int> all;
    for (int k = 1; k <= about_.chain.element_count(); ++k) all.push_back(k);
    return all;
  }
  void tell(Kind kind, const std::string& told, std::vector<int> channels, std::vector<int> elements = {}) {
    about_.disturbances.push_back({kind, told, std::move(channels), std::move(elements)});
  }

  void frequency() {
    Excitation& excitation = about_.rig.excitation;
    const double off = draws_.sign() * draws_.log_uniform(1e-6, 1e-3);
    // Stated in frequency_u, in clock_u, or hardly at all.
    const double stated = std::abs(off) * draws_.log_uniform(0.1, 10);
    const double kind = draws_.uniform(0, 1);
    excitation.reference = Reference::fixed;
    excitation.frequency_hz = about_.frequency_hz / (1 + off);
    excitation.clock_u = 5e-5;  // what a rig file has that says nothing
    if (kind < 0.4) excitation.frequency_u_hz = stated * excitation.frequency_hz;
    if (kind > 0.7) excitation.clock_u = stated;
    tell(Kind::fixed_off,
         text("the drive is %.3g ppm off the fixed frequency (stated: %.3g ppm, in %s)", 1e6 * off,
              1e6 * (kind < 0.4 || kind > 0.7 ? stated : 0.0), kind < 0.4 ? "frequency_u" : "clock_u"),
         {0});
  }

  // The drive times 1 + a sin(Ωt + φ): two side bands. A drift is a small part of a slow swing.
  void amplitude(Kind kind) {
    const double f = about_.frequency_hz;
    double a = draws_.log_uniform(5e-4, 0.2), hz = f * draws_.log_uniform(0.005, 0.5);
    double phase = draws_.uniform(0, kTwoPi);
    if (kind == Kind::drift) {
      const double per_period = draws_.log_uniform(1e-6, 3e-3);  // of the amplitude
      hz = f / 4000;
      a = std::min(per_period * f / (kTwoPi * hz), 0.7);
      phase = draws_.chance(0.5) ? 0.0 : std::numbers::pi;
      tell(kind, text("the amplitude drifts by %.3g %% a period", 100 * per_period), {0}, all_elements());
    } else {
      if (kind == Kind::hunting_short) about_.hold_periods = draws_.uniform(2, 10);
      tell(kind, text("the amplitude swings by %.3g %% at %.3g Hz", 100 * a, hz), {0}, all_elements());
    }
    const Complex half = about_.table.shape[0] * a / 2.0;
    about_.table.tones = {{f + hz, half * std::polar(1.0, phase - std::numbers::pi / 2)},
                          {f - hz, half * std::polar(1.0, std::numbers::pi / 2 - phase)}};
  }

  void harmonics() {
    const int highest = draws_.integer(about_.rig.excitation.harmonics + 1, 16);
    about_.table.shape.resize(static_cast<std::size_t>(highest));
    const double part = draws_.log_uniform(3e-4, 0.05);
    for (int h = about_.rig.excitation.harmonics + 1; h <= highest; ++h)
      if (h == highest || draws_.chance(0.3))
        about_.table.shape[static_cast<std::size_t>(h - 1)] =
            about_.table.shape[0] * part * std::polar(draws_.log_uniform(0.2, 1), draws_.uniform(0, kTwoPi));
    tell(Kind::folded, text("harmonic %d of up to %.3g %%", highest, 100 * part), all_channels(), all_elements());
  }

  // Against the stiffness of the element beside its mass.
  void side(Kind kind) {
    const int n = about_.chain.mass_count();
    SideSpring spring;
    if (kind == Kind::side_ground || n == 1) {
      spring.mass = draws_.integer(1, n);
    } else {
      spring.mass = draws_.integer(2, n);
      spring.to = draws_.integer(0, spring.mass - 2);
    }
    spring.stiffness =
        about_.chain.stiffness[static_cast<std::size_t>(spring.mass - 1)] * draws_.log_uniform(1e-3, 0.5);
    spring.damping = spring.stiffness * draws_.log_uniform(1e-3, 0.1) / (kTwoPi * about_.frequency_hz);
    about_.side.push_back(spring);
    tell(spring.to == kGround ? Kind::side_ground : Kind::side_between,
         text("a spring of %.3g N/m beside element %d's %.3g N/m, from mass %d to %s", spring.stiffness, spring.mass,
              about_.chain.stiffness[static_cast<std::size_t>(spring.mass - 1)], spring.mass,
              spring.to == kGround ? "the ground"
              : spring.to == 0     ? "the table"
                                   : ("mass " + std::to_string(spring.to)).c_str()),
         {}, all_elements());
  }

  void mass() {
    const int k = draws_.integer(1, about_.chain.mass_count());
    const double off = draws_.sign() * draws_.log_uniform(0.01, 0.15);
    about_.rig.masses[static_cast<std::size_t>(k - 1)] *= 1 + off;
    tell(Kind::mass_off, text("mass %d is stated %.3g %% off", k, 100 * off), {}, all_elements());
  }

  void transducer(Kind kind) {
    const int count = about_.channels();
    if (kind == Kind::reversed) {
      sensor(count - 1).gain = -1;
      tell(kind, "the load cell is reversed", {count - 1}, all_elements());
      return;
    }
    const int c = any_channel();
    if (kind == Kind::late) {
      const double late_s = draws_.log_uniform(1e-4, 5e-3);
      sensor(c).delay_s = late_s;
      tell(kind, text("%s is %.3g ms late", channel_name(about_, c).c_str(), 1e3 * late_s), {c}, all_elements());
    } else if (kind == Kind::wrong_scale) {
      constexpr double kUnits[] = {1e3, 1e-3, 25.4, 1 / 25.4, 10, 0.1, 2, 0.5, 9.80665, 1 / 9.80665, 57.29578, 1.41421};
      const double gain = draws_.chance(0.5) ? kUnits[draws_.integer(0, std::size(kUnits) - 1)]
                                             : 1 + draws_.sign() * draws_.log_uniform(1e-3, 0.3);
      sensor(c).gain = gain;
      tell(kind, text("%s reads %.4g times what it should", channel_name(about_, c).c_str(), gain), {c},
           all_elements());
    } else {
      // Displacements or the like: two places of one quantity.
      const int a = draws_.integer(0, about_.chain.mass_count());
      int b = draws_.integer(0, about_.chain.mass_count() - 1);
      b += b >= a;
      std::swap(sensor(a), sensor(b));
      std::swap(about_.rig.channels[static_cast<std::size_t>(a)].unit,
                about_.rig.channels[static_cast<std::size_t>(b)].unit);
      std::swap(about_.rig.channels[static_cast<std::size_t>(a)].measures,
                about_.rig.channels[static_cast<std::size_t>(b)].measures);
      tell(kind, text("%s and %s are swapped", channel_name(about_, a).c_str(), channel_name(about_, b).c_str()),
           {a, b}, all_elements());
    }
  }

  void refresh(Kind kind) {
    const bool all = kind == Kind::refresh_all;
    const int only = any_channel();
    double ratio = draws_.log_uniform(1.02, 20);
    if (draws_.chance(0.4)) ratio = std::max(2.0, std::round(ratio));
    // At least three values a period are left, or nothing is to be had at all.
    ratio = std::max(1.02, std::min(ratio, about_.samples_per_period(only) / 3));
    const double refresh_s = ratio / line(only).rate_hz, phase = draws_.uniform(0, 1);
    for (int c = 0; c < about_.channels(); ++c)
      if (all || c == only) {
        mishap(c).refresh_s = refresh_s;
        mishap(c).refresh_phase_s = -phase * refresh_s;
      }
    tell(kind,
         text("%s refreshed every %.4g polls, %.3g times a period",
              all ? "all channels" : channel_name(about_, only).c_str(), ratio, about_.period_s() / refresh_s),
         all ? all_channels() : std::vector{only});
  }

  // Levels in amplitudes about the mean; above 1 + 4 noises nothing is clipped.
  void clip(Kind kind) {
    const int c = any_channel();
    const double amplitude = amplitude_of(c), mean = line(c).mean;
    const double level = draws_.chance(0.3) ? draws_.uniform(1, 1.2) : draws_.uniform(0.2, 1);
    if (kind == Kind::clip_both) {
      const double aside = draws_.uniform(-0.2, 0.2) * amplitude;
      mishap(c).low = mean + aside - level * amplitude;
      mishap(c).high = mean + aside + level * amplitude;
    } else if (draws_.chance(0.5)) {
      mishap(c).high = mean + level * amplitude;
    } else {
      mishap(c).low = mean - level * amplitude;
    }
    tell(kind,
         text("%s is clipped at %.3g of its amplitude, %s", channel_name(about_, c).c_str(), level,
              kind == Kind::clip_both ? "both sides" : "one side"),
         {c});
  }

  // 16 bits: the motion is larger than the range, or now and then the lowest code says "no value".
  void codes() {
    const int c = any_channel();
    const bool lower = draws_.chance(0.5);
    if (draws_.chance(0.5)) {
      const double level = draws_.uniform(0.3, 1.1);
      const double step = level * (amplitude_of(c) + std::abs(line(c).mean)) / 32768;
      line(c).step = step;
      mishap(c).low = -32768 * step;
      mishap(c).high = 32767 * step;
      if (draws_.chance(0.3)) mishap(c).low_code = mishap(c).high_code = -32768 * step;  // any overflow is one code
      tell(Kind::end_codes,
           text("%s ends at its codes at %.3g of its reach%s", channel_name(about_, c).c_str(), level,
                std::isnan(mishap(c).low_code) ? "" : ", all -32768"),
           {c});
      return;
    }
    const double step = (amplitude_of(c) + std::abs(line(c).mean)) * draws_.log_uniform(1.1, 10) / 32768;
    line(c).step = step;
    mishap(c).codes = draws_.log_uniform(1e-4, 0.2);
    mishap(c).code = (lower ? -32768 : 32767) * step;
    tell(Kind::end_codes,
         text("%s gives %d for %.3g %% of its readings", channel_name(about_, c).c_str(), lower ? -32768 : 32767,
              100 * mishap(c).codes),
         {c});
  }

  void gateway(Kind kind) {
    const bool all = kind == Kind::zeros_all || kind == Kind::repeats_all;
    const int only = any_channel();
    const double part = draws_.log_uniform(1e-4, 0.3);
    const int length = draws_.integer(2, 40);
    for (int c = 0; c < about_.channels(); ++c) {
      if (!all && c != only) continue;
      Mishap& of = mishap(c);
      of.whole_scans = of.whole_scans || all;
      if (kind == Kind::zeros_one || kind == Kind::zeros_all) of.zeros = part;
      if (kind == Kind::repeats_one || kind == Kind::repeats_all) of.repeats = part;
      if (kind == Kind::alternate) of.alternate = true;
      if (kind == Kind::bursts) of.bursts = std::min(1.0, part * kBurstCell / length), of.burst_length = length;
    }
    const std::string who = all ? "whole scans" : channel_name(about_, only);
    const double per_cent = 100 * part;
    tell(kind,
         kind == Kind::alternate ? who + " repeats every second reading"
         : kind == Kind::bursts  ? text("%s holds %d readings, %.3g %% of the time", who.c_str(), length, per_cent)
         : kind == Kind::zeros_one || kind == Kind::zeros_all ? text("%s: %.3g %% zeros", who.c_str(), per_cent)
                                                              : text("%s: %.3g %% repeats", who.c_str(), per_cent),
         all ? all_channels() : std::vector{only});
  }

  void glitch() {
    const int c = any_channel();
    Line& of = line(c);
    of.step = amplitude_of(c) * draws_.log_uniform(2e-4, 2e-2);
    of.sigma = of.step * draws_.log_uniform(0.02, 0.5);
    const double periods = about_.hold_periods + about_.motion->time_constant_s() * about_.frequency_hz;
    mishap(c).glitch =
        static_cast<std::int64_t>(of.rate_hz * (about_.change_s + draws_.uniform(0, periods) * about_.period_s()));
    const double size = draws_.sign() * draws_.log_uniform(1e-3, 10);
    mishap(c).glitch_by = size * amplitude_of(c) + 0.37 * of.step;
    tell(Kind::glitch_rounded,
         text("%s is rounded to %.3g of its amplitude, and one reading is %.3g amplitudes off",
              channel_name(about_, c).c_str(), of.step / amplitude_of(c), size),
         {c});
  }

  void low_byte() {
    const int c = any_channel();
    const double bits = draws_.uniform(10, 20);  // of the integer that the amplitude fills
    mishap(c).low_byte_step = amplitude_of(c) / std::exp2(bits);
    mishap(c).low_byte = draws_.integer(0, 255);
    tell(Kind::low_byte,
         text("%s's low byte is stuck: its steps are %.3g of its amplitude", channel_name(about_, c).c_str(),
              256 / std::exp2(bits)),
         {c});
  }

  // Sampled at nearly k times the drive's frequency, so that harmonics near k fall onto those that are fitted.
  void fold() {
    const int highest = static_cast<int>(about_.table.shape.size()), H = about_.rig.excitation.harmonics;
    int k = std::max(2 * (H + 1), highest + draws_.integer(-H, H));
    if (k == highest) ++k;
    const double off = draws_.sign() * draws_.log_uniform(1e-6, 2e-2);
    const double jitter = draws_.chance(0.7) ? 0.0 : draws_.uniform(0, 0.1);
    for (Line& of : about_.lines) {
      of.rate_hz = k * about_.frequency_hz * (1 + off);
      of.jitter = jitter;
    }
    about_.disturbances.back().told += text(", sampled at %d times the drive's frequency (off by %.3g)", k, off);
  }

  // Two stations, each with its turnaround: the middle is stated, the instant is anywhere within.
  void stations() {
    const double half_s = draws_.log_uniform(2e-5, 5e-3);
    std::vector<int> second;
    const double shift[2] = {half_s * draws_.uniform(-1, 1), half_s * draws_.uniform(-1, 1)};
    for (int c = 0; c < about_.channels(); ++c) {
      const bool on_second = c == about_.channels() - 1 || draws_.chance(0.3);
      if (on_second) second.push_back(c);
      line(c).scan = on_second;  // one request each
      line(c).phase = line(0).phase + (on_second ? 0.1 : 0.0);
      line(c).shift_s = shift[on_second];
      about_.half_ns[static_cast<std::size_t>(c)] = static_cast<std::uint32_t>(std::llround(1e9 * half_s));
    }
    tell(Kind::stations,
         text("%zu channels on a second station, turnaround ± %.3g ms, %.3g ms apart", second.size(), 1e3 * half_s,
              1e3 * (shift[1] - shift[0])),
         second);
  }

  // Against what the element does at the drive's frequency.
  void nonlinear(Kind kind) {
    const double omega = kTwoPi * about_.frequency_hz;
    const int k = draws_.integer(1, about_.chain.element_count());
    const auto e = static_cast<std::size_t>(k - 1);
    // Deformation in the linear motion.
    const auto& chain = about_.chain;
    const Motion probe(chain, {});
    Course::Nonlinear nonlinear;
    nonlinear.element = k;
    const std::vector<Complex> Y = probe.respond(omega, about_.table.shape[0]);
    const auto n = static_cast<std::size_t>(chain.mass_count());
    const double d = std::abs(e == n ? Y[n] : Y[e + 1] - Y[e]);
    const double part = draws_.log_uniform(1e-3, 0.2);
    if (kind == Kind::friction)
      nonlinear.friction = part * chain.stiffness[e] * d;
    else
      nonlinear.cubic = draws_.sign() * part * chain.stiffness[e] / (d * d);
    const double end_s =
        about_.change_s + about_.period_s() * (about_.hold_periods + 60) + 8 * about_.motion->time_constant_s();
    about_.course = std::make_shared<Course>(chain, about_.sensors, nonlinear, about_.table, end_s);
    tell(kind,
         text("element %d has %s of %.3g times c |d|", k, kind == Kind::friction ? "friction" : "a cubic force", part),
         {}, {k});
  }

  Draws& draws_;
  Case& about_;
};

}  // namespace

void draw_disturbed(Draws& draws, Case& about) {
  const Kind kind = static_cast<Kind>(about.index % kKinds);
  std::vector<Kind> kinds{kind};
  if (draws.chance(kSecond)) kinds.push_back(static_cast<Kind>(draws.integer(0, static_cast<int>(Kind::low_byte))));
  about.frequency_hz = draws.log_uniform(2, 40);
  const bool rigid = draws.chance(kRigid);
  do {
    about.remark.clear();
    if (rigid && !needs_masses(kind))
      draw_rigid(draws, about);
    else
      draw_chain(draws, about, is_nonlinear(kind) ? 2 : 4);
  } while ((needs_clamped(kind) && about.chain.boundary != Boundary::clamped) ||
           (kind == Kind::side_between && about.chain.mass_count() < 2) ||
           (is_nonlinear(kind) && Motion(about.chain, {}).time_constant_s() * about.frequency_hz > 30));
  about.rig.tolerance = draws.chance(0.3) ? draws.log_uniform(0.002, 0.02) : 0.005;
  draw_drive_settings(draws, about, draws.chance(0.7) ? draws.uniform(-0.01, 0.01) : 0.0);
  if (is_nonlinear(kind)) about.rig.excitation.harmonics = 3;  // what a rig file has that says nothing
  draw_channels(draws, about);
  about.hold_periods = draws.log_uniform(15, 100);
  about.table = draw_table(draws, about.frequency_hz, about.rig.excitation.harmonics);
  about.rig.excitation.minimum = 1e-3 * std::abs(about.table.shape[0]);
  Disturber disturber(draws, about);
  disturber.rig(kind);
  if (is_nonlinear(kind)) {
    about.motion = std::make_shared<Motion>(about.chain, about.sensors);
    about.motion->drive(0.0, about.table);
    about.remark += "from rest";
  } else {
    draw_motion(draws, about, about.table);
  }
  draw_sampling(draws, about, 10, 100);
  if (needs_one_rate(kind))
    for (Line& line : about.lines) line.rate_hz = about.lines[0].rate_hz;
  if (draws.chance(0.5))  // one request for all
    for (Line& line : about.lines)
      line.scan = 0, line.rate_hz = about.lines[0].rate_hz, line.phase = about.lines[0].phase;
  draw_noise(draws, about, std::abs(about.table.shape[0]));
  if (draws.chance(0.3))  // rounded, with noise of half a step or more
    for (Line& line : about.lines) line.step = line.sigma / draws.log_uniform(0.5, 3);
  for (const Kind each : kinds) disturber.readings(each);
}

}  // namespace dwell::study
