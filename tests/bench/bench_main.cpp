// Runs the benches, each ten times and in mixed order, and prints what the medians say beside the targets.
//
// Figures are CPU times of the thread concerned (the ring between two threads, the program that replays: real time). On
// a machine that has other things to do they spread; only the ratios between two of one run tell something. A bench is
// no test: the exit code is 0 whatever is missed. Takes the options of Google Benchmark; --benchmark_filter leaves rows
// empty.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace {

// Collects every counter of every repetition, prints nothing but errors.
class Medians : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs) {
      const auto& name = run.run_name;
      std::string bench = name.function_name;
      if (!name.args.empty()) bench.append("/").append(name.args);
      if (run.error_occurred) std::fprintf(stderr, "%s: %s\n", bench.c_str(), run.error_message.c_str());
      if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
      for (const auto& [counter, value] : run.counters) values_[{bench, counter}].push_back(value.value);
    }
  }

  // NaN: it was not run.
  [[nodiscard]] double of(const std::string& bench, const std::string& counter) {
    std::vector<double>& values = values_[{bench, counter}];
    if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
    std::sort(values.begin(), values.end());
    return 0.5 * (values[values.size() / 2] + values[(values.size() - 1) / 2]);
  }
  // ns per item
  [[nodiscard]] double cost_ns(const std::string& bench) { return 1e9 / of(bench, "items_per_second"); }

 private:
  std::map<std::pair<std::string, std::string>, std::vector<double>> values_;  // by bench and counter
};

std::string text(const char* format, double value) {
  if (std::isnan(value)) return "-";
  std::array<char, 64> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, value);
  return buffer.data();
}

class Table {
 public:
  Table() { line("figure", "measured", "ratio", "target", ""); }

  void plain(const char* figure, const std::string& measured, const std::string& ratio = "") const {
    line(figure, measured, ratio, "", "");
  }
  void at_most(const char* figure, const std::string& measured, double ratio, double target) const {
    judged(figure, measured, ratio, "<= " + text("%g", target), ratio <= target);
  }
  void at_least(const char* figure, const std::string& measured, double ratio, double target) const {
    judged(figure, measured, ratio, ">= " + text("%g", target), ratio >= target);
  }

 private:
  static void judged(const char* figure, const std::string& measured, double ratio, const std::string& target,
                     bool met) {
    const char* const verdict = std::isnan(ratio) ? "not run" : met ? "met" : "missed";
    line(figure, measured, text(ratio < 100 ? "%.2f" : "%.0f", ratio), target, verdict);
  }
  static void line(const char* figure, const std::string& measured, const std::string& ratio, const std::string& target,
                   const char* verdict) {
    std::printf("%-62s %18s %8s %8s  %s\n", figure, measured.c_str(), ratio.c_str(), target.c_str(), verdict);
  }
};

// The record of 64 channels at 10 kHz.
void print_record(Medians& medians, const Table& table) {
  const auto bytes = [&](const std::string& bench) { return medians.of(bench, "bytes_a_sample"); };
  const auto per_sample = [&](const std::string& instants, const char* figure, double target) {
    const std::string block = "block/" + instants, raw = "raw_zstd/" + instants;
    table.at_most(figure, text("%.2f bytes", bytes(block)), bytes(block), target);
    table.plain("... zstd level 1 of the 32 bytes / that", text("%.2f bytes", bytes(raw)),
                text("%.2f", bytes(raw) / bytes(block)));
    table.plain("... encoding a record / zstd of it", text("%.1f ns", medians.cost_ns(block)),
                text("%.2f", medians.cost_ns(block) / medians.cost_ns(raw)));
  };
  per_sample("0", "recorded sample, bytes, eight share instant and stamp", 4);
  per_sample("1", "recorded sample, bytes, own even instant, own stamp", 6);
  per_sample("2", "recorded sample, bytes, own irregular instant and stamp", 6);
  const auto share = [&](const char* bench, const char* counter) { return medians.of(bench, counter); };
  table.at_most("64 channels at 10 kHz into a run file, CPU, of one core",
                text("%.1f ms/s", 1e3 * share("run_file/2", "cpu_s")), share("run_file/2", "cpu_s"), 0.25);
  table.plain("... with the waits for the disk", text("%.1f ms/s", 1e3 * share("run_file/2", "all_s")));
  table.plain("write and fdatasync of the same as 32 bytes each, CPU",
              text("%.1f ms/s", 1e3 * share("raw_file", "cpu_s")));
  table.plain("... with the waits for the disk", text("%.1f ms/s", 1e3 * share("raw_file", "all_s")));
  table.plain("... of these fdatasync", text("%.1f ms/s", 1e3 * share("raw_file", "sync_s")));
  table.plain("reading a run file, samples", text("%.1f million/s", 1e-6 * share("run_reading/2", "items_per_second")));
}

