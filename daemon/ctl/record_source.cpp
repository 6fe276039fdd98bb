#include "daemon/ctl/record_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/stream/assembler.hpp"
#include "core/stream/record.hpp"
#include "daemon/ctl/identify.hpp"

namespace dwell::ctl {
namespace {

// A recording's samples in the order in which the pipeline takes them. If a device has a clock of its own, its samples
// get the recovered instants, and all are merged anew.
class Stream {
 public:
  explicit Stream(const Rig& rig) : rig_(rig) {
    const auto own_clock = [](const Device& device) { return device.clock == Clock::device; };
    if (std::none_of(rig.devices.begin(), rig.devices.end(), own_clock)) return;
    std::vector<Assembler::Source> sources = Assembler::sources(rig);
    sources.emplace_back();  // of the channels without a device
    for (std::size_t i = 0; i < rig.channels.size(); ++i)
      if (rig.channels[i].device < 0) sources.back().channels.push_back(static_cast<std::uint16_t>(i));
    devices_ = sources.size();
    assembler_.emplace(sources, ScanClocks::kHoldBack_ns, kMerged);
  }

  template <class Take>
  void push(const Record& record, const Take& take) {
    if (!assembler_) {
      take(record);
      return;
    }
    for (std::size_t i = 0; i < devices_; ++i) assembler_->wait(i, record.t_ns, kUnmarked, kIgnoreAdmission);
    const int device = rig_.channels[record.channel].device;
    assembler_->sample(device < 0 ? devices_ - 1 : static_cast<std::size_t>(device), record, kUnmarked,
                       kIgnoreAdmission);
    for (Record out; assembler_->next(out);) take(out);
  }
  template <class Take>
  void finish(const Take& take) {
    if (!assembler_) return;
    for (std::size_t i = 0; i < devices_; ++i) assembler_->stopped(i, kUnmarked, kIgnoreAdmission);
    for (Record out; assembler_->flush(out);) take(out);
  }

 private:
  static constexpr std::size_t kMerged = 65536;  // samples of a device within the time held back
  static constexpr auto kUnmarked = [](Record&) {};
  static constexpr auto kIgnoreAdmission = [](const Record&, Merger::Admission) {};

  const Rig& rig_;
  std::size_t devices_ = 0;
  std::optional<Assembler> assembler_;  // none: all stamps stay as they are
};

}  // namespace

tl::expected<void, std::string> CsvSource::play(const Progress& progress, const Take& take) const {
  constexpr std::size_t progress_every = 1U << 14U;
  const ColumnMatch match = match_columns(rig_, recording_);
  Stream stream(rig_);
  std::size_t taken = 0;
  for (const CsvRecording::Sample& sample : recording_.samples) {
    if (progress && ++taken % progress_every == 0)
      progress(static_cast<double>(taken) / static_cast<double>(recording_.samples.size()));
    const int channel = match.channel_of_column[sample.column];
    if (channel < 0) continue;
    Record record;
    record.t_ns = std::llround(sample.t_s * 1e9);
    record.value = sample.value;
    record.channel = static_cast<std::uint16_t>(channel);
    stream.push(record, take);
  }
  stream.finish(take);
  if (progress) progress(1.0);
  return {};
}

}  // namespace dwell::ctl
