// Finds the frequency of a new drive anywhere in the search range.
//
// One sine and a mean are fitted to the readings at their own instants, by least squares. The search range is divided
// into cells. The fit is made at the centre of each cell; Gauss-Newton starts at the centre that explains most. The fit
// with harmonics cannot be used here: at half the frequency of a sine, its second harmonic explains everything and its
// fundamental is zero.
//
// The fitted stretch lasts one period of the lowest frequency, T = 1/low, or less if fewer readings exist. At a
// frequency that is wrong by δf, a fitted sine explains sinc²(πδfT) of the energy. Cells are 1/(2T) wide: at their
// edges 81 % is explained, and Gauss-Newton converges.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/rig/rig.hpp"
#include "core/stream/sample_history.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor. Angular frequencies in rad/s.
class FrequencySearch {
 public:
  explicit FrequencySearch(const Rig& rig);

  // False: no search is needed. The rig file states the frequency; or the range is one cell, and a fit that begins at
  // the nominal frequency converges everywhere in it.
  [[nodiscard]] bool wanted() const noexcept { return cells_.size() > 1; }
  // Whether two frequencies are at most half a cell apart: a fit that begins at one finds the other.
  [[nodiscard]] bool near(double omega, double other) const noexcept;
  // T, s.
  [[nodiscard]] double longest_s() const noexcept { return longest_s_; }

  // ω of the sine in a channel's readings over [begin, end). None: the stretch is shorter than T/2, or the sine may be
  // noise. Books its work in the history. O(readings of all channels + cells · readings of the channel).
  [[nodiscard]] std::optional<double> find(const SampleHistory& history, int channel, std::int64_t begin_ns,
                                           std::int64_t end_ns) noexcept;

 private:
  // Sums over the readings y: of sine s and cosine c at the cell's centre, and of the products ss, sc, cc, ys, yc.
  struct Cell {
    double s = 0.0, c = 0.0, ss = 0.0, sc = 0.0, cc = 0.0, ys = 0.0, yc = 0.0;
  };
  struct Readings {
    const SampleHistory& history;
    int channel;
    std::uint64_t first, last;
    std::int64_t centre_ns;
    // Calls use(u, y) for each reading: u is the time since centre_ns, s; y the value less the first reading's value.
    template <class Use>
    void each(Use&& use) const noexcept;
  };
  [[nodiscard]] double best_cell(const Readings& readings) noexcept;
  [[nodiscard]] std::optional<double> refined(const Readings& readings, double omega) const noexcept;

  double low_, high_;  // rad/s
  double longest_s_, width_;
  std::vector<Cell> cells_;
};

}  // namespace dwell
