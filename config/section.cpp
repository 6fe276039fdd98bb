#include "config/section.hpp"

#include <algorithm>
#include <cmath>

#include "config/decimal_comma.hpp"
#include "core/base/printable.hpp"

namespace dwell::config {

bool RealRule::admits(double number) const noexcept {
  if (!std::isfinite(number)) return false;
  return (low_open ? number > low : number >= low) && (high_open ? number < high : number <= high);
}

Position position(const toml::node& node) {
  const auto begin = node.source().begin;
  return {std::max(1, static_cast<int>(begin.line)), std::max(1, static_cast<int>(begin.column))};
}

const char* type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number with a fraction";
    case toml::node_type::boolean:
      return "a truth value";
    case toml::node_type::date:
      return "a date";
    case toml::node_type::time:
      return "a time";
    case toml::node_type::date_time:
      return "a date with a time";
    case toml::node_type::none:
      break;
  }
  return "nothing";
}

std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return in_quotes(text->get());
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  if (const auto* real = node.as_floating_point()) return number_text(real->get());
  return type_name(node);
}

bool is_one_line(std::string_view text) {
  constexpr std::string_view kLineSeparator = "\u2028", kParagraphSeparator = "\u2029";
  return !text.empty() && text.size() <= 4096 && !has_control(text) && text.find(kLineSeparator) == text.npos &&
         text.find(kParagraphSeparator) == text.npos;
}

bool Section::real(std::string_view key, double& target, const RealRule& rule, Need need) {
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, rule.expected);
    return false;
  }
  if (!node->is_number()) {
    wrong_type(*node, key, rule.expected);
    return false;
  }
  const double number = node->value<double>().value_or(std::nan(""));
  if (!rule.admits(number)) {
    wrong(key, in_quotes(key) + " is " + shown(*node) + ": expected " + rule.expected);
    return false;
  }
  target = number;
  return true;
}

bool Section::integer(std::string_view key, std::int64_t& target, std::int64_t low, std::int64_t high,
                      const char* expected, Need need) {
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, expected);
    return false;
  }
  const auto* given = node->as_integer();
  if (given == nullptr) {
    wrong_type(*node, key, expected);
    return false;
  }
  if (given->get() < low || given->get() > high) {
    wrong(key, in_quotes(key) + " is " + shown(*node) + ": expected " + expected);
    return false;
  }
  target = given->get();
  return true;
}

bool Section::boolean(std::string_view key, bool& target) {
  const toml::node* node = value(key);
  if (node == nullptr) return false;
  const auto* given = node->as_boolean();
  if (given == nullptr) {
    wrong_type(*node, key, "true or false");
    return false;
  }
  target = given->get();
  return true;
}

bool Section::text(std::string_view key, std::string& target, const char* expected, Need need) {
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, expected);
    return false;
  }
  const auto* given = node->as_string();
  if (given == nullptr) {
    wrong_type(*node, key, expected);
    return false;
  }
  if (!is_one_line(given->get())) {
    const char* fault = given->get().empty() ? " is empty" : " holds control characters or is too long";
    wrong(key, in_quotes(key) + fault + ": expected " + expected);
    return false;
  }
  target = given->get();
  return true;
}

const toml::table* Section::table(std::string_view key, const char* expected, Need need) {
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, expected);
    return nullptr;
  }
  if (!node->is_table()) wrong_type(*node, key, expected);
  return node->as_table();
}

const toml::array* Section::array(std::string_view key, const char* expected, Need need) {
  const toml::node* node = value(key);
  if (node == nullptr) {
    if (need == Need::required) missing(key, expected);
    return nullptr;
  }
  if (!node->is_array()) wrong_type(*node, key, expected);
  return node->as_array();
}

bool Section::interval(std::string_view key, double& low, double& high, const char* expected, Ends ends) {
  const toml::array* both = array(key, expected);
  if (both == nullptr) return false;
  if (both->size() != 2 || !both->get(0)->is_number() || !both->get(1)->is_number()) {
    wrong(key, in_quotes(key) + " is not two numbers: expected " + expected + decimal_comma_hint(*both));
    return false;
  }
  const auto number = [both](std::size_t i) { return both->get(i)->value<double>().value_or(std::nan("")); };
  const double first = number(0), second = number(1);
  const bool finite = std::isfinite(first) && std::isfinite(second);
  const bool open = ends == Ends::one_may_be_open && (std::isfinite(first) || std::isfinite(second));
  if ((finite || open) && first < second) {
    low = first;
    high = second;
    return true;
  }
  wrong(key, in_quotes(key) + " is [" + number_text(first) + ", " + number_text(second) + "]: expected " +
                 (finite || open                  ? ""
                  : ends == Ends::one_may_be_open ? "a number on one side at least, "
                                                  : "two finite numbers, ") +
                 expected);
  return false;
}

const toml::node* Section::value(std::string_view key) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  return table_->get(key);
}

void Section::wrong(std::string_view key, std::string message) { mistakes_->add(where(key), std::move(message)); }

void Section::wrong_type(const toml::node& node, std::string_view key, std::string_view expected) {
  wrong(key, in_quotes(key) + " is " + type_name(node) + ": expected " + std::string(expected));
}

void Section::missing(std::string_view key, std::string_view expected) {
  mistakes_->add(where(), title_ + " has no " + in_quotes(key) + ": expected " + std::string(expected));
}

std::vector<std::pair<std::string, const toml::node*>> Section::rest() const {
  std::vector<std::pair<std::string, const toml::node*>> out;
  for (const auto& [key, node] : *table_) {
    if (std::find(asked_.begin(), asked_.end(), key.str()) == asked_.end()) out.emplace_back(key.str(), &node);
  }
  return out;
}

void Section::refuse_rest() {
  for (const auto& [key, node] : rest()) refuse(key);
}

void Section::refuse(std::string_view key) {
  if (mistakes_->full()) return mistakes_->add({}, {});
  std::string message = "unknown key " + in_quotes(key) + " in " + title_ + ": ";
  std::vector<std::string> not_given;
  for (const std::string& name : asked_) {
    if (peek(name) == nullptr) not_given.push_back(name);
  }
  if (const std::string near = nearest_name(key, not_given); !near.empty()) {
    message += "did you mean \"" + near + "\"?";
  } else {
    message += "expected ";
    for (std::size_t i = 0; i < asked_.size(); ++i) message += (i == 0 ? "" : ", ") + asked_[i];
  }
  mistakes_->add(where_key(key), std::move(message));
}

Position Section::where(std::string_view key) const {
  const toml::node* node = table_->get(key);
  return node == nullptr ? where() : position(*node);
}

Position Section::where_key(std::string_view key) const {
  const auto found = table_->find(key);
  if (found == table_->end()) return where();
  const auto begin = found->first.source().begin;
  return {std::max(1, static_cast<int>(begin.line)), std::max(1, static_cast<int>(begin.column))};
}

}  // namespace dwell::config
