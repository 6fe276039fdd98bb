// The pipeline turns the ordered stream of records into dwells. It has no threads, no clock and no I/O. The same stream
// gives the same bits.
#pragma once

#include <complex>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/slices.hpp"
#include "core/intake/channel_now.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "core/stream/sample_history.hpp"

namespace dwell {

class DwellDraft;

// What a push brought about: a set of bits.
enum Change : std::uint8_t {
  kNothing = 0,
  kStateChanged = 1,  // the state (idle, settling, measuring) has changed
  kCompleted = 2,     // a dwell has ended: completed() returns it
};

class Pipeline {
 public:
  static constexpr std::int64_t kLatest_ns = std::int64_t{1} << 61;  // 73 years: later instants are invalid

  // The rig must be valid (config::validate). All memory is allocated here. slices: push() does its long work in them
  // (PacedPipeline); null: in one piece. They must outlive the pipeline.
  explicit Pipeline(const Rig& rig, Slices* slices = nullptr);
  ~Pipeline();
  Pipeline(Pipeline&&) noexcept;
  Pipeline& operator=(Pipeline&&) noexcept;

  // Takes the next record of the ordered stream. All reported times count from the first record that concerns the
  // pipeline. Returns a set of Change. No allocation, except once per completed dwell. Cost: O(1) per sample;
  // O(channels · H²) at the end of a block (a quarter of a period), while settling O(channels · (H² + windows seen))
  // and now and then the chain's eigenvalues, O(masses³), masses <= 64. Each time the hold has grown to 1.25 … 2
  // times its length, its transient is fitted anew, in `slices` if given: at least four passes over the samples held,
  // (2H + 3 + 4 modes)²/2 multiplications each. 0.1 s if four are enough, some seconds for sixteen full rings.
  std::uint8_t push(const Record& record) noexcept;
  // Takes the first records as push() would one by one, as long as they are samples or ticks within the open block:
  // none of them changes a state or ends a dwell. Returns how many; 0: push() must take the next one. Cheaper than
  // push() where nearly all readings are plain (plain_run.hpp): give it all records at hand. Real-time safe.
  std::size_t push_in_block(std::span<const Record> records) noexcept;

  // Whether push() may do more than take in a sample.
  [[nodiscard]] bool may_take_long(const Record& record) const noexcept;

  // Ends the run: completes the present dwell with `end`. Returns a set of Change.
  std::uint8_t finish();

  // The present dwell so far: all phasors, coefficients, uncertainties. Allocates; for every Rig::update_s.
  [[nodiscard]] Dwell current() const;

  // The same without its coefficients, which the draft computes, on any thread. Refers to this pipeline's rig.
  [[nodiscard]] DwellDraft current_draft() const;

  // The dwell that ended last; valid after push() or finish() has returned kCompleted.
  [[nodiscard]] const Dwell& completed() const noexcept;

  [[nodiscard]] State state() const noexcept;

  // The newest readings that count, on the stream's clock, SI: the data of a verification. No allocation.
  [[nodiscard]] const SampleHistory& readings() const noexcept;

  // Amplitude and phase of a channel now, over the data that count; while settling over the last period. SI in the
  // channel's own quantity, the transducer's response divided out. Phase at the newest sample's instant. NaN: none. No
  // allocation.
  [[nodiscard]] std::complex<double> phasor(int channel) const noexcept;

  [[nodiscard]] ChannelNow channel(int channel) const noexcept;
  // The channel's condition in words, with figures; empty: ok or unheard. Allocates.
  [[nodiscard]] std::string condition_reason(int channel) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
