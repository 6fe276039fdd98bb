// The finished dwells that are kept in memory: the newest, bounded in number and in bytes, however many there have
// been. Bound to one thread; the list it hands out never changes, and may go to any.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "daemon/estimate/snapshot.hpp"

namespace dwell {

// What a dwell takes in memory, to within a few percent.
[[nodiscard]] std::size_t bytes_of(const Dwell& dwell) noexcept;

class KeptDwells {
 public:
  // The newest is kept however large.
  KeptDwells(std::size_t most, std::size_t most_bytes)
      : most_(most), most_bytes_(most_bytes), list_(std::make_shared<const FinishedDwells>()) {}

  void push(Dwell dwell);

  [[nodiscard]] const std::shared_ptr<const FinishedDwells>& list() const noexcept { return list_; }  // oldest first
  [[nodiscard]] std::uint64_t forgotten() const noexcept { return forgotten_; }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }

 private:
  std::size_t most_;
  std::size_t most_bytes_;
  std::shared_ptr<const FinishedDwells> list_;
  std::size_t bytes_ = 0;
  std::uint64_t forgotten_ = 0;
};

}  // namespace dwell
