// A DBC file: which messages there are on a bus and where their signals lie. The subset that reading signals needs; all
// else (comments, value tables, attributes, environment variables, …) is read over.
//
// Pure but for read_dbc. The text is not trusted: it is bounded, and every mistake is told with its position. After a
// mistake reading goes on with the next statement, so that all are told at once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "drivers/can/field.hpp"

namespace dwell::can {

struct Signal {
  std::string name;
  Field field;
  double factor = 1.0;  // physical value = factor · number + offset
  double offset = 0.0;
  bool multiplexor = false;
  // Multiplexed: there while the multiplexor (an index into Message::signals) has a value in one of the ranges.
  bool multiplexed = false;
  std::size_t selector = 0;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> selected_by;  // inclusive
  std::size_t line = 1, column = 1;
  std::string unreadable;  // why no value can be had from it although the file is right; empty: it can
};

struct Message {
  std::string name;
  std::uint32_t id = 0;  // 11 or 29 bits
  bool extended = false;
  bool j1939 = false;      // known by its parameter group, whatever source, destination and priority
  std::size_t length = 0;  // bytes
  double cycle_s = 0.0;    // GenMsgCycleTime; 0: none stated
  std::vector<Signal> signals;
};

struct Dbc {
  std::vector<Message> messages;
};

struct DbcMistake {
  std::size_t line = 1, column = 1;  // column: in bytes, from 1
  std::string text;                  // what is wrong, and what was expected
};

inline constexpr std::size_t kMostDbcBytes = 16U << 20U;
inline constexpr std::size_t kMostMistakes = 20;  // then reading ends
inline constexpr std::size_t kMostMessages = 100'000;
inline constexpr std::size_t kMostSignals = 4096;  // of a message
inline constexpr std::size_t kMostNesting = 8;     // multiplexors of multiplexors

// Ordered by position; never empty when unexpected.
using DbcResult = tl::expected<Dbc, std::vector<DbcMistake>>;
[[nodiscard]] DbcResult parse_dbc(std::string_view text);

// Reads a file. A file that cannot be read is one mistake.
[[nodiscard]] DbcResult read_dbc(const std::string& path);

// "FILE:LINE:COLUMN: text"
[[nodiscard]] std::string to_string(const std::string& file, const DbcMistake& mistake);

// The names nearest to a word, best first, at most `most`; none that has little to do with it.
[[nodiscard]] std::vector<std::string> nearest(std::string_view word, const std::vector<std::string_view>& names,
                                               std::size_t most = 3);

}  // namespace dwell::can
