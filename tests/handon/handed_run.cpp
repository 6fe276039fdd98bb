#include "tests/handon/handed_run.hpp"

#include <sys/wait.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <random>
#include <stdexcept>

#include "config/rig_file.hpp"
#include "core/dwell/pipeline.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell::test {
namespace {

constexpr std::int64_t kBorn_ns = 4'000'000'000'123;  // the computer has been on for an hour
constexpr double kOmega = 2.0 * std::numbers::pi * kDrive_hz;

constexpr const char* kRig = R"([rig]
name = "mount <1>"
boundary = "clamped"
masses = []
[excitation]
frequency = 4.0
minimum = 2e-5
[[channel]]
name = "y0"
measures = "displacement"
at = 0
unit = "mm"
scale = 0.1
offset = -3.0
scale_u = 0.0005
calibration = { id = "K-2231", due = 2027-03-31 }
[[channel]]
name = "reaction"
measures = "force"
at = "ground"
unit = "N"
scale = 0.25
scale_u = 0.001
calibration = { id = "K-<7>", due = 2025-01-31 }
[[channel]]
name = "oil/temp °C"
measures = "auxiliary"
unit = "°C"
)";

template <class T, class Error>
T must(tl::expected<T, Error> result) {
  if (!result) throw std::runtime_error(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

std::vector<Record> simulate(const HandedRun& run) {
  std::mt19937_64 rng(20261123);
  std::uniform_real_distribution<double> off(-run.jitter, run.jitter);
  std::normal_distribution<double> normal(0.0, run.noise);
  std::vector<Record> stream{{.t_ns = kBorn_ns, .kind = Kind::run, .flags = static_cast<std::uint8_t>(RunEdge::armed)}};
  stream.push_back({.t_ns = kBorn_ns, .kind = Kind::tick});
  const auto scans = std::llround(run.length_s * run.rate_hz);
  for (std::int64_t i = 1; i < scans; ++i) {
    const std::int64_t t_ns = kBorn_ns + std::llround(1e9 * (static_cast<double>(i) + off(rng)) / run.rate_hz);
    const double t_s = static_cast<double>(t_ns - kBorn_ns) * 1e-9;
    const auto sample = [&](std::uint16_t channel, double raw) {
      stream.push_back({.t_ns = t_ns, .stamped_ns = t_ns + 40'000, .value = raw, .t_half_ns = 500, .channel = channel});
    };
    if (t_s < run.gap_from_s || t_s >= run.gap_to_s)
      sample(0, (1e3 * (true_table_m(t_s) + kAmplitude_m * normal(rng)) + 3.0) / 0.1);
    sample(1, (true_reaction_N(t_s) + kStiffness * kAmplitude_m * normal(rng)) / 0.25);
    if (i % 50 == 0) sample(2, 41.0 + 0.01 * t_s);
  }
  const std::int64_t end_ns = stream.back().t_ns;
  stream.push_back({.t_ns = end_ns,
                    .value = 17.0,
                    .channel = 1,
                    .kind = Kind::loss,
                    .flags = static_cast<std::uint8_t>(Loss::refused)});
  stream.push_back({.t_ns = end_ns, .kind = Kind::run, .flags = static_cast<std::uint8_t>(RunEdge::ends)});
  return stream;
}

record::RunHeader header_of(const HandedRun& run, const config::RigFile& file, const record::SigningKey& key) {
  record::RunHeader header;
  header.run = 7;
  header.id = "00112233445566778899aabbccddeeff";
  header.label = run.label;
  header.begun_by = "operator";
  header.person = record::Person{1000, "o'brien"};
  header.comment = "after the <i>service</i>";
  header.start_utc = "2026-11-23T03:12:17.250000Z";
  header.vkey = key.public_key().vkey();
  header.rig = {"rig.toml", file.sha256, kRig};
  for (const Channel& channel : file.rig.channels) header.channels.push_back(channel.name);
  header.plugins = {{"modbus", "0.1.0"}};
  header.files = run.files;
  header.origin = record::this_origin();
  return header;
}

}  // namespace

double true_table_m(double t_s) { return kAmplitude_m * std::sin(kOmega * t_s); }
double true_reaction_N(double t_s) {
  return kAmplitude_m * (kStiffness * std::sin(kOmega * t_s) + kOmega * kDamping * std::cos(kOmega * t_s));
}

void write(HandedRun& run, const std::string& path) {
  const auto file = config::parse(kRig, "rig.toml", {});
  if (!file) throw std::runtime_error(config::to_string("rig.toml", file.error()));
  const auto key = must(record::SigningKey::make("bench"));
  const record::RunHeader header = header_of(run, *file, key);
  run.path = path;
  run.stream = simulate(run);
  auto writer = must(record::ChainWriter::create(path, record::ChainSort::run, "dwell/run/" + header.id, key));
  must(writer.append("run", run.stream.front().t_ns, to_json(header)));
  Pipeline pipeline(file->rig);
  const RunInfo info{file->sha256, "0.1.0", header.start_utc};
  std::uint64_t position = 0, samples = 0;
  std::vector<Record> block;
  const auto store = [&](const Dwell& dwell) {
    run.dwells.push_back(dwell);
    const record::StoredResult result{position, true, to_json(dwell, file->rig, info)};
    must(writer.append("result", block.empty() ? run.stream.back().t_ns : block.back().t_ns, to_json(result)));
  };
  const auto cut = [&] {
    if (!block.empty()) must(writer.append("stream", block.back().t_ns, record::encode_block(block)));
    block.clear();
  };
  for (const Record& record : run.stream) {
    ++position;
    samples += record.kind == Kind::sample ? 1 : 0;
    if (!block.empty() && record.t_ns - block.front().t_ns >= 1'000'000'000) cut();
    block.push_back(record);
    if ((pipeline.push(record) & kCompleted) != 0) store(pipeline.completed());
  }
  cut();
  if ((pipeline.finish() & kCompleted) != 0) store(pipeline.completed());
  for (const record::StoredEvent& event : run.events)
    must(writer.append("event", run.stream.back().t_ns, to_json(event)));
  for (const record::StoredModel& model : run.models)
    must(writer.append(model.kind, run.stream.back().t_ns, to_json(model)));
  must(writer.commit());
  if (!run.closed) return;
  must(writer.append("end", run.stream.back().t_ns,
                     to_json(record::RunEnd{"operator", position, samples, "2026-11-23T03:12:29Z"})));
  must(writer.close());
}

handon::Selection select(const HandedRun& run, const handon::Range& range) {
  return must(handon::Selection::open(run.path, range));
}

handon::Provenance provenance() { return {"dwellctl 0.1.0", "2026-11-24T08:00:00Z", "ab12", "intact, key none"}; }

void dump_samples(const HandedRun& run, const std::string& path) {
  std::ofstream file(path);
  for (const Record& r : run.stream)
    if (r.kind == Kind::sample)
      file << r.channel << ' ' << r.t_ns - kBorn_ns << ' ' << std::bit_cast<std::int64_t>(r.value) << ' '
           << static_cast<int>(r.flags) << ' ' << r.t_half_ns << '\n';
}

int python(const std::string& script, const std::vector<std::string>& arguments) {
  std::string command = DWELL_PYTHON " " DWELL_SOURCE "/tests/handon/" + script;
  for (const std::string& argument : arguments) command += " '" + argument + "'";
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace dwell::test
