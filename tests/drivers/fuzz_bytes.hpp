// What a fuzzer hands in, taken piece by piece; what is not there is zero.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <span>

namespace dwell::test {

// Ends the fuzzer where a promise is broken.
inline void hold(bool promise) {
  if (!promise) std::abort();
}

class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  template <class T>
  T take() {
    T value{};
    const auto some = take_some(sizeof value);
    std::memcpy(&value, some.data(), some.size());
    return value;
  }
  std::span<const std::uint8_t> take_some(std::size_t most) {
    const std::size_t count = std::min(most, size_);
    const std::span<const std::uint8_t> some(data_, count);
    data_ += count;
    size_ -= count;
    return some;
  }
  [[nodiscard]] bool empty() const { return size_ == 0; }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace dwell::test
