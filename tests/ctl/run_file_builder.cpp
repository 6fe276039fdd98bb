#include "tests/ctl/run_file_builder.hpp"

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <stdexcept>

#include "config/rig_file.hpp"
#include "daemon/estimate/long_work.hpp"
#include "daemon/estimate/measurement.hpp"
#include "daemon/estimate/model_work.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_line.hpp"
#include "daemon/run/stored_model.hpp"

namespace dwell::test {
namespace {

constexpr std::int64_t kBorn_ns = 4'000'000'000'123;  // the computer has been on for an hour

std::string joined(const std::vector<double>& values, double scale) {
  std::string text;
  for (const double value : values) {
    char number[40];
    std::snprintf(number, sizeof number, "%.17g", scale * value);
    text.append(text.empty() ? "" : ", ").append(number);
  }
  return "[" + text + "]";
}

template <class T, class Error>
T must(tl::expected<T, Error> result) {
  if (!result) throw std::runtime_error(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

}  // namespace

std::string SimulatedRig::rig_text(double mass_scale) const {
  const bool clamped = chain.boundary == Boundary::clamped;
  std::string text = "[rig]\nname = \"bench\"\nboundary = \"" + std::string(clamped ? "clamped" : "free") +
                     "\"\nmasses = " + joined(chain.masses, mass_scale) + "\nmass_u = " + joined(chain.masses, 1e-3) +
                     "\n[excitation]\nfrequency = " + joined({frequency_hz}, 1.0).substr(1);
  text.pop_back();
  text += "\nsearch = " + joined({0.9 * frequency_hz, 1.1 * frequency_hz}, 1.0) + "\nminimum = 2e-5\n";
  for (int k = 0; k <= chain.mass_count(); ++k)
    text += "[[channel]]\nname = \"y" + std::to_string(k) +
            "\"\nmeasures = \"displacement\"\nat = " + std::to_string(k) + "\nunit = \"mm\"\nscale_u = 0.0005\n";
  if (clamped)
    text += "[[channel]]\nname = \"reaction\"\nmeasures = \"force\"\nat = \"ground\"\nunit = \"N\"\nscale_u = 0.0005\n";
  return text;
}

SimulatedRig SimulatedRig::random(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> part(0.0, 1.0);
  SimulatedRig rig;
  rig.frequency_hz = 3.0 + 5.0 * part(rng);
  rig.rate_hz = 100.0 + std::floor(150.0 * part(rng));
  const double omega = 2.0 * std::numbers::pi * rig.frequency_hz;
  const int masses = 1 + static_cast<int>(rng() % 3);
  rig.chain.boundary = rng() % 2 == 0 ? Boundary::free : Boundary::clamped;
  for (int k = 0; k < masses; ++k) rig.chain.masses.push_back(2.0 + 10.0 * part(rng));
  for (int e = 0; e < rig.chain.element_count(); ++e) {
    rig.chain.stiffness.push_back(10.0 * (1.0 + 3.0 * part(rng)) * omega * omega);
    rig.chain.damping.push_back((0.05 + 0.2 * part(rng)) * rig.chain.stiffness.back() / omega);
  }
  return rig;
}

StreamBuilder::StreamBuilder(const SimulatedRig& rig, const Drive& drive, std::uint64_t seed)
    : rig_(rig), motion_(rig.chain, drive, DrivenChain::Start::rest), rng_(seed) {
  const std::size_t channels = rig.chain.masses.size() + (rig.chain.boundary == Boundary::clamped ? 2 : 1);
  lost_.resize(channels);
  gap_.resize(channels);
  add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::armed));
}

std::int64_t StreamBuilder::now_ns() const { return kBorn_ns + std::llround(1e9 * now_s_); }

void StreamBuilder::run_to(double t_s) {
  while (static_cast<double>(scans_) / rig_.rate_hz < t_s) {
    const double scan_s = static_cast<double>(scans_) / rig_.rate_hz;
    while (std::floor(scan_s * 100.0) > std::floor(now_s_ * 100.0 + 1e-6)) {
      now_s_ = (std::floor(now_s_ * 100.0 + 1e-6) + 1.0) / 100.0;
      add(Kind::tick, 0, 0);
    }
    now_s_ = scan_s;
    scan();
  }
}

void StreamBuilder::scan() {
  ++scans_;
  std::normal_distribution<double> normal;
  const ChainMotion& now = motion_.at(now_s_);
  const std::size_t masses = rig_.chain.masses.size();
  for (std::size_t c = 0; c < lost_.size(); ++c) {
    const double noise = rig_.noise * normal(rng_);
    const double value =
        c <= masses ? 1e3 * (now.y[c] + noise) : now.ground_force + rig_.chain.stiffness.back() * noise;
    if (lost_[c]) continue;
    const std::int64_t late_ns = static_cast<std::int64_t>(rng_() % 200'000);
    records_.push_back({.t_ns = now_ns(),
                        .stamped_ns = now_ns() + late_ns,
                        .value = value,
                        .t_half_ns = 500,
                        .channel = static_cast<std::uint16_t>(c),
                        .kind = Kind::sample,
                        .flags = gap_[c] ? kGap : std::uint8_t{0}});
    gap_[c] = false;
  }
}

void StreamBuilder::add(Kind kind, std::uint16_t channel, std::uint8_t flags, double value) {
  records_.push_back({.t_ns = now_ns(), .value = value, .channel = channel, .kind = kind, .flags = flags});
}

void StreamBuilder::lose(std::uint16_t channel) {
  lost_[channel] = gap_[channel] = true;
  add(Kind::channel_state, channel, static_cast<std::uint8_t>(Fault::timeout));
}

void StreamBuilder::find(std::uint16_t channel) {
  lost_[channel] = false;
  add(Kind::channel_state, channel, static_cast<std::uint8_t>(Fault::none));
  add(Kind::loss, channel, static_cast<std::uint8_t>(Loss::refused), 17.0);
}

std::vector<Record> StreamBuilder::end() {
  add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::ends));
  return records_;
}

