// What the record of a second of 64 channels at 10 kHz costs: its blocks, its run file and, as a yardstick, zstd, write
// and fdatasync of the records as they lie in memory. The argument: Instants.
#include <benchmark/benchmark.h>
#include <fcntl.h>
#include <unistd.h>
#include <zstd.h>

#include <string>

#include "daemon/clock.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/record/noisy_signals.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

const std::vector<Record>& second_of(const benchmark::State& state) {
  static const std::vector<Record> kSignals[] = {noisy_signals(Instants::shared), noisy_signals(Instants::recovered),
                                                 noisy_signals(Instants::irregular)};
  return kSignals[static_cast<std::size_t>(state.range(0))];
}

void count(benchmark::State& state, std::size_t records, std::size_t bytes) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(records));
  state.counters["bytes_a_sample"] = static_cast<double>(bytes) / static_cast<double>(records);
}

void block(benchmark::State& state) {
  const std::vector<Record>& records = second_of(state);
  std::string bytes;
  for (auto _ : state) bytes = encode_block(records);
  count(state, records.size(), bytes.size());
}
BENCHMARK(block)->DenseRange(0, 2);

void raw_zstd(benchmark::State& state) {
  const std::vector<Record>& records = second_of(state);
  std::string bytes(ZSTD_compressBound(records.size() * sizeof(Record)), '\0');
  std::size_t size = 0;
  for (auto _ : state)
    size = ZSTD_compress(bytes.data(), bytes.size(), records.data(), records.size() * sizeof(Record), 1);
  count(state, records.size(), size);
}
BENCHMARK(raw_zstd)->DenseRange(0, 2);

constexpr int kSeconds = 5;  // of the stream, each committed or synchronized by itself

// What a second of the stream took: CPU of this thread, and in all, which is mostly the disk.
class Stopwatch {
 public:
  void show(benchmark::State& state) const {
    state.counters["cpu_s"] = share(CLOCK_THREAD_CPUTIME_ID, cpu_ns_);
    state.counters["all_s"] = share(CLOCK_MONOTONIC, all_ns_);
  }

 private:
  static double share(clockid_t clock, std::int64_t since_ns) {
    return 1e-9 * static_cast<double>(read_clock_ns(clock) - since_ns) / kSeconds;
  }
  std::int64_t cpu_ns_ = read_clock_ns(CLOCK_THREAD_CPUTIME_ID), all_ns_ = read_clock_ns(CLOCK_MONOTONIC);
};

Result<ChainWriter> begun_run(const std::string& path) {
  auto writer = ChainWriter::create(path, ChainSort::run, "dwell/run/bench", *SigningKey::make("bench"));
  if (!writer) return writer;
  const auto begun = writer->append("run", 0, to_json(RunHeader{})).and_then([&] { return writer->commit(); });
  if (!begun) return tl::unexpected(begun.error());
  return writer;
}

Result<void> write_stream(ChainWriter& writer, const std::vector<Record>& records) {
  for (int k = 0; k < kSeconds; ++k) {
    auto written =
        writer.append("stream", records.back().t_ns, encode_block(records)).and_then([&] { return writer.commit(); });
    if (!written) return written;
  }
  return {};
}

void run_file(benchmark::State& state) {
  const std::vector<Record>& records = second_of(state);
  for (auto _ : state) {
    const Scratch scratch;
    auto writer = begun_run(scratch.path("run.dwell"));
    if (!writer) return state.SkipWithError(writer.error().c_str());
    const Stopwatch watch;
    const auto written = write_stream(*writer, records);
    watch.show(state);
    if (!written) return state.SkipWithError(written.error().c_str());
  }
}
BENCHMARK(run_file)->Arg(2)->Iterations(1);

void raw_file(benchmark::State& state) {
  const std::vector<Record> records = noisy_signals(Instants::irregular);
  const std::size_t size = records.size() * sizeof(Record);
  const Scratch scratch;
  const int file = ::open(scratch.path("raw").c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600);
  for (auto _ : state) {
    const Stopwatch watch;
    std::int64_t sync_ns = 0;
    for (int k = 0; k < kSeconds; ++k) {
      const bool written = ::write(file, records.data(), size) == static_cast<ssize_t>(size);
      const std::int64_t from_ns = read_clock_ns(CLOCK_MONOTONIC);
      if (!written || ::fdatasync(file) != 0) state.SkipWithError("cannot write");
      sync_ns += read_clock_ns(CLOCK_MONOTONIC) - from_ns;
    }
    watch.show(state);
    state.counters["sync_s"] = 1e-9 * static_cast<double>(sync_ns) / kSeconds;
  }
  ::close(file);
}
BENCHMARK(raw_file)->Iterations(1);

void run_reading(benchmark::State& state) {
  const Scratch scratch;
  auto writer = begun_run(scratch.path("run.dwell"));
  if (!writer || !write_stream(*writer, second_of(state)) || !writer->close())
    return state.SkipWithError("cannot write a run file");
  std::int64_t samples = 0;
  for (auto _ : state) {
    auto run = RunReader::open(scratch.path("run.dwell"));
    if (!run || !run->stream([&](const Record& record) { return samples += record.kind == Kind::sample, true; }))
      return state.SkipWithError("cannot read the run file");
  }
  state.SetItemsProcessed(samples);
}
BENCHMARK(run_reading)->Arg(2);

}  // namespace
}  // namespace dwell::record
