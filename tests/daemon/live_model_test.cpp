// Coefficients from the transient and the verification of the model, on the way that a live service takes: devices,
// estimator in virtual time, the worker's jobs done by hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "core/model/driven_chain.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "core/verify/verification.hpp"
#include "daemon/estimate/estimator.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/daemon/collecting_sink.hpp"
#include "tests/durations.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

constexpr double kTable_hz = 4.0;

// A rig whose table rests for half a second, then moves at 4 Hz; scanned 200 times a second, all channels at once.
struct LiveRig {
  LiveRig(const Chain& the_chain, double amplitude, double sigma, record::StreamSink* sink = nullptr,
          DrivenChain::Start start = DrivenChain::Start::rest)
      : chain(the_chain),
        rig(rig_of(chain, kTable_hz)),
        steady(start == DrivenChain::Start::steady),
        motion(chain, {kTable_hz, amplitude, 0.0, 0.0}, start),
        normal(0.0, sigma) {
    LogOptions quiet;
    quiet.console = false;
    log = std::move(*Log::make(quiet));
    rig.devices = {{"amplifier", 0.0, 0.0}};
    std::vector<std::uint16_t> channels;
    for (Channel& channel : rig.channels) {
      channel.device = 0;
      channels.push_back(static_cast<std::uint16_t>(channels.size()));
    }
    link.emplace("amplifier", channels, 4096, nullptr);
    work = std::make_shared<LongWork>(rig, 0.05);
    EstimatorOptions options;
    options.long_work = work;
    options.runs.sink = sink;
    estimator.emplace(
        rig, std::vector<DeviceFeed>{{&*link, "modbus", 200.0, false}}, options, *log, [] {}, now_ns);
  }
  enum class Workers { none, both, verifying };
  // Until so many seconds after the table began to move, turning every 10 ms. The workers' jobs are done at once.
  void run(double until_s, Workers workers = Workers::both) {
    while (moving_s(now_ns) < until_s) {
      now_ns += 10 * kMs_ns;
      for (const std::int64_t before_ns : {6, 1}) scan(now_ns - before_ns * kMs_ns);
      estimator->turn(now_ns, now_ns + 1);
      if (workers == Workers::both) jobs += work->estimate() ? 1 : 0;
      if (workers != Workers::none) jobs += work->verify() ? 1 : 0;
    }
  }
  void scan(std::int64_t t_ns) {
    const double t_s = moving_s(t_ns);
    if (t_s > silent_from_s) return;
    std::vector<dwell_sample> samples;
    for (std::size_t c = 0; c < rig.channels.size(); ++c) {
      const double moved =
          !steady && t_s < 0 ? 0.0 : exact_reading(rig, motion.at(steady ? t_s + 1.0 : t_s), static_cast<int>(c));
      const double scale = rig.channels[c].measures == Quantity::force ? 1e4 : 1.0;
      const double gain =
          rig.channels[c].measures == Quantity::displacement && rig.channels[c].at == 1 ? gain_of_y1 : 1;
      if (c > 0 || scans % y0_every == 0) read[c] = gain * moved;
      samples.push_back({t_ns, read[c] + scale * normal(rng), 1000, static_cast<std::uint16_t>(c), 0});
    }
    ++scans;
    ASSERT_TRUE(link->push(samples.data(), samples.size()));
  }
  static double moving_s(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns - kMoves_ns); }
  const Snapshot& latest() {
    estimator->refresh();
    return estimator->latest();
  }

  static constexpr std::int64_t kStart_ns = 5'000 * kMs_ns, kMoves_ns = kStart_ns + 500 * kMs_ns;
  Chain chain;
  Rig rig;
  bool steady;  // the table moves before the first scan, the transient is over
  DrivenChain motion;
  std::mt19937_64 rng{3};
  std::normal_distribution<double> normal;
  std::unique_ptr<Log> log;
  std::optional<DeviceLink> link;
  std::shared_ptr<LongWork> work;
  std::optional<Estimator> estimator;
  std::int64_t now_ns = kStart_ns;
  double silent_from_s = INFINITY;  // the device sends nothing from then on
  double gain_of_y1 = 1.0;          // that the rig file does not know of
  int y0_every = 1;                 // scans in which y0 is refreshed; in the others it is as old as then, noise apart
  std::array<double, 8> read{};     // newest of each channel, without noise
  int scans = 0;
  int jobs = 0;
};

// t = 0 of a run.
std::int64_t origin_of(const std::vector<Record>& stream) {
  return std::find_if(stream.begin(), stream.end(), [](const Record& r) { return concerns_pipeline(r.kind); })->t_ns;
}

// ζ = 0.2 %: the transient takes 100 s to fall to 0.5 %.
Chain hardly_damped() {
  const double natural = 2 * std::numbers::pi * 4.4;
  return {Boundary::free, {10.0}, {10.0 * natural * natural}, {2 * 0.002 * 10.0 * natural}};
}

