#include "core/motion/motion_course.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/base/wording.hpp"
#include "core/motion/late_answers.hpp"
#include "core/motion/level_crossings.hpp"
#include "core/motion/noise_of_readings.hpp"
#include "core/motion/search_starts.hpp"
#include "core/motion/weak_form.hpp"
#include "core/result/dwell.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Readings for each unknown, below which nothing is tried: as many are then left over as the unknowns take, and the
// noise is known to 1/√(2 · unknowns), 15 % of a table and two masses. Halved, nothing is left over.
constexpr std::size_t kPerUnknown = 2;
constexpr std::size_t kFirstReadings = 400;  // readings of the first fit, at least …
constexpr double kFirstPeriods = 3.0;        // … and periods of the nominal drive
constexpr std::size_t kStretchGrowth = 4;    // from fit to fit: the passes over shorter stretches cost a third in all
constexpr double kEvent = 7.0;           // √S: an innovation of the table beyond is an event, one in 10¹² otherwise
constexpr std::size_t kMostEvents = 40;  // more of them are no events
constexpr double kFar = 9.0;             // √S: a reading beyond, once all else fits, is none of the model's …
constexpr double kMostFar = 0.003;       // … where no more than this part of them is
constexpr double kLeastMass = 0.05;      // part of a stated mass that is left where it is free
constexpr int kPasses = 40;
constexpr double kRough = 0.1;  // FitLimits::gain of fits that only start the next
// Of the table's first amplitude: what the search starts with before it begins to move. The search comes down from
// there in a few steps, but not up. With 1e-3, seven of a hundred ramps had no number; with 1, three.
constexpr double kBeforeOnset = 1.0;
constexpr double kUnseen = 1e-3;      // m, the table's amplitude where no channel shows it
constexpr double kLeastNoise = 1e-3;  // of a channel's size, where readings hardly scatter from one to the next
// Variance of ln σ: a noise that is known to no more than a factor e is not told from none.
constexpr double kUntoldNoise = 1.0;

class Course {
 public:
  Course(const Rig& rig, MotionData data, std::size_t most, const std::optional<Parameter>& term, std::stop_token stop,
         TableProcess process)
      : rig_(rig), all_(std::move(data)), most_(most), term_(term), stop_(std::move(stop)) {
    out_.process = process;
    for (const Channel& channel : rig.channels) channels_ += channel.measures == Quantity::auxiliary ? 0 : 1;
  }

  MotionCourse run() {
    if (!prepare()) return std::move(out_);
    std::size_t before = 0, count = first_count();
    start(kStretchGrowth * kStretchGrowth * count);
    for (bool last = false; !last;) {
      last = count >= out_.data.readings.size();
      count = std::min(count, out_.data.readings.size());
      if (!fit(before, count, last)) return std::move(out_);
      if (last && (mark_events() || leave_out_far())) last = false;
      before = count;
      count *= kStretchGrowth;
    }
    add_stated();
    return std::move(out_);
  }

 private:
  bool refuse(std::string reason) {
    out_.reason = std::move(reason);
    return false;
  }

  [[nodiscard]] std::vector<double> noise_where_whole() const {
    const auto whole = [this](const MotionReading& r) { return all_.is_whole_at(r.t_ns); };
    if (std::all_of(all_.readings.begin(), all_.readings.end(), whole)) return local_noise(rig_, all_);
    MotionData part;
    std::copy_if(all_.readings.begin(), all_.readings.end(), std::back_inserter(part.readings), whole);
    return local_noise(rig_, part);
  }

  // Chooses the stretch and its pieces.
  bool prepare() {
    const std::vector<double> noise = noise_where_whole();
    activity_ = table_activity(rig_, all_, noise);
    if (activity_.seen && !activity_.moves) return refuse(why_no_motion_is_seen());
    const auto before_ns = static_cast<std::int64_t>(1e9 / rig_.excitation.frequency_hz);
    const auto first = std::find_if(all_.readings.begin(), all_.readings.end(), [&](const MotionReading& r) {
      return r.t_ns >= std::max(activity_.onset_ns - before_ns, all_.whole_from_ns);
    });
    const auto end =
        std::find_if(first, all_.readings.end(), [&](const MotionReading& r) { return r.t_ns >= all_.whole_to_ns; });
    const auto left = static_cast<std::size_t>(end - first);
    out_.data.readings.assign(first, first + static_cast<std::ptrdiff_t>(std::min(left, most_)));
    leave_out_late(local_noise(rig_, out_.data), out_.data);
    leave_out_spikes(rig_, out_.data);
    take_level_crossings(rig_, local_noise(rig_, out_.data), out_.data);
    if (out_.data.readings.empty()) return refuse("too few readings: 0");
    out_.noise = local_noise(rig_, out_.data);
    measure_sizes();
    intensities_ = 0;
    if (!activity_.amplitudes.empty() && out_.data.readings.front().t_ns < activity_.amplitudes.front().from_ns)
      add_stretch(out_.data.readings.front().t_ns, kBeforeOnset * activity_.amplitudes.front().amplitude);
    for (const auto& stretch : activity_.amplitudes)
      if (stretch.from_ns <= out_.data.readings.back().t_ns) add_stretch(stretch.from_ns, stretch.amplitude);
    if (intensities_ == 0) add_stretch(out_.data.readings.front().t_ns, kUnseen);
    const std::size_t fewest = kPerUnknown * unknowns();
    if (out_.data.readings.size() >= fewest) return true;
    return refuse("too few readings: " + std::to_string(out_.data.readings.size()));
  }

