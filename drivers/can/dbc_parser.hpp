// What parse_dbc works with: the statements of a DBC file one after the other, then what joins them. Used by
// dbc_parser.cpp and dbc_links.cpp alone.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/can/dbc.hpp"
#include "drivers/can/dbc_lexer.hpp"

namespace dwell::can {

class DbcParser {
 public:
  explicit DbcParser(std::string_view text) : lexer_(text) {}
  DbcResult parse();

 private:
  // A statement that speaks of a signal declared elsewhere.
  struct FloatStatement {
    Token message, signal;
    std::uint64_t type;
  };
  struct SelectorStatement {
    Token message, signal, selector;
    std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  };
  // What SG_ says of multiplexing.
  struct Multiplexed {
    std::size_t message, signal;
    Token at;
    std::uint64_t value;
    bool linked = false;  // by SG_MUL_VAL_
  };
  struct Frame {  // BA_ "VFrameFormat" or "GenMsgCycleTime"
    std::uint64_t id;
    Token value;
  };

  // dbc_parser.cpp: statements. false: told a mistake, the rest of the statement is still there.
  void statement();
  bool message();
  bool signal();
  bool multiplexing(Signal& made, std::optional<Multiplexed>& multiplexed);
  bool layout(Signal& made);
  bool factor(double& factor);
  bool scaling(Signal& made);
  bool value_type();
  bool selector();
  bool attribute();
  bool attribute_definition();
  bool attribute_default();
  void names();

  bool mistake(const Token& at, std::string text);
  bool expected(std::string_view what);  // … and found lexer_.now()
  bool take(char sign, std::string_view what);
  bool take(std::uint64_t& number, std::uint64_t most, std::string_view what);
  bool take(double& number, std::string_view what);
  bool take_word(Token& word, std::string_view what);
  bool take_text(std::string_view what);    // of one line
  bool finish(std::string_view statement);  // the semicolon
  void skip_line();
  void skip_statement(const Token& begin);

  // dbc_links.cpp
  void link();
  void link_float(const FloatStatement& each);
  void link_selector(const SelectorStatement& each);
  void link_multiplexed(const Multiplexed& each);
  void check_nesting(const Multiplexed& each);
  void check_values(const Multiplexed& each);
  void link_formats();
  [[nodiscard]] bool is_j1939(const Token& value) const;
  // Of a message as statements name it; none: told.
  std::optional<std::size_t> find_message(const Token& id);
  std::optional<std::size_t> find_signal(std::size_t message, const Token& name);

  Lexer lexer_;
  Dbc dbc_;
  std::vector<DbcMistake> mistakes_;
  bool skipping_message_ = false;  // SG_ lines of a message that had a mistake, or is none
  bool in_message_ = false;
  std::map<std::uint64_t, std::size_t> by_id_;  // as in the file: bit 31 is the extended flag
  std::map<std::pair<std::size_t, std::string_view>, std::size_t> by_name_;
  std::vector<FloatStatement> floats_;
  std::vector<SelectorStatement> selectors_;
  std::vector<Multiplexed> multiplexed_;
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> multiplexed_at_;  // (message, signal) -> multiplexed_
  std::map<std::size_t, std::vector<std::size_t>> multiplexors_;               // of a message, the first three
  std::vector<Frame> formats_, cycles_;
  std::vector<std::string_view> format_names_;
  Token default_format_;
};

}  // namespace dwell::can