TEST(LiveModel, HasCoefficientsInSecondsWhereTheVerdictTakesMinutes) {
  LiveRig live(hardly_damped(), 0.002, 2e-5);
  live.run(5.0);
  const auto early = live.latest().transient;
  ASSERT_TRUE(early);
  ASSERT_EQ(early->estimate.reason, "");
  const ElementEstimate& element = early->estimate.elements.front();
  EXPECT_LT(element.stiffness.U95, 0.1 * live.chain.stiffness[0]);
  EXPECT_LT(element.damping.U95, 0.1 * live.chain.damping[0]);
  EXPECT_LT(std::abs(element.stiffness.value - live.chain.stiffness[0]), 4 * element.stiffness.u);
  EXPECT_LT(std::abs(element.damping.value - live.chain.damping[0]), 4 * element.damping.u);
  EXPECT_LE(early->until_s, 5.5) << "on the run's axis, the table moved from 0.5 s on";

  // Under a sanitizer a second played takes half a second: 25 of them show as well that it narrows and that the verdict
  // is awaited.
  live.run(kUnderSanitizer ? 25.0 : 60.0);
  EXPECT_FALSE(std::isfinite(live.latest().dwell.settled_s)) << "the harmonic verdict is still awaited";
  const ElementEstimate& late = live.latest().transient->estimate.elements.front();
  EXPECT_LT(late.stiffness.U95, 0.3 * element.stiffness.U95) << "it narrows meanwhile";
  EXPECT_LT(std::abs(late.damping.value - live.chain.damping[0]), 4 * late.damping.u);
  EXPECT_FALSE(live.latest().transient_agreement) << "nothing to compare with yet";
  EXPECT_LE(live.jobs, 16);
}

// An estimate that looks for what is missing takes minutes.
TEST(LiveModel, TheVerdictOnADwellDoesNotWaitForAnEstimateThatIsUnderWay) {
  LiveRig live(clamped_chain(), 0.005, 1e-5);
  live.run(20.0, LiveRig::Workers::verifying);
  const Snapshot& now = live.latest();
  ASSERT_EQ(now.dwell.state, State::measuring) << now.dwell.settling_reason;
  EXPECT_FALSE(live.work->estimates.free()) << "the estimate is under way";
  ASSERT_TRUE(now.verified);
  EXPECT_EQ(now.verified->verification.verdict, Verdict::adequate);
}

TEST(LiveModel, ComparesWithTheDwellOnceThatHasSettledAndVerifiesItsModel) {
  LiveRig live(clamped_chain(), 0.005, 1e-5);
  live.run(20.0);
  const Snapshot& now = live.latest();
  ASSERT_EQ(now.dwell.state, State::measuring) << now.dwell.settling_reason;
  ASSERT_TRUE(now.transient);
  ASSERT_EQ(now.transient->estimate.reason, "");
  EXPECT_LT(now.transient->until_s, now.dwell.verdict_s + 0.5) << "taken over by the dwell, until that ends";
  ASSERT_TRUE(now.transient_agreement);
  EXPECT_LT(now.transient_agreement->e_n, 1.5) << "the largest of all differences, over twice its u";
  ASSERT_TRUE(now.verified);
  EXPECT_EQ(now.verified->dwell.index, now.dwell.index);
  EXPECT_EQ(now.verified->verification.verdict, Verdict::adequate)
      << (now.verified->verification.reasons.empty() ? "" : now.verified->verification.reasons.front());
}

TEST(LiveModel, TellsAndRecordsWhatAnyMotionHoldsAgainstADwellThatHasEnded) {
  test::CollectingSink sink;
  LiveRig live(clamped_chain(), 0.005, 1e-5, &sink);
  live.gain_of_y1 = 1.1;
  live.silent_from_s = 20.0;
  const auto objection = [&] {
    const VerifiedModel* const known = verdict_on(live.latest().models.get(), 1);
    return known != nullptr ? known->model.objection : std::string();
  };
  live.run(19.0);
  ASSERT_EQ(live.latest().dwell.state, State::measuring) << live.latest().dwell.settling_reason;
  live.run(30.0);
  EXPECT_NE(live.latest().dwell.index, 1);
  EXPECT_TRUE(objection().starts_with("any motion: the chain of the rig file does not explain")) << objection();

  const TransientEstimate* recorded = nullptr;
  for (const auto& [position, model] : sink.models)
    if (const auto* const estimate = std::get_if<std::shared_ptr<const TransientEstimate>>(&model))
      recorded = estimate->get();
  ASSERT_TRUE(recorded);
  EXPECT_EQ(recorded->dwell, 1);
  EXPECT_EQ(recorded->objection, objection()) << "and it is recorded";
}

// A register that is refreshed less often than it is read. In the steady motion only the table's residuals show it.
TEST(LiveModel, TellsThatTheTablesReadingsErrInAPatternWhichTheDwellsUncertaintyDoesNotCover) {
  for (const int every : {1, 4}) {
    LiveRig live({Boundary::free, {2.0}, {6000.0}, {12.0}}, 0.005, 1e-5, nullptr, DrivenChain::Start::steady);
    live.y0_every = every;
    live.silent_from_s = 6.0;
    live.run(12.0);
    const VerifiedModel* const known = verdict_on(live.latest().models.get(), 1);
    ASSERT_TRUE(known);
    const std::string& objection = known->model.objection;
    if (every == 1) {
      EXPECT_EQ(objection, "");
      continue;
    }
    EXPECT_EQ(objection.find("any motion: the readings of y0 err in a pattern, by "), 0U) << objection;
    EXPECT_TRUE(objection.ends_with("The ± of this dwell does not cover it")) << objection;
  }
}