std::vector<Record> eventful_stream(const SimulatedRig& rig, std::mt19937_64& rng) {
  std::uniform_real_distribution<double> part(0.0, 1.0);
  const auto chance = [&](double p) { return part(rng) < p; };
  const Drive first{.frequency_hz = rig.frequency_hz, .amplitude = 2e-3, .ramp_s = 0.3};
  StreamBuilder stream(rig, {.frequency_hz = rig.frequency_hz}, rng());
  if (chance(0.5)) stream.add(Kind::edge, static_cast<std::uint16_t>(Line::interlock), 0, 1.0);
  double t_s = 1.0 + part(rng);
  const auto go_on = [&](double seconds) { stream.run_to(t_s += seconds); };
  stream.run_to(t_s);
  stream.set_drive(first);
  if (chance(0.5)) stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::armed));
  go_on(1.0 + part(rng));
  stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::begins));
  go_on(8.0 + 6.0 * part(rng));
  if (chance(0.5)) {
    stream.add(Kind::action, 0, static_cast<std::uint8_t>(Action::rearm));
    go_on(6.0);
  }
  if (chance(0.5)) {
    const auto channel = static_cast<std::uint16_t>(rng() % (rig.chain.masses.size() + 1));
    stream.lose(channel);
    go_on(3.0 * part(rng));
    stream.add(Kind::fault, 0, static_cast<std::uint8_t>(Fault::timeout), 3.0);
    stream.find(channel);
    go_on(4.0);
  }
  if (chance(0.4)) {
    stream.add(Kind::edge, static_cast<std::uint16_t>(Line::interlock), 0, 0.0);
    go_on(1.0 + part(rng));
    stream.add(Kind::edge, static_cast<std::uint16_t>(Line::interlock), 0, 1.0);
    go_on(6.0);
  }
  Drive second = first;
  second.amplitude *= chance(0.3) ? 0.0 : 0.5 + part(rng);
  second.frequency_hz *= 0.95 + 0.1 * part(rng);
  stream.set_drive(second);
  go_on(8.0 + 4.0 * part(rng));
  return stream.end();
}

