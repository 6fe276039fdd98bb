#include "tests/record/sample_run.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <stdexcept>

#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kBegin_ns = 5'000'000'000'000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr int kSeconds = 20;

template <class T>
T sure(Result<T> result) {
  if (!result) throw std::runtime_error(result.error());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

Record other(Kind kind, std::int64_t t_ns, std::uint16_t channel, std::uint8_t flags, double value) {
  Record record;
  record.kind = kind;
  record.t_ns = t_ns;
  record.channel = channel;
  record.flags = flags;
  record.value = value;
  return record;
}

std::vector<Record> sample_stream() {
  std::mt19937_64 random(12);
  std::normal_distribution<double> noise(0.0, 3.0);
  std::vector<Record> stream{
      other(Kind::run, kBegin_ns, 0, static_cast<std::uint8_t>(RunEdge::armed), 0.0),
      other(Kind::run, kBegin_ns, 0, static_cast<std::uint8_t>(RunEdge::begins), 1.0),
  };
  for (int i = 0; i < 100 * kSeconds; ++i) {
    const std::int64_t t_ns = kBegin_ns + i * (kSecond_ns / 100) + static_cast<std::int64_t>(random() % 20'000);
    for (std::uint16_t channel = 0; channel < 2; ++channel) {
      Record sample;
      sample.t_ns = t_ns;
      sample.stamped_ns = t_ns + static_cast<std::int64_t>(random() % 1000);
      sample.t_half_ns = 50'000;
      sample.channel = channel;
      const double value = 8000.0 * std::sin(2.0 * std::numbers::pi * 0.04 * i + channel) + noise(random);
      sample.value = channel == 0 ? std::round(value) : value;  // a register, and a number of its own
      sample.flags = i == 700 ? kGap : 0;
      stream.push_back(sample);
    }
    stream.push_back(other(Kind::tick, t_ns, 0, 0, 0.0));
    if (i == 700) stream.push_back(other(Kind::loss, t_ns, 1, static_cast<std::uint8_t>(Loss::late), 3.0));
    if (i == 900) stream.push_back(other(Kind::fault, t_ns, 0, static_cast<std::uint8_t>(Fault::timeout), 2.0));
  }
  const std::int64_t end_ns = kBegin_ns + kSeconds * kSecond_ns;
  stream.push_back(other(Kind::run, end_ns, 0, static_cast<std::uint8_t>(RunEdge::ends), 0.0));
  return stream;
}

RunEnd end_of(const SampleRun& run) {
  RunEnd end;
  end.why = "operator";
  end.records = run.stream.size();
  for (const Record& record : run.stream) end.samples += record.kind == Kind::sample ? 1 : 0;
  end.utc = "2026-07-01T10:12:20Z";
  return end;
}

}  // namespace

SigningKey sample_key(const std::string& name) { return sure(SigningKey::make(name)); }

SampleRun sample_run_file(const std::string& path, const SigningKey& key, const std::string& dwell) {
  SampleRun run;
  run.path = path;
  RunHeader& header = run.header;
  header.run = 17;
  header.id = "0123456789abcdef0123456789abcdef";
  header.label = "mount A, 4 Hz";
  header.begun_by = "operator";
  header.person = Person{1000, "anna"};
  header.comment = "after the new bearing";
  header.start_utc = "2026-07-01T10:12:00Z";
  header.vkey = key.public_key().vkey();
  header.rig.path = "rig.toml";
  header.rig.sha256 = std::string(64, 'a');
  header.rig.text = "# the rig file";
  header.plugins = {{"modbus", "0.9.0"}};
  header.channels = {"y0", "reaction"};
  header.origin.version = "0.9.0";
  header.origin.build = "GCC 12.2.0, -O3, Eigen 3.4.0, glibc 2.36";
  header.origin.cpu = "avx avx2 fma";
  header.origin.host = "bench2";
  header.origin.time_zone = "Europe/Berlin";
  header.origin.clock_synchronized = true;
  header.origin.clock_error_s = 4e-4;
  run.stream = sample_stream();
  run.results = {{run.stream.size() - 1, true, dwell}};
  StoredEvent state{1, "2026-07-01T10:12:00.500000Z", "state", "settling: the drive is there", {}, "", "", ""};
  StoredEvent loss{2102, "2026-07-01T10:12:07.000000Z", "loss", "3 samples of reaction came too late", {}, "", "", ""};
  StoredEvent action{2500, "2026-07-01T10:12:08.000000Z", "action", "rearm", Person{1000, "anna"}, "", "", "knocked"};
  run.events = {state, loss, action};
  return run;
}

void write(const SampleRun& run, const SigningKey& key) {
  ChainWriter writer = sure(ChainWriter::create(run.path, ChainSort::run, "dwell/run/" + run.header.id, key));
  sure(writer.append("run", run.stream.front().t_ns, to_json(run.header)));
  const std::span<const Record> stream(run.stream);
  for (std::size_t from = 0; from < stream.size();) {
    std::size_t to = from;
    while (to < stream.size() && stream[to].t_ns < stream[from].t_ns + kSecond_ns) ++to;
    sure(writer.append("stream", stream[to - 1].t_ns, encode_block(stream.subspan(from, to - from))));
    sure(writer.commit());
    from = to;
  }
  const std::int64_t end_ns = run.stream.back().t_ns;
  for (const StoredEvent& event : run.events) sure(writer.append("event", end_ns, to_json(event)));
  for (const StoredModel& model : run.models) sure(writer.append(model.kind, end_ns, to_json(model)));
  for (const StoredResult& result : run.results) sure(writer.append("result", end_ns, to_json(result)));
  if (!run.closed) return sure(writer.commit());
  sure(writer.append("end", end_ns, to_json(end_of(run))));
  sure(writer.close());
}

}  // namespace dwell::record
