// Joins neighbouring blocks of a motion where they are most alike, until few stretches are left.
#pragma once

#include <cstddef>
#include <vector>

namespace dwell {

struct AlikeStretches {
  struct Stretch {
    std::size_t first;  // its first block
    double logarithm;   // mean over its blocks
    std::size_t blocks;
  };
  std::vector<Stretch> stretches;
  std::size_t compared = 0;  // pairs of neighbours: the work that was done
};

// logarithms: of each block's amplitude. The two neighbours that differ least are joined first, of equal ones the
// earliest; this ends when all differ by more than `apart` and at most `most` stretches are left. At most 3 comparisons
// a block. O(n log n); allocates; thread-safe.
[[nodiscard]] AlikeStretches join_alike(const std::vector<double>& logarithms, double apart, std::size_t most);

}  // namespace dwell
