// Runs of plain readings: which readings are, and that judging them at once changes no bit.
#include "core/intake/plain_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/intake/live_channel.hpp"
#include "core/model/driven_chain.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kPace_ns = 1'000'000;
constexpr double kPlainDrive_hz = 10.0;

// A run after a reading at 0 whose sixteen numbers before are -16 … -1.
PlainRun begun() {
  PlainRun run;
  for (std::size_t i = 0; i < PlainRun::kBefore; ++i) run.before()[i] = static_cast<double>(i) - PlainRun::kBefore;
  run.begin(0, kPace_ns);
  return run;
}

TEST(PlainRun, EndsAtAReadingOffThePaceOrFlaggedOrLessCertainInTime) {
  PlainRun run = begun();
  run.add(kPace_ns, 1.0, 500, false);
  run.add(2 * kPace_ns, 2.0, 500, false);
  EXPECT_EQ(run.count(), 2U);
  EXPECT_EQ(run.last_ns(), 2 * kPace_ns);
  for (const auto& [t_ns, half_ns, flagged] : std::vector<std::tuple<std::int64_t, std::uint32_t, bool>>{
           {3 * kPace_ns + 1, 500, false}, {3 * kPace_ns, 501, false}, {3 * kPace_ns, 500, true}}) {
    PlainRun other = run;
    other.add(t_ns, 3.0, half_ns, flagged);
    EXPECT_EQ(other.count(), 2U);
    other.add(3 * kPace_ns, 3.0, 500, false);
    EXPECT_EQ(other.count(), 2U) << "it has ended";
  }
  for (std::size_t i = 3; i < 100; ++i) run.add(static_cast<std::int64_t>(i) * kPace_ns, 3.0, 500, false);
  EXPECT_EQ(run.count(), PlainRun::kMost);
}

TEST(PlainRun, ANumberRecursIfItIsOneOfTheSixteenBefore) {
  PlainRun run = begun();
  run.add(kPace_ns, -16.0, 0, false);
  run.add(2 * kPace_ns, -16.0, 0, false);
  run.add(3 * kPace_ns, -15.0, 0, false);
  run.add(4 * kPace_ns, 7.0, 0, false);
  EXPECT_TRUE(run.recurs(0));
  EXPECT_TRUE(run.recurs(1));
  EXPECT_FALSE(run.recurs(2)) << "seventeen ago";
  EXPECT_FALSE(run.recurs(3));
}

// The purpose of runs: hardly a reading of a steady motion is judged by itself.
TEST(PlainRun, NearlyAllReadingsOfASteadyMotionArePlain) {
  LiveChannel channel{Channel{}};
  std::mt19937_64 rng(5);
  std::normal_distribution<double> normal;
  const double omega = 2 * M_PI * kPlainDrive_hz;
  std::size_t plain = 0, all = 0;
  for (int i = 1; i <= 20'000; i += 25) {
    if (i % 100 == 1) channel.next_period();
    PlainRun run;
    channel.begin(run, omega);
    std::vector<Record> records;
    for (int k = i; k < i + 25; ++k) {
      records.push_back({.t_ns = k * kPace_ns,
                         .value = std::sin(1e-9 * omega * static_cast<double>(k * kPace_ns)) + 5e-4 * normal(rng),
                         .t_half_ns = 100});
      run.add(records.back().t_ns, records.back().value, records.back().t_half_ns, false);
    }
    channel.take_plain(run, omega);
    if (i > 10'000) plain += run.count(), all += records.size();
    for (std::size_t k = 0; k < records.size(); ++k) {
      const LiveChannel::Reading reading{records[k].t_ns, records[k].value, records[k].t_half_ns};
      if (k < run.count())
        channel.count(reading);
      else if (channel.hear(records[k]))
        channel.judge(records[k], omega, [&](const LiveChannel::Reading& passed) { channel.count(passed); });
    }
  }
  EXPECT_GT(static_cast<double>(plain), 0.9 * static_cast<double>(all));
  EXPECT_EQ(channel.now(1 / kPlainDrive_hz).used, 20'000U);
}

using Disturb = std::function<void(Record&)>;

// Twelve seconds of two masses on a table from rest, at 1 kHz.
std::vector<Record> disturbed_stream(const Chain& chain, const Disturb& disturb) {
  DrivenChain motion(chain, {.frequency_hz = kPlainDrive_hz, .amplitude = 2e-3, .ramp_s = 0.1},
                     DrivenChain::Start::rest);
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  std::vector<Record> records;
  for (int i = 0; i < 12'000; ++i) {
    const ChainMotion& now = motion.at(1e-9 * static_cast<double>(i * kPace_ns));
    if (i % 10 == 0) records.push_back({.t_ns = i * kPace_ns, .kind = Kind::tick});
    for (std::size_t c = 0; c < now.y.size(); ++c) {
      records.push_back({.t_ns = i * kPace_ns,
                         .value = now.y[c] + 1e-6 * normal(rng),
                         .t_half_ns = 100'000,
                         .channel = static_cast<std::uint16_t>(c)});
      disturb(records.back());
    }
  }
  // Jittered instants may have left the order.
  std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.t_ns < b.t_ns; });
  return records;
}

