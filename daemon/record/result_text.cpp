#include "daemon/record/result_text.hpp"

#include <charconv>

#include "daemon/record/run_entries.hpp"
#include "daemon/record/utf8.hpp"

namespace dwell::record {
namespace {

constexpr int kMostNesting = 60;  // parse_result() takes 64, the entry itself included
constexpr int kMostDigits = 200;  // before the point: with the exponent below, a double holds the number

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

// One pass over JSON (RFC 8259). Whatever is seldom written is refused.
class PlainJson {
 public:
  explicit PlainJson(std::string_view text) noexcept : at_(text.data()), end_(text.data() + text.size()) {}

  bool is_object() noexcept { return peek() == '{' && object(1) && at_ == end_; }

 private:
  [[nodiscard]] char peek() const noexcept { return at_ != end_ ? *at_ : '\0'; }
  bool take(char c) noexcept {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  bool take(std::string_view word) noexcept {
    if (std::string_view(at_, static_cast<std::size_t>(end_ - at_)).substr(0, word.size()) != word) return false;
    at_ += word.size();
    return true;
  }
  int digits() noexcept {
    const char* const from = at_;
    while (is_digit(peek())) ++at_;
    return static_cast<int>(at_ - from);
  }

  bool value(int depth) noexcept {
    switch (peek()) {
      case '{':
        return object(depth + 1);
      case '[':
        return array(depth + 1);
      case '"':
        return string();
      case 't':
        return take("true");
      case 'f':
        return take("false");
      case 'n':
        return take("null");
      default:
        return number();
    }
  }

  bool object(int depth) noexcept {
    if (depth > kMostNesting || !take('{')) return false;
    if (take('}')) return true;
    do {
      if (!string() || !take(':') || !value(depth)) return false;
    } while (take(','));
    return take('}');
  }

  bool array(int depth) noexcept {
    if (depth > kMostNesting || !take('[')) return false;
    if (take(']')) return true;
    do {
      if (!value(depth)) return false;
    } while (take(','));
    return take(']');
  }

  bool number() noexcept {
    take('-');
    const bool zero = peek() == '0';
    const int whole = digits();
    if (whole == 0 || whole > kMostDigits || (zero && whole > 1)) return false;
    if (take('.') && digits() == 0) return false;
    if (!take('e') && !take('E')) return true;
    const bool small = take('-');
    if (!small) take('+');
    const int power = digits();
    return power > 0 && power <= (small ? 3 : 2);
  }

  bool string() noexcept {
    if (!take('"')) return false;
    while (at_ != end_) {
      const auto c = static_cast<unsigned char>(*at_);
      if (c == '"') return ++at_, true;
      if (c < ' ') return false;
      if (c == '\\' ? !escape() : c < 0x80 ? (++at_, false) : !utf8()) return false;
    }
    return false;
  }

  // Those of one character.
  bool escape() noexcept {
    ++at_;
    return std::string_view("\"\\/bfnrt").find(peek()) != std::string_view::npos && at_ != end_ && (++at_, true);
  }

  bool utf8() noexcept {
    const std::size_t length = utf8_character({at_, static_cast<std::size_t>(end_ - at_)});
    at_ += length;
    return length > 0;
  }

  const char* at_;
  const char* const end_;
};

}  // namespace

std::optional<ResultFront> front_of(std::string_view body) noexcept {
  static constexpr std::string_view position = R"({"position":)", yes = R"(,"final":true,"dwell":)",
                                    no = R"(,"final":false,"dwell":)";
  if (body.substr(0, position.size()) != position || body.back() != '}') return std::nullopt;
  ResultFront front;
  const char* const digits = body.data() + position.size();
  const auto [end, code] = std::from_chars(digits, body.data() + body.size(), front.position);
  if (code != std::errc{} || (*digits == '0' && end - digits > 1)) return std::nullopt;
  const std::string_view rest = body.substr(static_cast<std::size_t>(end - body.data()));
  front.final = rest.substr(0, yes.size()) == yes;
  if (!front.final && rest.substr(0, no.size()) != no) return std::nullopt;
  front.dwell = rest.substr(front.final ? yes.size() : no.size());
  front.dwell.remove_suffix(front.dwell.empty() ? 0 : 1);
  return front;
}

bool is_plain_object(std::string_view text) noexcept { return PlainJson(text).is_object(); }

Result<void> check_result(const std::string& body) {
  const auto front = front_of(body);
  if (front && body.size() <= kMaxJson && is_plain_object(front->dwell)) return {};
  const auto parsed = parse_result(body);
  if (!parsed) return tl::unexpected(parsed.error());
  return {};
}

}  // namespace dwell::record