  [[nodiscard]] std::string why_no_motion_is_seen() const {
    if (!(activity_.amplitude > rig_.excitation.minimum)) return "the table does not move";
    const std::string& name = rig_.channels[static_cast<std::size_t>(activity_.channel)].name;
    return "whether the table moves cannot be told: " + name + " scatters from reading to reading by " +
           percent(activity_.scatter) + " of its amplitude, and noise alone does so by " + percent(kScatterOfNoise) +
           " or more. If it moves, check " + name + " or read it more often; if not, raise excitation.minimum";
  }

  // What the readings must determine: free_parameters(), the first state, a bias of each channel.
  [[nodiscard]] std::size_t unknowns() const {
    return free_parameters(rig_, intensities_).size() +
           static_cast<std::size_t>(MotionModel(rig_, {}, out_.process).states()) + channels_;
  }

  void add_stretch(std::int64_t from_ns, double amplitude) {
    out_.data.stretches.push_back({from_ns, intensities_++});
    starts_.add_stretch(amplitude);
  }

  void measure_sizes() {
    std::vector<double> count(rig_.channels.size(), 0.0), sum(count), squares(count);
    for (const MotionReading& r : out_.data.readings) {
      const auto c = static_cast<std::size_t>(r.channel);
      count[c] += 1;
      const double delta = r.value - sum[c];  // running mean, then squares about it
      sum[c] += delta / count[c];
      squares[c] += delta * (r.value - sum[c]);
    }
    out_.size.assign(count.size(), 0.0);
    mean_ = sum;
    for (std::size_t c = 0; c < count.size(); ++c)
      if (count[c] > 0) out_.size[c] = std::sqrt(squares[c] / count[c]);
  }

  [[nodiscard]] std::size_t first_count() const {
    const double until_s = to_s(activity_.moves ? activity_.onset_ns : out_.data.readings.front().t_ns) +
                           kFirstPeriods / rig_.excitation.frequency_hz;
    const auto it = std::find_if(out_.data.readings.begin(), out_.data.readings.end(),
                                 [&](const MotionReading& r) { return to_s(r.t_ns) > until_s; });
    return std::max(kFirstReadings, static_cast<std::size_t>(it - out_.data.readings.begin()));
  }

  // From the weak form on the first `count` readings. It is linear, so it has one solution and may use more readings
  // than the first fit; more of them make it less biased by noise.
  void start(std::size_t count) {
    out_.parameters = free_unknowns(intensities_);
    MotionData some{{out_.data.readings.begin(), out_.data.readings.begin() + static_cast<std::ptrdiff_t>(std::min(
                                                                                  out_.data.readings.size(), count))},
                    {}};
    starts_.take_weak_form(weak_form(rig_, some));
    at_.theta.resize(static_cast<Index>(out_.parameters.size()));
    for (std::size_t a = 0; a < out_.parameters.size(); ++a) {
      const Parameter& p = out_.parameters[a];
      const auto i = static_cast<std::size_t>(p.index);
      double value = 0.0;
      if (p.what == Unknown::stiffness) value = starts_.coefficients()(2 * p.index);
      if (p.what == Unknown::damping) value = starts_.coefficients()(2 * p.index + 1);
      if (p.what == Unknown::intensity) value = starts_.ln_q(p.index);
      if (p.what == Unknown::noise)
        value = std::log(
            std::max({std::isfinite(out_.noise[i]) ? out_.noise[i] : 0.0, kLeastNoise * out_.size[i], 1e-300}));
      at_.theta(static_cast<Index>(a)) = value;
    }
    at_.initial = VectorXd::Zero(MotionModel(rig_, {}, out_.process).states());
    at_.bias = Eigen::Map<const VectorXd>(mean_.data(), static_cast<Index>(mean_.size()));
  }

