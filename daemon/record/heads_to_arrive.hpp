// The last heads of ended runs, until they have arrived at the anchor's file or command. Of the run that goes on and of
// the ledger the folder tells the head whenever it is asked; of an ended run only once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <utility>

#include "daemon/record/anchor.hpp"

namespace dwell::record {

// Bound to one thread.
class HeadsToArrive {
 public:
  // Of more the oldest is dropped; it stands in the log. They fit into the pipe of deliver_anchor().
  static constexpr std::size_t kMost = 256;

  void add(Anchor head) {
    heads_.push_back(std::move(head));
    ++added_;
    if (heads_.size() > kMost) heads_.pop_front();
  }
  // How many were ever added. A delivery made now holds all of them that are still there.
  [[nodiscard]] std::uint64_t added() const noexcept { return added_; }
  // A delivery made when `added` were added has arrived.
  void arrived(std::uint64_t added) {
    while (!heads_.empty() && added_ - heads_.size() < added) heads_.pop_front();
  }
  // Oldest first.
  [[nodiscard]] const std::deque<Anchor>& all() const noexcept { return heads_; }

 private:
  std::deque<Anchor> heads_;
  std::uint64_t added_ = 0;
};

}  // namespace dwell::record
