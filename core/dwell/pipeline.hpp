// The pipeline: the ordered stream in, dwells out. One object, no threads, no clock, no I/O; the same stream fed twice
// gives the same bits.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/slices.hpp"
#include "core/intake/channel_now.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "core/stream/sample_history.hpp"

namespace dwell {

// What a push brought about; a bit set.
enum Change : std::uint8_t {
  kNothing = 0,
  kStateChanged = 1,  // the state (idle, settling, measuring) is another than before
  kCompleted = 2,     // a dwell has ended: completed() is it
};

class Pipeline {
 public:
  static constexpr std::int64_t kLatest_ns = std::int64_t{1} << 61;  // 73 years: what is beyond is no instant

  // The rig must be valid (config::validate). Everything is allocated here. slices: in which push() works where it
  // takes long (PacedPipeline); null: in one. Must outlive this.
  explicit Pipeline(const Rig& rig, Slices* slices = nullptr);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  // Takes the next record of the ordered stream; t = 0 of all reported times is the first record that concerns it.
  // Returns a set of Change. Cost: O(1) per sample; at the end of a block (a quarter of a period) O(channels · H²),
  // while settling O(channels · (H² + windows seen)) and now and then the chain's eigenvalues, O(masses³), masses
  // <= 64. Each time that the hold has grown by a quarter to two times, its transient is fitted anew: at least four
  // passes over the samples that are held, (2H + 3 + 4 modes)²/2 multiplications each, 0.1 s where that is no more,
  // some seconds for sixteen full rings, in `slices` where there are any. No allocation, but once per completed dwell.
  std::uint8_t push(const Record& record) noexcept;

  // Whether push() may do more than take a sample in.
  [[nodiscard]] bool may_take_long(const Record& record) const noexcept;

  // The end of the run: completes the current dwell with `end`. Returns a set of Change.
  std::uint8_t finish();

  // The dwell as it stands: all phasors, coefficients, uncertainties. Allocates; meant for every Rig::update_s.
  [[nodiscard]] Dwell current() const;

  // The dwell that ended last; valid once push or finish has returned kCompleted.
  [[nodiscard]] const Dwell& completed() const noexcept;

  [[nodiscard]] State state() const noexcept;

  // The newest readings that count, on the stream's clock, SI: what a verification rests on. No allocation.
  [[nodiscard]] const SampleHistory& readings() const noexcept;

  // Amplitude and phase now, over the data that count (while settling: over the last period), SI in the channel's own
  // quantity with the transducer's response divided out, phase at the newest sample's instant. NaN: none. No
  // allocation.
  [[nodiscard]] std::complex<double> phasor(int channel) const noexcept;

  [[nodiscard]] ChannelNow channel(int channel) const noexcept;
  // The channel's condition in words, with figures; empty where it is ok or unheard. Allocates.
  [[nodiscard]] std::string condition_reason(int channel) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