  [[nodiscard]] std::vector<Parameter> free_unknowns(int stretches) const {
    std::vector<Parameter> out = free_parameters(rig_, stretches);
    if (term_) out.push_back(*term_);
    return out;
  }

  [[nodiscard]] FitLimits limits() const {
    FitLimits limits;
    limits.passes = kPasses;
    limits.gain = kRough;
    limits.stop = stop_;
    limits.lowest = VectorXd::Constant(at_.theta.size(), -1e300);
    const double span = to_s(out_.data.readings.back().t_ns - out_.data.readings.front().t_ns);
    double least = 1e-300;
    if (activity_.seen) {
      const auto c = static_cast<std::size_t>(activity_.channel);
      const double noise = std::max(out_.noise[c], 1e-6 * out_.size[c]);
      // Over the whole of it the table wanders by a hundredth of a reading's noise: as good as not at all.
      least = 1e-4 * noise * noise / span;
    }
    for (std::size_t a = 0; a < out_.parameters.size(); ++a) {
      const Parameter& p = out_.parameters[a];
      if (p.what == Unknown::intensity) limits.lowest(static_cast<Index>(a)) = std::log(std::max(least, 1e-300));
      if (p.what == Unknown::noise)
        limits.lowest(static_cast<Index>(a)) =
            std::log(std::max(1e-6 * out_.size[static_cast<std::size_t>(p.index)], 1e-300));
      if (p.what == Unknown::mass && p.prior_u == 0)
        limits.lowest(static_cast<Index>(a)) = lowest_departure(rig_.masses[static_cast<std::size_t>(p.index)]);
    }
    return limits;
  }

  // Fits the first `count` readings. The fit before had the first `before`; 0: there was none.
  bool fit(std::size_t before, std::size_t count, bool whole) {
    const MotionModel model = out_.model(rig_);
    MotionData part{{out_.data.readings.begin(), out_.data.readings.begin() + static_cast<std::ptrdiff_t>(count)},
                    out_.data.stretches};
    out_.limits = limits();
    out_.fit = before == 0
                   ? starts_.first(model, part, at_, out_.limits, out_.noise)
                   : starts_.longer(model, part, at_, out_.limits, part.readings[std::min(before, count) - 1].t_ns);
    out_.passes += out_.fit.passes;
    out_.whole = whole;
    if (!std::isfinite(out_.fit.V)) return refuse("the likelihood is not finite");
    if (!out_.fit.converged && whole)
      return refuse("the estimate did not converge in " + std::to_string(out_.fit.passes) + " passes");
    at_ = out_.fit.at;
    return true;
  }

  // Gives sudden changes of the table an intensity of their own. False: there is nothing to change.
  bool mark_events() {
    if (marked_ || !activity_.seen) return false;
    marked_ = true;
    const Pass pass = evaluate(out_.model(rig_), out_.data, at_, {.derivatives = false, .keep_innovations = true});
    const auto& seen = pass.innovations[static_cast<std::size_t>(activity_.channel)];
    std::vector<MotionStretch> stretches;
    std::size_t events = 0, next = 0;
    int now = 0;
    for (std::size_t i = 1; i < seen.size(); ++i) {
      for (; next < out_.data.stretches.size() && out_.data.stretches[next].from_ns <= seen[i - 1].t_ns; ++next) {
        now = out_.data.stretches[next].intensity;
        stretches.push_back(out_.data.stretches[next]);
      }
      if (std::abs(seen[i].normalized) < kEvent) continue;
      ++events;
      stretches.push_back({seen[i - 1].t_ns + 1, intensities_});
      for (; next < out_.data.stretches.size() && out_.data.stretches[next].from_ns <= seen[i].t_ns; ++next)
        now = out_.data.stretches[next].intensity;
      stretches.push_back({seen[i].t_ns + 1, now});
    }
    if (events == 0 || events > kMostEvents) return false;
    for (; next < out_.data.stretches.size(); ++next) stretches.push_back(out_.data.stretches[next]);
    out_.data.stretches = std::move(stretches);
    add_intensity();
    return true;
  }
  // Takes out, once, what is far from all the rest. False: there is nothing.
  bool leave_out_far() {
    if (left_out_) return false;
    left_out_ = true;
    const Pass pass = evaluate(out_.model(rig_), out_.data, at_, {.derivatives = false, .keep_innovations = true});
    std::vector<MotionReading> kept;
    std::vector<std::size_t> next(pass.innovations.size(), 0);
    for (const MotionReading& reading : out_.data.readings) {
      const auto c = static_cast<std::size_t>(reading.channel);
      if (std::abs(pass.innovations[c][next[c]++].normalized) < kFar) kept.push_back(reading);
    }
    const std::size_t far = out_.data.readings.size() - kept.size();
    if (far == 0 || static_cast<double>(far) > kMostFar * static_cast<double>(kept.size())) return false;
    out_.data.readings = std::move(kept);
    return true;
  }

