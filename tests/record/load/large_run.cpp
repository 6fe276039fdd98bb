// Makes a large run file quickly, to see what memory exports of it take: 64 channels at 10 kHz, each sample with an
// instant and a stamp of its own, values that do not compress.
//
// large_run FILE GIGABYTES
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {
namespace {

constexpr int kChannels = 64, kScans = 10'000;
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr const char* kId = "00112233445566778899aabbccddeeff";

std::string rig_text() {
  std::string text =
      "[rig]\nname = \"large\"\nboundary = \"clamped\"\nmasses = []\n[excitation]\nfrequency = 4.0\n"
      "[[channel]]\nname = \"y0\"\nmeasures = \"displacement\"\nat = 0\nunit = \"mm\"\n"
      "[[channel]]\nname = \"reaction\"\nmeasures = \"force\"\nat = \"ground\"\npositive = \"ground\"\nunit = \"N\"\n";
  for (int i = 2; i < kChannels; ++i)
    text += "[[channel]]\nname = \"a" + std::to_string(i) + "\"\nmeasures = \"auxiliary\"\nunit = \"V\"\n";
  return text;
}

RunHeader header_of(const SigningKey& key) {
  RunHeader header;
  header.run = 1;
  header.id = kId;
  header.begun_by = "operator";
  header.start_utc = "2026-11-23T03:12:17.250000Z";
  header.vkey = key.public_key().vkey();
  header.rig = {"rig.toml", std::string(64, '0'), rig_text()};
  header.channels = {"y0", "reaction"};
  for (int i = 2; i < kChannels; ++i) header.channels.push_back("a" + std::to_string(i));
  header.origin = this_origin();
  return header;
}

// A second of the stream; the next one is this moved on.
std::vector<Record> one_second() {
  std::mt19937_64 random(3);
  std::vector<Record> records;
  for (int scan = 0; scan < kScans; ++scan)
    for (int channel = 0; channel < kChannels; ++channel) {
      const std::int64_t t_ns =
          scan * (kSecond_ns / kScans) + channel * 1500 + static_cast<std::int64_t>(random() % 1000);
      records.push_back({.t_ns = t_ns,
                         .stamped_ns = t_ns + static_cast<std::int64_t>(random() % 1000),
                         .value = static_cast<double>(random()) * 0x1p-64 - 0.5,
                         .t_half_ns = 5000,
                         .channel = static_cast<std::uint16_t>(channel)});
    }
  return records;
}

Result<void> write_run(const std::string& path, double bytes) {
  const auto key = SigningKey::make("large");
  if (!key) return tl::unexpected(key.error());
  auto file = ChainWriter::create(path, ChainSort::run, std::string("dwell/run/") + kId, *key);
  if (!file) return tl::unexpected(file.error());
  Result<void> done = file->append("run", 0, to_json(header_of(*key)));
  std::vector<Record> records = one_second();
  std::uint64_t samples = 0;
  double written = 0.0;
  while (done && written < bytes) {
    const std::string block = encode_block(records);
    done = file->append("stream", records.back().t_ns, block).and_then([&] { return file->commit(); });
    written += static_cast<double>(block.size());
    samples += records.size();
    for (Record& record : records) {
      record.t_ns += kSecond_ns;
      record.stamped_ns += kSecond_ns;
    }
  }
  if (done) done = file->append("end", records.front().t_ns, to_json(RunEnd{"operator", samples, samples, ""}));
  if (done) done = file->close();
  std::printf("%llu samples\n", static_cast<unsigned long long>(samples));
  return done;
}

}  // namespace
}  // namespace dwell::record

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: large_run FILE GIGABYTES\n");
    return 2;
  }
  const auto done = dwell::record::write_run(argv[1], 1e9 * std::atof(argv[2]));
  if (!done) std::fprintf(stderr, "%s\n", done.error().c_str());
  return done ? 0 : 1;
}