std::vector<double> numbers_of(const Pipeline& pipeline, const Rig& rig) {
  const Dwell dwell = pipeline.current();
  std::vector<double> all = {dwell.start_s, dwell.settled_s,    dwell.verdict_s,          dwell.end_s,
                             dwell.t_ref_s, dwell.settles_in_s, dwell.frequency_hz.value, dwell.frequency_hz.u};
  for (const ChannelPhasor& phasor : dwell.phasors)
    for (const double x : {phasor.Y.real(), phasor.Y.imag(), phasor.u_amplitude, phasor.u_phase_rad}) all.push_back(x);
  for (const ElementEstimate& element : dwell.elements)
    for (const Coefficient& c : {element.stiffness, element.damping}) all.insert(all.end(), {c.value, c.u, c.U95});
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
    const ChannelNow now = pipeline.channel(c);
    for (const double x :
         {now.value, static_cast<double>(now.t_ns), static_cast<double>(now.used), static_cast<double>(now.rejected),
          static_cast<double>(now.gaps), static_cast<double>(now.condition), static_cast<double>(now.fault)})
      all.push_back(x);
  }
  return all;
}

TEST(PlainRun, WhateverDisturbsTheReadingsBlocksGiveTheBitsOfSingleRecords) {
  std::mt19937_64 rng(17);
  std::uniform_real_distribution<double> part;
  std::map<int, std::vector<double>> past;
  const auto older = [&past](const Record& record, std::size_t ago) {
    const std::vector<double>& numbers = past[record.channel];
    return numbers.size() > ago ? numbers[numbers.size() - 1 - ago] : record.value;
  };
  const std::map<std::string, Disturb> disturbances = {
      {"nothing", [](Record&) {}},
      {"coarse rounding", [](Record& r) { r.value = 2e-5 * std::round(r.value / 2e-5); }},
      {"fine rounding", [](Record& r) { r.value = 1e-7 * std::round(r.value / 1e-7); }},
      {"repeats", [&](Record& r) { r.value = part(rng) < 0.01 ? older(r, 0) : r.value; }},
      {"older answers", [&](Record& r) { r.value = part(rng) < 0.01 ? older(r, 2) : r.value; }},
      {"zeros and spikes",
       [&](Record& r) { r.value = part(rng) < 0.003   ? 0.0
                                  : part(rng) < 0.002 ? 30 * r.value
                                                      : r.value; }},
      {"codes and no numbers",
       [&](Record& r) { r.value = part(rng) < 0.002   ? 32767.0
                                  : part(rng) < 0.001 ? NAN
                                                      : r.value; }},
      {"clipped crests", [](Record& r) { r.value = std::clamp(r.value, -1.7e-3, 1.7e-3); }},
      {"a held register", [&](Record& r) { r.value = r.t_ns / kPace_ns % 3 == 0 ? r.value : older(r, 0); }},
      {"a beat of repeats", [&](Record& r) { r.value = r.t_ns / kPace_ns % 41 == 0 ? older(r, 0) : r.value; }},
      {"held answers", [&](Record& r) { r.t_half_ns = part(rng) < 0.02 ? 1'000'000 : 100'000; }},
      {"gaps", [&](Record& r) { r.flags = part(rng) < 0.005 ? kGap : 0; }},
      {"replaced stamps", [&](Record& r) { r.flags = part(rng) < 0.05 ? kStampReplaced : 0; }},
      {"jitter", [&](Record& r) { r.t_ns += part(rng) < 0.05 ? static_cast<std::int64_t>(2e6 * part(rng)) : 0; }},
      {"pauses", [](Record& r) { r.channel = r.t_ns % 3'000'000'000 < 40'000'000 ? 99 : r.channel; }},
  };
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, kPlainDrive_hz);
  for (const auto& [what, disturb] : disturbances) {
    past.clear();
    const std::vector<Record> stream = disturbed_stream(chain, [&](Record& record) {
      disturb(record);
      if (std::isfinite(record.value)) past[record.channel].push_back(record.value);
    });
    Pipeline single(rig), blocks(rig);
    for (std::span<const Record> left = stream; !left.empty();) {
      const std::size_t most = std::min<std::size_t>(left.size(), 1 + rng() % 700);
      std::size_t taken = blocks.push_in_block(left.first(most));
      ASSERT_LE(taken, most);
      if (taken == 0) blocks.push(left[taken++]);
      for (const Record& record : left.first(taken)) single.push(record);
      left = left.subspan(taken);
      if (rng() % 16 != 0 && !left.empty()) continue;
      const std::vector<double> of_single = numbers_of(single, rig), of_blocks = numbers_of(blocks, rig);
      ASSERT_EQ(of_single.size(), of_blocks.size()) << what;
      for (std::size_t i = 0; i < of_single.size(); ++i)
        ASSERT_TRUE(of_single[i] == of_blocks[i] || (std::isnan(of_single[i]) && std::isnan(of_blocks[i])))
            << what << ", number " << i << " after " << stream.size() - left.size() << " records";
      ASSERT_EQ(single.current().warnings, blocks.current().warnings) << what;
    }
  }
}

}  // namespace
}  // namespace dwell