  // Adds the intensity of events, which starts at a hundred times the largest of the others.
  void add_intensity() {
    const double largest = at_.theta.segment(2 * rig_.element_count(), intensities_).maxCoeff();
    const std::vector<Parameter> parameters = free_unknowns(intensities_ + 1);
    const Index before = 2 * rig_.element_count() + intensities_;
    VectorXd theta(at_.theta.size() + 1);
    theta << at_.theta.head(before), largest + std::log(100.0), at_.theta.tail(at_.theta.size() - before);
    at_.theta = theta;
    out_.parameters = parameters;
    ++intensities_;
  }

  // What the rig file states, with its priors.
  void add_stated() {
    std::vector<Parameter> stated = stated_parameters(rig_);
    if (term_)
      std::erase_if(stated, [this](const Parameter& p) { return p.what == term_->what && p.index == term_->index; });
    if (!stated.empty()) {
      out_.parameters.insert(out_.parameters.end(), stated.begin(), stated.end());
      at_.theta.conservativeResizeLike(VectorXd::Zero(static_cast<Index>(out_.parameters.size())));
    }
    fit_last();
  }
  void fit_last() {
    FitLimits& last = out_.limits;
    last = limits();
    last.gain = FitLimits{}.gain;
    const double span = to_s(out_.data.readings.back().t_ns - out_.data.readings.front().t_ns);
    last.block_s = std::max(2.0 / rig_.excitation.frequency_hz, span / 64);
    const MotionModel model = out_.model(rig_);
    out_.fit = fit_motion(model, out_.data, at_, last);
    out_.passes += out_.fit.passes;
    if (MotionUnknowns with = out_.fit.at; raise_vanished_noise(with)) {
      out_.fit = fit_motion(model, out_.data, std::move(with), last);
      out_.passes += out_.fit.passes;
    }
    if (!out_.fit.converged)
      refuse("the estimate with the stated uncertainties did not converge in " + std::to_string(out_.fit.passes) +
             " passes");
  }

  // Where the likelihood lets the noise of a channel vanish, the table's process or the chain has taken it up, and
  // every uncertainty would be that of readings without noise. The noise is then no less than noise_of_readings() has
  // it. Returns whether there is such a channel.
  bool raise_vanished_noise(MotionUnknowns& at) {
    if (!out_.fit.converged) return false;
    bool raised = false;
    for (Index a = 0; a < at.theta.size(); ++a) {
      const Parameter& p = out_.parameters[static_cast<std::size_t>(a)];
      const double variance = out_.fit.covariance(a, a);  // of ln σ; 0 at its bound, or where no reading tells it
      if (p.what != Unknown::noise || (variance > 0 && variance < kUntoldNoise)) continue;
      const double least = std::log(noise_of(p.index));
      if (!std::isfinite(least) || least <= at.theta(a)) continue;
      out_.limits.lowest(a) = at.theta(a) = least;
      raised = true;
    }
    return raised;
  }
  [[nodiscard]] double noise_of(int channel) const {
    std::vector<double> t, value;
    for (const MotionReading& reading : out_.data.readings) {
      if (reading.channel != channel) continue;
      t.push_back(to_s(reading.t_ns - out_.data.readings.front().t_ns));
      value.push_back(reading.value);
    }
    return noise_of_readings(t, value);
  }

  const Rig& rig_;
  MotionData all_;
  std::size_t most_;
  std::optional<Parameter> term_;
  std::stop_token stop_;
  std::size_t channels_ = 0;
  int intensities_ = 0;
  TableActivity activity_;
  SearchStarts starts_{rig_};
  std::vector<double> mean_;
  MotionUnknowns at_;
  bool marked_ = false, left_out_ = false;
  MotionCourse out_;
};

}  // namespace

double lowest_departure(double mass) { return -(1 - kLeastMass) * mass; }

MotionCourse run_course(const Rig& rig, MotionData data, std::size_t most, const std::optional<Parameter>& term,
                        std::stop_token stop, TableProcess process) {
  return Course(rig, std::move(data), most, term, std::move(stop), process).run();
}

}  // namespace dwell
