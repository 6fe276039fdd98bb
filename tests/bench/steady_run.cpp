#include "tests/bench/steady_run.hpp"

#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "tests/bench/steady_rig.hpp"
#include "tests/ctl/run_file_builder.hpp"
#include "tests/record/scratch.hpp"

namespace dwell {
namespace {

std::vector<Record> stream_of(SteadyRig& source, double rate_hz, double duration_s) {
  std::vector<Record> stream;
  const auto add = [&](double t_s, Kind kind, int channel, double value, std::uint8_t flags) {
    const std::int64_t t_ns = 1'000'000'000 + std::llround(1e9 * t_s);
    stream.push_back({.t_ns = t_ns,
                      .stamped_ns = t_ns,
                      .value = value,
                      .t_half_ns = 100'000,
                      .channel = static_cast<std::uint16_t>(channel),
                      .kind = kind,
                      .flags = flags});
  };
  add(0.0, Kind::run, 0, 0.0, static_cast<std::uint8_t>(RunEdge::armed));
  const auto scans = std::llround(duration_s * rate_hz);
  double next_tick_s = 0.01;
  for (long long scan = 0; scan < scans; ++scan) {
    const double t_s = static_cast<double>(scan) / rate_hz;
    for (; next_tick_s <= t_s; next_tick_s += 0.01) add(next_tick_s, Kind::tick, 0, 0.0, 0);
    for (int c = 0; c < source.channels(); ++c) add(t_s, Kind::sample, c, 1e3 * source.reading(c, t_s), 0);
  }
  add(duration_s, Kind::run, 0, 0.0, static_cast<std::uint8_t>(RunEdge::ends));
  return stream;
}

}  // namespace

const std::string& steady_run(double rate_hz, double duration_s) {
  static const record::Scratch folder(true);
  static std::map<std::pair<double, double>, std::string> made;
  std::string& path = made[{rate_hz, duration_s}];
  if (!path.empty()) return path;
  path = folder.path(std::to_string(made.size()) + ".dwell");
  SteadyRig source;
  test::SimulatedRig rig;
  rig.chain.boundary = source.rig().boundary;
  rig.chain.masses = source.rig().masses;
  rig.frequency_hz = SteadyRig::kFrequency_hz;
  test::write_run(path, rig.rig_text(), stream_of(source, rate_hz, duration_s),
                  {.header = {}, .result = {}, .every_s = 1.0, .commits = true});
  return path;
}

}  // namespace dwell
