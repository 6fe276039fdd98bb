// What a person may write for the record: labels, comments, names and reasons. One rule for all of them, whoever takes
// them: they are shown on one line, in terminals and on pages, and cannot be taken back. Any thread.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dwell::record {

// Most bytes of a label, and of the name and the meaning of a signature; of a comment, and of the reason of a
// signature. Longer texts belong in a document beside the run.
inline constexpr std::size_t kLabelBytes = 200, kCommentBytes = 4000;

// Why `text` cannot stand in the record, with what was expected: it is not UTF-8, holds a control character
// (core/base/printable.hpp), has more than `most` bytes, or holds spaces alone. Empty: it can.
[[nodiscard]] std::string why_not_words(std::string_view text, std::size_t most);

}  // namespace dwell::record
