#include "core/motion/motion_recorder.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"
#include "core/motion/table_activity.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {

bool MotionRecorder::Outline::take(const MotionReading& reading, std::int64_t half_period_ns) {
  const bool next = !open_ || reading.t_ns >= from_ns_ + half_period_ns;
  if (next) from_ns_ = reading.t_ns;
  if (next || empty_) {
    first_ = low_ = high_ = reading;
  } else if (reading.value < low_.value) {
    low_ = reading;
  } else if (reading.value > high_.value) {
    high_ = reading;
  }
  open_ = true;
  empty_ = false;
  return next;
}

void MotionRecorder::Outline::follow(const Outline& other) {
  *this = other;
  empty_ = true;
}

void MotionRecorder::Outline::add_to(std::vector<MotionReading>& out) const {
  if (empty_) return;
  out.push_back(first_);
  if (low_.t_ns != first_.t_ns) out.push_back(low_);
  if (high_.t_ns != first_.t_ns && high_.t_ns != low_.t_ns) out.push_back(high_);
}

MotionRecorder::MotionRecorder(const Rig& rig, std::size_t whole) : most_(whole) {
  for (const Channel& channel : rig.channels)
    lines_.push_back({DeviceNumbers(channel), to_ns(channel.delay_s + device_delay_s(rig, channel)),
                      channel.measures != Quantity::auxiliary});
  for (const Line& line : lines_) {
    least_delay_ns_ = std::min(least_delay_ns_, line.delay_ns);
    most_delay_ns_ = std::max(most_delay_ns_, line.delay_ns);
  }
  table_ = activity_channel(rig);
  if (table_ < 0) return;
  half_period_ns_ = half_period_ns(rig);
  before_ns_ = 2 * half_period_ns_;
  still_ = least_amplitude(rig, table_);
}

void MotionRecorder::take(const Record& record) {
  if (record.kind != Kind::sample || record.channel >= lines_.size()) return;
  const Line& line = lines_[record.channel];
  if (!line.counts || !std::isfinite(record.value) || line.numbers.beyond_range(record.value)) return;
  const MotionReading reading{record.t_ns - line.delay_ns, record.channel, line.numbers.si(record.value),
                              record.t_half_ns};
  const bool of_table = record.channel == table_;
  if (full_) {
    if (of_table) outline(tail_, reading);
    return;
  }
  if (of_table) {
    now_.take(reading, half_period_ns_);
    moved_ = moved_ || now_.amplitude() > still_;
  }
  whole_.push_back(reading);
  if (whole_.size() >= most_) make_room(record.t_ns);
}

void MotionRecorder::outline(Outline& of, const MotionReading& reading) {
  const Outline before = of;
  if (of.take(reading, half_period_ns_) && outlined_.size() < 3 * kBlocks) before.add_to(outlined_);
}

// Before the motion begins: only the readings that an estimate takes from before its start stay whole. Once it has
// begun: whatever comes later is not kept whole.
void MotionRecorder::make_room(std::int64_t now_ns) {
  if (table_ >= 0 && !moved_) {
    const std::int64_t from_ns = now_ns - 2 * before_ns_ - (most_delay_ns_ - least_delay_ns_) - most_delay_ns_;
    std::size_t kept = 0;
    for (const MotionReading& reading : whole_) {
      if (reading.t_ns >= from_ns)
        whole_[kept++] = reading;
      else if (reading.channel == table_)
        outline(front_, reading);
    }
    whole_.resize(kept);
    whole_from_ns_ = from_ns;
  }
  if (whole_.size() < most_ - most_ / 4) return;
  full_ = true;
  whole_to_ns_ = now_ns - most_delay_ns_;
  tail_.follow(now_);
}

MotionData MotionRecorder::data() const {
  MotionData out;
  out.readings.reserve(whole_.size() + outlined_.size() + 6);
  out.readings = outlined_;
  front_.add_to(out.readings);
  tail_.add_to(out.readings);
  out.readings.insert(out.readings.end(), whole_.begin(), whole_.end());
  std::stable_sort(out.readings.begin(), out.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  out.whole_from_ns = whole_from_ns_;
  out.whole_to_ns = whole_to_ns_;
  return out;
}

}  // namespace dwell
