// What may fail, with the reason in words.
#pragma once

#include <cstdint>
#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace dwell::record {

// What a caller can do about a failure.
enum class Cause : std::uint8_t {
  other,
  read_again,   // a writer changed the file meanwhile: another attempt succeeds
  not_entered,  // the ledger is about to get the run
  stopped,      // the caller asked to give up
  newer,        // of a newer format than this program knows
};

// Why something failed, in words for people; the cause is for code.
class Failure : public std::string {
 public:
  Failure(std::string words, Cause cause = Cause::other) : std::string(std::move(words)), cause_(cause) {}
  Failure(const char* words, Cause cause = Cause::other) : std::string(words), cause_(cause) {}

  [[nodiscard]] Cause cause() const noexcept { return cause_; }

 private:
  Cause cause_;
};

template <class T>
using Result = tl::expected<T, Failure>;

[[nodiscard]] inline tl::unexpected<Failure> fails(Failure reason) {
  return tl::unexpected<Failure>(std::move(reason));
}

}  // namespace dwell::record