WrittenRun write_run(const std::string& path, const std::string& rig_text, const std::vector<Record>& stream,
                     const Changes& changes) {
  const auto file = config::parse(rig_text, "rig.toml", {});
  if (!file) throw std::runtime_error(config::to_string("rig.toml", file.error()));
  const auto key = must(record::SigningKey::make("bench"));
  WrittenRun run;
  run.header.run = 7;
  run.header.id = "00112233445566778899aabbccddeeff";
  run.header.begun_by = "drive";
  run.header.start_utc = "2026-11-23T03:12:17.250000Z";
  run.header.vkey = key.public_key().vkey();
  run.header.rig = {"rig.toml", file->sha256, rig_text};
  for (const Channel& channel : file->rig.channels) run.header.channels.push_back(channel.name);
  run.header.origin = record::this_origin();
  const RunInfo info{file->sha256, run.header.origin.version, run.header.start_utc};
  if (changes.header) changes.header(run.header);

  auto writer = must(record::ChainWriter::create(path, record::ChainSort::run, "dwell/run/" + run.header.id, key));
  must(writer.append("run", stream.front().t_ns, to_json(run.header)));
  std::vector<record::StoredResult> results;
  std::vector<record::StoredEvent> states;
  std::uint64_t position = 0;
  const auto store = [&](bool final, const Dwell& dwell) {
    record::StoredResult result{position, final, to_json(dwell, file->rig, info)};
    if (changes.result && !changes.result(result)) return;
    ++(final ? run.finals : run.results);
    if (final && !dwell.elements.empty()) ++run.settled;
    results.push_back(std::move(result));
  };
  const auto work = std::make_shared<LongWork>(file->rig, file->verification.accuracy);
  ModelWork model(work);
  std::vector<record::StoredModel> models;
  Measurement measurement(file->rig, KeptDwells(1, 1'000'000), [&](RunEvent event) {
    if (event.kind == RunEvent::Kind::dwell_finished) {
      model.ended(*event.dwell, position);
      return store(true, *event.dwell);
    }
    record::StoredEvent change;
    change.position = position;
    change.what = "state";
    change.text = state_line(event.before, *event.dwell);
    run.states.push_back(position);
    if (changes.state_event && !changes.state_event(change)) return;
    states.push_back(std::move(change));
  });
  std::vector<Record> block;
  const auto cut = [&] {
    must(writer.append("stream", block.back().t_ns, record::encode_block(block)));
    for (const record::StoredResult& result : results)
      must(writer.append("result", block.back().t_ns, to_json(result)));
    for (const record::StoredModel& one : models) must(writer.append(one.kind, block.back().t_ns, to_json(one)));
    for (const record::StoredEvent& state : states) must(writer.append("event", block.back().t_ns, to_json(state)));
    if (changes.commits) must(writer.commit());
    block.clear();
    results.clear();
    models.clear();
    states.clear();
  };
  std::optional<std::int64_t> origin_ns;
  // A turn of the service, in which the jobs that it gives are done at once.
  const auto turn = [&] {
    model.gather(measurement.readings(), *origin_ns);
    model.turn(measurement.current(), measurement.current_at(), measurement.pipeline());
    while (work->estimate() || work->verify()) {
    }
    const auto news = model.take_news();
    if (!news) return;
    record::StoredModel stored = stored_model(*news, file->rig);
    stored.position = position;
    stored.utc = run.header.start_utc;
    if (!changes.model(stored)) return;
    ++(stored.kind == "estimate" ? run.estimates : run.verifications);
    models.push_back(std::move(stored));
  };
  std::int64_t publish_ns = stream.front().t_ns;
  std::uint64_t samples = 0;
  for (const Record& record : stream) {
    ++position;
    samples += record.kind == Kind::sample ? 1 : 0;
    if (!block.empty() && record.t_ns - block.front().t_ns >= 1'000'000'000) cut();
    block.push_back(record);
    if (concerns_pipeline(record.kind)) {
      if (!origin_ns) origin_ns = record.t_ns;
      model.take(record, record.t_ns - *origin_ns, position);
    }
    measurement.take(record);
    const bool ends = is_edge(record, RunEdge::ends);
    if (ends) measurement.finish();
    if (!ends && record.t_ns >= publish_ns && measurement.readings() == nullptr) ++run.busy;
    if (!ends && record.t_ns >= publish_ns && measurement.readings() != nullptr) {
      publish_ns = record.t_ns + std::llround(1e9 * changes.every_s);
      store(false, measurement.current());
      if (changes.model && origin_ns) turn();
    }
  }
  cut();
  must(writer.commit());
  if (!changes.without_end) {
    must(writer.append("end", stream.back().t_ns, to_json(record::RunEnd{"operator", position, samples, ""})));
    must(writer.close());
  }
  return run;
}

}  // namespace dwell::test
