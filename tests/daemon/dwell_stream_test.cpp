#include "daemon/outlets/dwell_stream.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/report/dwell_json.hpp"

namespace dwell {
namespace {

// A chain of n elements, measured, with everything that one publication carries; `step` makes every number another.
DwellView publication(int n, int step) {
  const double drift = 1.0 + 1e-6 * step / 3.0;
  DwellView view;
  Dwell& dwell = view.dwell;
  dwell.index = 1;
  dwell.state = State::measuring;
  dwell.start_s = 0.0;
  dwell.settled_s = 6.42;
  dwell.end_s = 31.0 + 0.1 * step;
  dwell.frequency_hz = {4.0003 * drift, 2e-5 * drift};
  dwell.t_ref_s = 18.7 * drift;
  for (int i = 0; i <= n; ++i) {
    ChannelPhasor phasor;
    phasor.Y = {0.005 / 3.0 * drift, 0.001 / 7.0 * drift};
    phasor.u_amplitude = 1e-7 / 3.0 * drift;
    phasor.u_phase_rad = 2e-5 / 3.0 * drift;
    phasor.mean = 0.0012 / 7.0 * drift;
    phasor.harmonics = {0.002 / 3.0 * drift, 0.0007 / 3.0 * drift};
    phasor.sigma = 1e-6 / 3.0 * drift;
    phasor.samples = 15'000 + 50 * step;
    phasor.valid = true;
    dwell.phasors.push_back(phasor);
    view.channels.push_back({"y" + std::to_string(i), "m"});
  }
  for (int k = 1; k <= n; ++k) {
    ElementEstimate element;
    element.k = k;
    element.identifiable = true;
    element.deformation = {0.0021 / 3.0 * drift, 1e-7 / 3.0 * drift};
    element.stiffness = {24010.0 / 7.0 * drift, 14.0 / 3.0 * drift, 3100.0 / 7.0 * drift, 27.4 / 3.0 * drift, true};
    element.damping = {60.2 / 7.0 * drift, 0.4 / 3.0 * drift, 3100.0 / 7.0 * drift, 0.79 / 3.0 * drift, true};
    element.loss_factor = {0.063 / 7.0 * drift, 0.0004 / 3.0 * drift};
    for (int source = 0; source < 3 * n; ++source) {
      const std::string channel = "y" + std::to_string(source);
      element.budget.push_back({"scale of " + channel, drift / 3.0 / n, drift / 7.0 / n, SourceKind::scale, channel});
    }
    dwell.elements.push_back(std::move(element));
  }
  dwell.covariance.assign(static_cast<std::size_t>(4 * n) * static_cast<std::size_t>(n), 196.0 / 7.0 * drift);
  view.age = LiveAge{0.1, false};
  view.since = SinceBefore{1, "2026-11-23T07:00:00Z", 20.0, {{1, {0.01 * drift, 0.002, true}, {}}}};
  return view;
}

constexpr std::int64_t kPublication_ns = 100'000'000;

TEST(DwellStream, AtThirtyElementsASecondCostsLittleMoreThanOneWholeDwell) {
  DwellStream stream;
  std::size_t whole = 0, told = 0;
  (void)stream.next(publication(30, 0), 0);
  for (int step = 1; step <= 10; ++step) {
    whole += to_json(publication(30, step)).size();
    told += stream.next(publication(30, step), step * kPublication_ns).data.size();
  }
  RecordProperty("bytes_per_publication_whole", static_cast<int>(whole / 10));
  RecordProperty("bytes_per_publication_told", static_cast<int>(told / 10));
  EXPECT_LT(told / 10, whole / 10 / 6) << told / 10 << " bytes a publication, of " << whole / 10;
}

TEST(DwellStream, TheWholeComesFirstAndThenOnceASecond) {
  DwellStream stream;
  std::string names;
  for (int step = 0; step <= 20; ++step) names += stream.next(publication(2, step), step * kPublication_ns).name[0];
  EXPECT_EQ(names, "dcccccccccdcccccccccd");
}

TEST(DwellStream, TheWholeComesAtAChangeOfStateAndForWhoeverJoins) {
  DwellStream stream;
  const auto name = [&stream](const DwellView& view, int step) {
    return std::string(stream.next(view, step * kPublication_ns).name);
  };
  EXPECT_EQ(name(publication(2, 0), 0), "dwell");
  EXPECT_EQ(name(publication(2, 1), 1), "change");
  DwellView other = publication(2, 2);
  other.dwell.state = State::settling;
  EXPECT_EQ(name(other, 2), "dwell");
  EXPECT_EQ(name(other, 3), "change");
  stream.joined();
  EXPECT_EQ(name(other, 4), "dwell");
  other.dwell.elements[0].identifiable = false;
  EXPECT_EQ(name(other, 5), "dwell") << "an element that is withheld";
}

TEST(DwellStream, AChangeNamesItsDwellAndHoldsNeitherCovarianceNorBudgets) {
  DwellStream stream;
  (void)stream.next(publication(2, 0), 0);
  const nlohmann::ordered_json change =
      nlohmann::ordered_json::parse(stream.next(publication(2, 1), kPublication_ns).data);
  EXPECT_EQ(change["index"], 1);
  EXPECT_EQ(change["state"], "measuring");
  EXPECT_EQ(change["elements"].size(), 2u);
  EXPECT_EQ(change["elements"][1]["k"], 2);
  EXPECT_FALSE(change.contains("covariance"));
  EXPECT_FALSE(change["elements"][0].contains("budget"));
  EXPECT_FALSE(change.contains("since"));
}

}  // namespace
}  // namespace dwell
