#include "drivers/can/dbc_parser.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace dwell::can {
namespace {

using Kind = Token::Kind;

constexpr std::uint64_t kExtended = 0x80000000U;
// VECTOR__INDEPENDENT_SIG_MSG: a home for signals without a message.
constexpr std::uint64_t kIndependent = 0xC0000000U;
constexpr std::uint64_t kLongestMessage = 1785;  // bytes, of a J1939 transport session
constexpr std::string_view kFormat = "VFrameFormat", kCycle = "GenMsgCycleTime";

// Between blanks each.
constexpr std::string_view kSections =
    " VERSION NS_ BS_ BU_ BO_ SG_ CM_ BA_ BA_DEF_ BA_DEF_DEF_ BA_REL_ BA_DEF_REL_ BA_DEF_DEF_REL_ VAL_ VAL_TABLE_ EV_ "
    "ENVVAR_DATA_ EV_DATA_ SIG_GROUP_ SIG_VALTYPE_ SG_MUL_VAL_ BO_TX_BU_ SGTYPE_ SIG_TYPE_REF_ CAT_ CAT_DEF_ FILTER "
    "SGTYPE_VAL_ BA_DEF_SGTYPE_ BA_SGTYPE_ ";

bool is_section(const Token& token) {
  constexpr std::size_t kLongest = 20;
  return token.kind == Kind::word && token.text.size() <= kLongest &&
         kSections.find(" " + std::string(token.text) + " ") != std::string_view::npos;
}

std::optional<std::uint64_t> whole(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<double> real(std::string_view text) {
  if (!text.empty() && text[0] == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

// ---- helpers -------------------------------------------------------------------------------------------------------

bool DbcParser::mistake(const Token& at, std::string text) {
  mistakes_.push_back({at.line, at.column, std::move(text)});
  return false;
}

bool DbcParser::expected(std::string_view what) {
  const Token& found = lexer_.now();
  if (found.kind == Kind::open) return mistake(found, "the text that begins here has no end; expected a quote");
  return mistake(found, "found " + found.shown() + "; expected " + std::string(what));
}

bool DbcParser::take(char sign, std::string_view what) {
  if (!lexer_.now().is(sign)) return expected("`" + std::string(1, sign) + "` " + std::string(what));
  lexer_.next();
  return true;
}

bool DbcParser::take(std::uint64_t& number, std::uint64_t most, std::string_view what) {
  const auto value = lexer_.now().kind == Kind::number ? whole(lexer_.now().text) : std::nullopt;
  if (!value || *value > most) return expected(std::string(what) + ", a whole number up to " + std::to_string(most));
  number = *value;
  lexer_.next();
  return true;
}

bool DbcParser::take(double& number, std::string_view what) {
  const auto value = lexer_.now().kind == Kind::number ? real(lexer_.now().text) : std::nullopt;
  if (!value) return expected(std::string(what) + ", a number");
  number = *value;
  lexer_.next();
  return true;
}

bool DbcParser::take_word(Token& word, std::string_view what) {
  if (lexer_.now().kind != Kind::word) return expected(what);
  word = lexer_.now();
  lexer_.next();
  return true;
}

// A quote that is missing must not swallow what comes after.
bool DbcParser::take_text(std::string_view what) {
  const Token& found = lexer_.now();
  if (found.spans_lines()) return mistake(found, "the text that begins here has no end on its line; expected a quote");
  if (found.kind != Kind::text) return expected(what);
  lexer_.next();
  return true;
}

bool DbcParser::finish(std::string_view statement) { return take(';', "at the end of " + std::string(statement)); }

// Going back to the end of a line costs as much as the text is long, so each time is a mistake told, of which there are
// only so many; one a line.
void DbcParser::skip_line() {
  for (; lexer_.now().kind != Kind::end; lexer_.next()) {
    if (lexer_.now().spans_lines()) {
      if (mistakes_.empty() || mistakes_.back().line != lexer_.now().line) take_text("");
      return lexer_.next_line();
    }
    if (lexer_.now().first) return;
  }
}

// Reads over everything up to the semicolon, texts of many lines included. The next section before that: it is missing.
void DbcParser::skip_statement(const Token& begin) {
  for (; lexer_.now().kind != Kind::end; lexer_.next()) {
    const Token& token = lexer_.now();
    if (token.kind == Kind::open) {
      expected("");
      lexer_.next();
      return;
    }
    if (token.is(';')) return lexer_.next();
    if (token.first && is_section(token)) break;
  }
  mistake(begin, "`" + std::string(begin.text) + "` has no end; expected `;` before line " +
                     std::to_string(lexer_.now().line));
}

// ---- statements ----------------------------------------------------------------------------------------------------

DbcResult DbcParser::parse() {
  while (lexer_.now().kind != Kind::end && mistakes_.size() < kMostMistakes) statement();
  if (mistakes_.empty()) link();
  if (mistakes_.empty()) return std::move(dbc_);
  std::stable_sort(mistakes_.begin(), mistakes_.end(), [](const DbcMistake& a, const DbcMistake& b) {
    return std::pair(a.line, a.column) < std::pair(b.line, b.column);
  });
  if (mistakes_.size() > kMostMistakes) mistakes_.resize(kMostMistakes);
  return tl::unexpected(std::move(mistakes_));
}

void DbcParser::statement() {
  const Token begin = lexer_.now();
  if (begin.is(';')) return lexer_.next();
  const bool plausible = begin.kind == Kind::word && (is_section(begin) || begin.text.back() == '_');
  if (!plausible) {
    expected("the next section, for instance BO_");
    lexer_.next();
    return skip_line();
  }
  lexer_.next();
  if (begin.is("SG_")) {
    if (!in_message_) mistake(begin, "a signal outside of a message; expected BO_ before it");
    if (!in_message_ || skipping_message_ || !signal()) skip_line();
    return;
  }
  in_message_ = begin.is("BO_");
  if (in_message_) {
    skipping_message_ = !message();
    return skip_line();
  }
  if (begin.is("VERSION")) {
    if (!take_text("the version, a text in quotes")) skip_line();
    return;
  }
  if (begin.is("NS_") || begin.is("BU_")) return names();
  if (begin.is("BS_")) return skip_line();
  using Statement = bool (DbcParser::*)();
  const Statement known = begin.is("SIG_VALTYPE_")  ? &DbcParser::value_type
                          : begin.is("SG_MUL_VAL_") ? &DbcParser::selector
                          : begin.is("BA_")         ? &DbcParser::attribute
                          : begin.is("BA_DEF_")     ? &DbcParser::attribute_definition
                          : begin.is("BA_DEF_DEF_") ? &DbcParser::attribute_default
                                                    : nullptr;
  const std::size_t told = mistakes_.size();
  if (known != nullptr && (this->*known)()) return;
  skip_statement(begin);
  if (mistakes_.size() > told + 1) mistakes_.resize(told + 1);  // one a statement
}

// The lists of NS_ and BU_ have no end: they last until a section. NS_ lists the words that begin sections, one a line.
void DbcParser::names() {
  if (lexer_.now().is(':')) lexer_.next();
  for (; lexer_.now().kind == Kind::word; lexer_.next()) {
    if (!lexer_.now().first || !is_section(lexer_.now())) continue;
    if (lexer_.now().is("BS_") || lexer_.now().is("BU_") || lexer_.now().is("BO_")) return;
    Lexer ahead = lexer_;
    ahead.next();
    if (!ahead.now().first) return;
  }
}

// BO_ id name: length sender
bool DbcParser::message() {
  const Token at = lexer_.now();
  std::uint64_t id = 0, length = 0;
  Token name;
  if (!take(id, 0xFFFFFFFFU, "the message's identifier") || !take_word(name, "the message's name") ||
      !take(':', "after the message's name") || !take(length, kLongestMessage, "the message's length in bytes"))
    return false;
  if (lexer_.now().kind == Kind::word && !lexer_.now().first) lexer_.next();
  if (id == kIndependent) return false;
  const bool extended = (id & kExtended) != 0;
  const std::uint64_t most = extended ? 0x1FFFFFFFU : 0x7FFU;
  if ((id & ~kExtended) > most)
    return mistake(at, extended
                           ? "identifier " + std::string(at.text) + " has more than 29 bits below the extended flag"
                           : "identifier " + std::string(at.text) +
                                 " has more than 11 bits; expected an extended one to have bit 31 set");
  if (dbc_.messages.size() >= kMostMessages)
    return mistake(at, "too many messages; expected at most " + std::to_string(kMostMessages));
  if (!by_id_.emplace(id, dbc_.messages.size()).second)
    return mistake(at, "identifier " + std::string(at.text) + " is that of message `" + dbc_.messages[by_id_[id]].name +
                           "` already; expected one of its own");
  Message made;
  made.name = std::string(name.text);
  made.id = static_cast<std::uint32_t>(id & ~kExtended);
  made.extended = extended;
  made.length = static_cast<std::size_t>(length);
  dbc_.messages.push_back(std::move(made));
  return true;
}

// SG_ name [M | m0 | m0M] : start|length@order sign (factor,offset) [minimum|maximum] "unit" receivers
bool DbcParser::signal() {
  const std::size_t message = dbc_.messages.size() - 1;
  Message& owner = dbc_.messages[message];
  Signal made;
  Token name;
  std::optional<Multiplexed> multiplexed;
  if (!take_word(name, "the signal's name") || !multiplexing(made, multiplexed)) return false;
  made.name = std::string(name.text);
  made.line = name.line;
  made.column = name.column;
  if (!take(':', "after the signal's name") || !layout(made) || !scaling(made)) return false;
  if (made.unreadable.empty() && bytes_of(made.field) > owner.length)
    return mistake(name, "signal `" + made.name + "` needs " + std::to_string(bytes_of(made.field)) +
                             " bytes; expected it within the " + std::to_string(owner.length) + " of message `" +
                             owner.name + "`");
  if (owner.signals.size() >= kMostSignals)
    return mistake(name, "too many signals in one message; expected at most " + std::to_string(kMostSignals));
  if (!by_name_.emplace(std::pair(message, name.text), owner.signals.size()).second)
    return mistake(name,
                   "message `" + owner.name + "` has a signal `" + made.name + "` already; expected another name");
  if (multiplexed) {
    multiplexed->message = message;
    multiplexed->signal = owner.signals.size();
    multiplexed->at = name;
    multiplexed_at_[{message, owner.signals.size()}] = multiplexed_.size();
    multiplexed_.push_back(*multiplexed);
  }
  owner.signals.push_back(std::move(made));
  skip_line();  // receivers
  return true;
}

bool DbcParser::multiplexing(Signal& made, std::optional<Multiplexed>& multiplexed) {
  if (lexer_.now().kind != Kind::word) return true;
  std::string_view text = lexer_.now().text;
  if (text.back() == 'M') {
    made.multiplexor = true;
    text.remove_suffix(1);
  }
  if (!text.empty()) {
    const auto value = text[0] == 'm' ? whole(text.substr(1)) : std::nullopt;
    if (!value) return expected("`:` after the signal's name, or M, m0 or m0M");
    made.multiplexed = true;
    multiplexed = Multiplexed{0, 0, {}, *value};
  }
  lexer_.next();
  return true;
}

bool DbcParser::layout(Signal& made) {
  std::uint64_t start = 0, length = 0, order = 0;
  const auto at = [&] { return lexer_.now(); };
  if (!take(start, kLongestMessage * 8 - 1, "the signal's first bit") || !take('|', "after the signal's first bit"))
    return false;
  const Token long_at = at();
  if (!take(length, kLongestMessage * 8, "the signal's length in bits")) return false;
  if (length == 0) return mistake(long_at, "a signal of no bits; expected 1 to 64");
  if (!take('@', "after the signal's length") || !take(order, 1, "the order of bytes: 0 Motorola, 1 Intel"))
    return false;
  if (!at().is('+') && !at().is('-')) return expected("`+` (unsigned) or `-` (signed)");
  made.field.form = at().is('-') ? Form::signed_integer : Form::unsigned_integer;
  made.field.order = order == 1 ? Order::intel : Order::motorola;
  made.field.start = static_cast<std::uint16_t>(start);
  made.field.length = static_cast<std::uint8_t>(std::min<std::uint64_t>(length, kLongestField));
  if (length > kLongestField) made.unreadable = "is of " + std::to_string(length) + " bits; expected at most 64";
  lexer_.next();
  return true;
}

bool DbcParser::factor(double& factor) {
  const Token at = lexer_.now();
  if (!take(factor, "the signal's factor")) return false;
  return factor != 0.0 || mistake(at, "a factor of 0 makes every reading the same; expected another");
}

bool DbcParser::scaling(Signal& made) {
  double minimum = 0.0, maximum = 0.0;
  if (!take('(', "before the signal's factor") || !factor(made.factor) || !take(',', "after the signal's factor") ||
      !take(made.offset, "the signal's offset") || !take(')', "after the signal's offset") ||
      !take('[', "before the signal's minimum") || !take(minimum, "the signal's minimum") ||
      !take('|', "after the signal's minimum") || !take(maximum, "the signal's maximum") ||
      !take(']', "after the signal's maximum"))
    return false;
  return take_text("the signal's unit, a text in quotes");
}

// SIG_VALTYPE_ message signal : type ;
bool DbcParser::value_type() {
  FloatStatement made{lexer_.now(), {}, 0};
  std::uint64_t id = 0;
  if (!take(id, 0xFFFFFFFFU, "the message's identifier") || !take_word(made.signal, "the signal's name")) return false;
  if (lexer_.now().is(':')) lexer_.next();
  if (!take(made.type, 3, "the signal's type: 0 integer, 1 float of 32, 2 float of 64 bits") || !finish("SIG_VALTYPE_"))
    return false;
  floats_.push_back(made);
  return true;
}

// SG_MUL_VAL_ message signal selector 0-3, 7-7 ;
bool DbcParser::selector() {
  SelectorStatement made{lexer_.now(), {}, {}, {}};
  std::uint64_t id = 0;
  if (!take(id, 0xFFFFFFFFU, "the message's identifier") || !take_word(made.signal, "the signal's name") ||
      !take_word(made.selector, "the name of its multiplexor"))
    return false;
  do {
    if (lexer_.now().is(',')) lexer_.next();
    std::uint64_t low = 0;
    if (!take(low, UINT64_MAX, "the first value of a range")) return false;
    // "0-3" reads as 0 and -3.
    const Token& found = lexer_.now();
    std::optional<std::uint64_t> high;
    if (found.kind == Kind::number && found.text[0] == '-') high = whole(found.text.substr(1));
    if (found.is('-')) {
      lexer_.next();
      if (lexer_.now().kind == Kind::number) high = whole(lexer_.now().text);
    }
    if (!high || *high < low) return expected("`-` and the last value of the range, not below the first");
    lexer_.next();
    made.ranges.emplace_back(low, *high);
  } while (lexer_.now().is(','));
  if (!finish("SG_MUL_VAL_")) return false;
  selectors_.push_back(std::move(made));
  return true;
}

// BA_ "name" BO_ id value ; of all attributes two are of interest. false: not told, the rest is read over.
bool DbcParser::attribute() {
  if (lexer_.now().kind != Kind::text || (lexer_.now().text != kFormat && lexer_.now().text != kCycle)) return false;
  std::vector<Frame>& frames = lexer_.now().text == kFormat ? formats_ : cycles_;
  lexer_.next();
  if (!lexer_.now().is("BO_")) return false;
  lexer_.next();
  std::uint64_t id = 0;
  if (!take(id, 0xFFFFFFFFU, "the message's identifier")) return false;
  const Token value = lexer_.now();
  if (value.kind != Kind::number && value.kind != Kind::text) return expected("the attribute's value");
  lexer_.next();
  if (!finish("BA_")) return false;
  frames.push_back({id, value});
  return true;
}

// BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN",… ;
bool DbcParser::attribute_definition() {
  if (!lexer_.now().is("BO_")) return false;
  lexer_.next();
  if (lexer_.now().kind != Kind::text || lexer_.now().text != kFormat) return false;
  lexer_.next();
  if (!lexer_.now().is("ENUM")) return false;
  lexer_.next();
  format_names_.clear();
  for (; lexer_.now().kind == Kind::text || lexer_.now().is(','); lexer_.next())
    if (lexer_.now().kind == Kind::text) format_names_.push_back(lexer_.now().text);
  return finish("BA_DEF_");
}

// BA_DEF_DEF_ "VFrameFormat" "StandardCAN" ;
bool DbcParser::attribute_default() {
  if (lexer_.now().kind != Kind::text || lexer_.now().text != kFormat) return false;
  lexer_.next();
  if (lexer_.now().kind != Kind::text && lexer_.now().kind != Kind::number) return false;
  default_format_ = lexer_.now();
  lexer_.next();
  return finish("BA_DEF_DEF_");
}

DbcResult parse_dbc(std::string_view text) {
  if (text.size() > kMostDbcBytes)
    return tl::unexpected(std::vector<DbcMistake>{
        {1, 1, "the file is too long; expected at most " + std::to_string(kMostDbcBytes >> 20U) + " MiB"}});
  return DbcParser(text).parse();
}

}  // namespace dwell::can
