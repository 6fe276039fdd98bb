// What may fail, with the reason in words.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace dwell::record {

template <class T>
using Result = tl::expected<T, std::string>;

[[nodiscard]] inline tl::unexpected<std::string> fails(std::string reason) {
  return tl::unexpected<std::string>(std::move(reason));
}

}  // namespace dwell::record