TEST(LiveModel, HoldsNothingAgainstADwellThatIsRight) {
  LiveRig live(clamped_chain(), 0.005, 1e-5);
  live.silent_from_s = 20.0;
  live.run(30.0);
  const VerifiedModel* const known = verdict_on(live.latest().models.get(), 1);
  ASSERT_TRUE(known);
  EXPECT_EQ(known->model.objection, "");
}

// What is recorded of an estimate names its stretch of the stream. From that alone it is computed again, bit by bit.
TEST(LiveModel, ARecordedEstimateCanBeComputedAgainFromItsStretchOfTheStream) {
  test::CollectingSink sink;
  LiveRig live(clamped_chain(), 0.005, 1e-5, &sink);
  live.run(20.0);
  const std::vector<Record> stream = sink.runs().at(0).records;
  int estimates = 0;
  for (const auto& [position, model] : sink.models) {
    ASSERT_LE(position, stream.size());
    const auto* const of = std::get_if<std::shared_ptr<const TransientEstimate>>(&model);
    if (of == nullptr) continue;
    const TransientEstimate& stored = **of;
    ASSERT_LE(stored.last, position);
    std::vector<Record> samples;
    for (std::size_t i = 0; i < stored.last; ++i)
      if (stream[i].kind == Kind::sample) samples.push_back(stream[i]);
    ASSERT_GE(samples.size(), stored.given);
    MotionRecorder recorder(live.rig);
    for (auto sample = samples.end() - static_cast<std::ptrdiff_t>(stored.given); sample != samples.end(); ++sample) {
      Record record = *sample;
      record.t_ns -= origin_of(stream);
      recorder.take(record);
    }
    const MotionEstimate again = estimate_motion(live.rig, recorder.data());
    ASSERT_EQ(again.reason, stored.estimate.reason);
    ASSERT_EQ(again.elements.size(), stored.estimate.elements.size());
    for (std::size_t k = 0; k < again.elements.size(); ++k)
      EXPECT_EQ(again.elements[k].stiffness.value, stored.estimate.elements[k].stiffness.value);
    ++estimates;
  }
  EXPECT_GE(estimates, 2);
}

TEST(LiveModel, ARecordedVerificationCanBeMadeAgainFromTheStream) {
  test::CollectingSink sink;
  LiveRig live(clamped_chain(), 0.005, 1e-5, &sink);
  live.run(20.0);
  const std::vector<Record> stream = sink.runs().at(0).records;
  int verifications = 0;
  for (const auto& [position, model] : sink.models) {
    const auto* const of = std::get_if<std::shared_ptr<const VerifiedDwell>>(&model);
    if (of == nullptr) continue;
    const VerifiedDwell& stored = **of;
    ASSERT_LE(stored.position, position);
    Measurement measurement(live.rig, KeptDwells(10, 1'000'000), [](RunEvent) {});
    for (std::size_t i = 0; i < stored.position; ++i) measurement.take(stream[i]);
    const Dwell dwell = measurement.current();
    EXPECT_EQ(dwell.frequency_hz.value, stored.dwell.frequency_hz.value);
    std::vector<ChannelReadings> evidence(live.rig.channels.size());
    const SampleHistory& counted = *measurement.readings();
    for (std::uint64_t number = stored.last - stored.given; number < stored.last; ++number) {
      ChannelReadings& channel = evidence[static_cast<std::size_t>(counted[number].channel)];
      channel.t_ns.push_back(counted[number].t_ns - origin_of(stream));
      channel.value.push_back(counted[number].value);
    }
    const Verification again = verify_model(live.rig, dwell, evidence, 0.05);
    EXPECT_EQ(again.verdict, stored.verification.verdict);
    EXPECT_EQ(again.e_n, stored.verification.e_n);
    EXPECT_EQ(again.chi2, stored.verification.chi2);
    ++verifications;
  }
  EXPECT_GE(verifications, 2);
}

TEST(LiveModel, AnIdleRigCostsNothing) {
  LiveRig live(clamped_chain(), 0.0, 1e-9);
  live.run(20.0);
  EXPECT_EQ(live.jobs, 0);
  EXPECT_FALSE(live.latest().transient);
  EXPECT_FALSE(live.latest().verified);
}

TEST(LiveModel, AWorkerThatNeverComesHoldsNothingUp) {
  LiveRig live(clamped_chain(), 0.005, 1e-5);
  live.run(20.0, LiveRig::Workers::none);
  EXPECT_EQ(live.latest().dwell.state, State::measuring);
  EXPECT_FALSE(live.latest().transient);
  EXPECT_EQ(live.latest().channels[0].tally.dropped(), 0u);
}

}  // namespace
}  // namespace dwell
