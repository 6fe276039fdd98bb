// The dwell object as a JSON value, for .cpp files that put it into a larger document. Heavy: include it in .cpp only.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <tl/expected.hpp>

#include "daemon/report/dwell_view.hpp"

namespace dwell {

using Json = nlohmann::ordered_json;  // members stay in the order of the interface's document

// whole: the object of the interface. moving: without `covariance`, without every `budget`, which are most of it, and
// without `since`.
enum class Detail : std::uint8_t { whole, moving };

[[nodiscard]] Json json_value(const DwellView& view, Detail detail = Detail::whole);
struct MotionView;
// The object `motion`; null where there is none.
[[nodiscard]] Json json_value(const MotionView& view, Detail detail = Detail::whole);
[[nodiscard]] tl::expected<DwellView, std::string> dwell_from_json(const Json& value);

// Text of a document; indent < 0: one line. Bytes that are not UTF-8 are replaced, never thrown over. Characters that a
// terminal may obey, or that turn the direction of text, are written as \uXXXX.
[[nodiscard]] std::string dump(const Json& value, int indent = -1);

}  // namespace dwell
