// One table of the rig file while it is being read: typed access by key, every mistake noted with its position, and in
// the end the keys that nobody asked for. Internal to config, for it shows the TOML library.
//
// A getter writes its target only if the file gives a fit value, and returns whether it did; so defaults stay where
// they are stated once, in the structs. The TOML document and the list of mistakes must outlive the section.
#pragma once

#include <toml++/toml.h>

#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/mistake.hpp"

namespace dwell::config {

enum class Need : std::uint8_t { optional, required };

// What a number must be; `expected` tells it to people, unit included.
struct RealRule {
  const char* expected;
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;  // low itself is not allowed
  bool high_open = false;

  [[nodiscard]] bool admits(double number) const noexcept;  // never what is not finite
};

[[nodiscard]] Position position(const toml::node& node);
[[nodiscard]] const char* type_name(const toml::node& node);  // "a string", "an array", …
// The value as the file has it, for messages: a number, a quoted string, or else its type.
[[nodiscard]] std::string shown(const toml::node& node);
// Text for names and paths: not empty, no control, no line or paragraph separator, and no longer than 4096 bytes.
[[nodiscard]] bool is_one_line(std::string_view text);

class Section {
 public:
  // title: as in the file, for instance "[rig]".
  Section(const toml::table& table, std::string title, MistakeList& mistakes)
      : table_(&table), title_(std::move(title)), mistakes_(&mistakes) {}

  bool real(std::string_view key, double& target, const RealRule& rule, Need need = Need::optional);
  bool integer(std::string_view key, std::int64_t& target, std::int64_t low, std::int64_t high, const char* expected,
               Need need = Need::optional);
  bool boolean(std::string_view key, bool& target);
  // One line of text, see is_one_line().
  bool text(std::string_view key, std::string& target, const char* expected, Need need = Need::optional);
  // One of a few words.
  template <class E>
  bool choice(std::string_view key, E& target, const std::vector<std::pair<std::string, E>>& words,
              Need need = Need::optional);
  // Null: not there or of another type; the mistake is noted.
  const toml::table* table(std::string_view key, const char* expected, Need need = Need::optional);
  const toml::array* array(std::string_view key, const char* expected, Need need = Need::optional);
  // [low, high]: two finite numbers, low < high. Ends::one_may_be_open: -inf for low or inf for high, not both.
  enum class Ends : std::uint8_t { finite, one_may_be_open };
  bool interval(std::string_view key, double& low, double& high, const char* expected, Ends ends = Ends::finite);
  // The value, whatever it is; null: not given.
  const toml::node* value(std::string_view key);
  // The same without counting as asked for.
  [[nodiscard]] const toml::node* peek(std::string_view key) const { return table_->get(key); }

  // Notes a mistake at the value of `key`, or at the table's head if the key is not given.
  void wrong(std::string_view key, std::string message);
  void wrong_type(const toml::node& node, std::string_view key, std::string_view expected);
  void missing(std::string_view key, std::string_view expected);

  // The keys that nobody asked for, in no particular order.
  [[nodiscard]] std::vector<std::pair<std::string, const toml::node*>> rest() const;
  // Notes every one of them as unknown, with the nearest name that was asked for.
  void refuse_rest();
  void refuse(std::string_view key);

  [[nodiscard]] const std::vector<std::string>& asked() const { return asked_; }
  [[nodiscard]] Position where() const { return position(*table_); }
  [[nodiscard]] Position where(std::string_view key) const;
  [[nodiscard]] Position where_key(std::string_view key) const;
  [[nodiscard]] const std::string& title() const { return title_; }

 private:
  const toml::table* table_;
  std::string title_;
  MistakeList* mistakes_;
  std::vector<std::string> asked_;
};

template <class E>
bool Section::choice(std::string_view key, E& target, const std::vector<std::pair<std::string, E>>& words, Need need) {
  std::string expected;
  for (std::size_t i = 0; i < words.size(); ++i) {
    expected += i == 0 ? "" : i + 1 == words.size() ? " or " : ", ";
    expected += in_quotes(words[i].first);
  }
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, expected);
    return false;
  }
  const auto* given = node->as_string();
  for (const auto& [word, meaning] : words) {
    if (given != nullptr && given->get() == word) {
      target = meaning;
      return true;
    }
  }
  wrong(key, in_quotes(key) + " is " + (given ? in_quotes(given->get()) : type_name(*node)) + ": expected " + expected);
  return false;
}

}  // namespace dwell::config