void print(Medians& medians) {
  const double update_ns = 1e8;  // the default `update`, 0.1 s
  const double sincos_ns = medians.cost_ns("libm_sincos");
  const auto ns = [&](const char* bench) { return text("%.1f ns", medians.cost_ns(bench)); };
  const auto against_sincos = [&](const char* bench) { return medians.cost_ns(bench) / sincos_ns; };
  const auto millions = [&](const char* bench) {
    return text("%.1f million/s", 1e-6 * medians.of(bench, "items_per_second"));
  };
  const auto real_time = [&](const char* bench) { return medians.of(bench, "times_real_time"); };
  const auto seconds = [&](const char* bench) { return text("%.3f s", 600 / real_time(bench)); };

  const Table table;
  table.plain("one libm sincos", ns("libm_sincos"));
  const double least_ns = medians.cost_ns("least_work"), rls_ns = medians.cost_ns("eigen_rls"),
               numpy_ns = medians.of("numpy_lstsq", "ns"), fit_ns = medians.cost_ns("fit_own_instants");
  table.plain("sums of 3 harmonics, least possible work per sample", ns("least_work"));
  table.plain("fit per sample, own instants, H = 3 / least work", ns("fit_own_instants"),
              text("%.2f", fit_ns / least_ns));
  table.plain("recursive least squares in Eigen per sample / that fit", ns("eigen_rls"), text("%.2f", rls_ns / fit_ns));
  table.plain("numpy lstsq per sample / that fit", text("%.1f ns", numpy_ns), text("%.2f", numpy_ns / fit_ns));
  table.at_most("fit per sample, own instants, H = 3 / sincos", ns("fit_own_instants"),
                against_sincos("fit_own_instants"), 3);
  table.at_most("fit per channel, shared instant, H = 3 / sincos", ns("fit_shared_instant"),
                against_sincos("fit_shared_instant"), 1.2);
  table.at_most("merger and pipeline per sample, 8 channels / sincos", ns("pipeline"), against_sincos("pipeline"), 8);
  table.at_most("the same from the second minute on / sincos", ns("pipeline_later"), against_sincos("pipeline_later"),
                8);
  table.plain("the same where instants jitter by 0.05 ms / sincos", ns("pipeline_jitter"),
              text("%.2f", against_sincos("pipeline_jitter")));
  table.plain("clock of a device recovered, per sample, alone / sincos", ns("device_clock/1"),
              text("%.2f", against_sincos("device_clock/1")));
  table.plain("clock of a device recovered, per sample, 8 in a scan / sincos", ns("device_clock/8"),
              text("%.2f", against_sincos("device_clock/8")));
  const double first_over_later = medians.cost_ns("pipeline") / medians.cost_ns("pipeline_later");
  table.at_most("pipeline per sample, the first minute / later ones", ns("pipeline"), first_over_later, 1.3);
  for (const char* turn : {"64/1000", "16/10000"}) {
    const double longest = medians.of(std::string("longest_turn/") + turn, "longest_ms");
    table.at_most(
        turn[0] == '6' ? "longest turn in ms, 64 channels at 1 kHz" : "longest turn in ms, 16 channels at 10 kHz",
        text("%.1f ms", longest), longest, 5);
  }
  const double publish_ns = medians.cost_ns("publish");
  table.plain("publishing one result / the 0.1 s between two", text("%.1f us", 1e-3 * publish_ns),
              text("%.5f", publish_ns / update_ns));
  table.plain("identification per element, n = 1", ns("identification/1"));
  table.plain("identification per element, n = 10", ns("identification/10"));
  table.plain("identification per element, n = 100", ns("identification/100"));
  table.at_most("identification per element, n = 1000 / n = 10", ns("identification/1000"),
                medians.cost_ns("identification/1000") / medians.cost_ns("identification/10"), 1.5);
  table.plain("ring, push and take of a sample on one thread", ns("ring_one_thread"));
  table.plain("traces, a sample into the queue, on the estimation thread", ns("trace_feed"));
  table.plain("traces, a sample kept, on the event loop", ns("traces_take"));
  table.plain("traces, 10 s of 8 channels answered", ns("traces_answer_window"));
  table.plain("ring, from one thread to another, samples", millions("ring_two_threads"));
  table.plain("Modbus, bare libmodbus, polls per CPU second",
              text("%.0f /s", medians.of("modbus_polls", "bare_polls_per_s")));
  table.at_least("Modbus, plugin, polls per CPU second / bare libmodbus",
                 text("%.0f /s", medians.of("modbus_polls", "plugin_polls_per_s")), medians.of("modbus_polls", "ratio"),
                 0.95);
  table.at_least("CAN, signals per CPU second through the socket seam, millions",
                 text("%.2f million/s", 1e-6 * medians.of("can_signals", "signals_per_s")),
                 1e-6 * medians.of("can_signals", "signals_per_s"), 1);
  print_record(medians, table);
  table.plain("reading a recording, CSV, samples", millions("csv_parsing"));
  table.at_least("identify, 10 min of 8 channels at 1 kHz, one instant per row", seconds("identify_shared_instants"),
                 real_time("identify_shared_instants"), 1000);
  table.at_least("identify, the same, each sample its own instant", seconds("identify_own_instants"),
                 real_time("identify_own_instants"), 1000);
  table.at_least("replay, 10 min of 8 channels at 1 kHz, wall clock", seconds("replay_ten_minutes"),
                 real_time("replay_ten_minutes"), 1000);
  table.plain("... of it reading the file", seconds("reading_ten_minutes"));
  for (const char* rate : {"25", "200", "1000"}) {
    const std::string bench = std::string("audit_over_sha256sum/") + rate;
    const std::string figure =
        "audit / sha256sum, run of " + text("%.0f kB/s", 1e-3 * medians.of(bench, "recorded_bytes_per_s"));
    table.at_least(figure.c_str(), text("%.0f MB/s", 1e-6 * medians.of(bench, "bytes_per_s")),
                   medians.of(bench, "ratio"), 0.5);
  }
  table.at_least("virtual test, 10 min of 8 masses at 1 kHz, shared instants", seconds("virtual_test_shared_instants"),
                 real_time("virtual_test_shared_instants"), 3000);
  table.plain("virtual test, the same, each sample its own instant", seconds("virtual_test_own_instants"),
              text("%.0f", real_time("virtual_test_own_instants")));
}

}  // namespace

int main(int argc, char** argv) {
  // Before the caller's, so that those prevail.
  std::vector<std::string> defaults = {"--benchmark_repetitions=10", "--benchmark_enable_random_interleaving=true",
                                       "--benchmark_min_time=0.1"};
  std::vector<char*> arguments = {argv[0]};
  for (std::string& option : defaults) arguments.push_back(option.data());
  arguments.insert(arguments.end(), argv + 1, argv + argc);
  int count = static_cast<int>(arguments.size());
  arguments.push_back(nullptr);
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;

  Medians medians;
  benchmark::RunSpecifiedBenchmarks(&medians);
  print(medians);
  return 0;
}
