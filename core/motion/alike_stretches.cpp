#include "core/motion/alike_stretches.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <utility>

namespace dwell {
namespace {

// The stretches as a list, each at the index of its first block, and the neighbours in the order in which they are
// joined.
class Joining {
 public:
  explicit Joining(const std::vector<double>& logarithms) {
    for (std::size_t i = 0; i < logarithms.size(); ++i) pieces_.push_back({{i, logarithms[i], 1}, i, i + 1});
    for (std::size_t i = 1; i < pieces_.size(); ++i) {
      pieces_[i].before = i - 1;
      add(i);
    }
  }

  // How much the neighbours differ that are joined next. There must be two stretches.
  [[nodiscard]] double least() const { return pairs_.begin()->first; }
  [[nodiscard]] std::size_t count() const { return pairs_.size() + 1; }

  void join() {
    const std::size_t second = pairs_.begin()->second, first = pieces_[second].before, next = pieces_[second].next;
    pairs_.erase(pairs_.begin());
    if (first > 0) pairs_.erase({pieces_[first].from_before, first});
    if (next < pieces_.size()) pairs_.erase({pieces_[next].from_before, next});
    AlikeStretches::Stretch &into = pieces_[first].stretch, &from = pieces_[second].stretch;
    const auto a = static_cast<double>(into.blocks), b = static_cast<double>(from.blocks);
    into.logarithm = (into.logarithm * a + from.logarithm * b) / (a + b);
    into.blocks += from.blocks;
    pieces_[first].next = next;
    if (first > 0) add(first);
    if (next < pieces_.size()) {
      pieces_[next].before = first;
      add(next);
    }
  }

  [[nodiscard]] AlikeStretches result() const {
    AlikeStretches out;
    out.compared = compared_;
    for (std::size_t i = 0; i < pieces_.size(); i = pieces_[i].next) out.stretches.push_back(pieces_[i].stretch);
    return out;
  }

 private:
  struct Piece {
    AlikeStretches::Stretch stretch;
    std::size_t before, next;  // indexes
    double from_before = 0.0;  // how much it differs from the stretch before
  };

  // Infinite logarithms have no difference: they are joined last.
  void add(std::size_t i) {
    const double apart = std::abs(pieces_[i].stretch.logarithm - pieces_[pieces_[i].before].stretch.logarithm);
    pieces_[i].from_before = std::isnan(apart) ? std::numeric_limits<double>::infinity() : apart;
    pairs_.emplace(pieces_[i].from_before, i);
    ++compared_;
  }

  std::vector<Piece> pieces_;
  std::set<std::pair<double, std::size_t>> pairs_;  // the difference, and the second of the two
  std::size_t compared_ = 0;
};

}  // namespace

AlikeStretches join_alike(const std::vector<double>& logarithms, double apart, std::size_t most) {
  Joining joining(logarithms);
  while (joining.count() > 1 && !(joining.least() > apart && joining.count() <= most)) joining.join();
  return joining.result();
}

}  // namespace dwell
