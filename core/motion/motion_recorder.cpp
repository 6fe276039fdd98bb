#include "core/motion/motion_recorder.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {

MotionRecorder::MotionRecorder(const Rig& rig) {
  for (const Channel& channel : rig.channels)
    lines_.push_back({DeviceNumbers(channel), to_ns(channel.delay_s + device_delay_s(rig, channel)),
                      channel.measures != Quantity::auxiliary});
}

void MotionRecorder::take(const Record& record) {
  if (record.kind != Kind::sample || record.channel >= lines_.size()) return;
  const Line& line = lines_[record.channel];
  if (!line.counts || !std::isfinite(record.value) || line.numbers.beyond_range(record.value)) return;
  readings_.push_back({record.t_ns - line.delay_ns, record.channel, line.numbers.si(record.value)});
}

MotionData MotionRecorder::data() const {
  MotionData out{readings_, {}};
  std::stable_sort(out.readings.begin(), out.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  return out;
}

}  // namespace dwell
