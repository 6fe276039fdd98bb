#include "config/mistake.hpp"

#include <algorithm>
#include <cstdio>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/printable.hpp"

namespace dwell::config {
namespace {

// Cuts at a boundary between UTF-8 characters.
std::string shortened(std::string_view text, std::size_t most) {
  std::size_t end = std::min(text.size(), most);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0u) == 0x80u) --end;
  std::string out = dwell::printable(text.substr(0, end));
  if (end < text.size()) out += "...";
  return out;
}

// Edits that turn a into b: letters replaced, inserted, removed, or two neighbours swapped.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::string to_string(std::string_view file, const Mistake& mistake) {
  std::string out(file);
  for (const int number : {mistake.line, mistake.column}) {
    if (number > 0) out.append(1, ':').append(std::to_string(number));
  }
  return out.append(": ").append(mistake.message);
}

std::string to_string(std::string_view file, const Mistakes& mistakes) {
  std::string out;
  for (const Mistake& mistake : mistakes) out += to_string(file, mistake) + "\n";
  return out;
}

void MistakeList::add(Position at, std::string message) {
  if (full()) {
    ++left_out_;
  } else {
    found_.push_back({at.line, at.column, std::move(message)});
  }
}

Mistakes MistakeList::sorted() && {
  const auto key = [](const Mistake& m) { return std::tie(m.line, m.column, m.message); };
  std::stable_sort(found_.begin(), found_.end(), [&](const Mistake& a, const Mistake& b) { return key(a) < key(b); });
  const auto same = [&](const Mistake& a, const Mistake& b) { return key(a) == key(b); };
  found_.erase(std::unique(found_.begin(), found_.end(), same), found_.end());
  if (left_out_ > 0) {
    const Mistake last = found_.back();
    found_.push_back({last.line, last.column, "and " + std::to_string(left_out_) + " further mistakes"});
  }
  return std::move(found_);
}

std::string in_quotes(std::string_view text) {
  std::string out(1, '"');
  out += shortened(text, 60);
  out += '"';
  return out;
}

std::string one_line(std::string_view text) { return shortened(text, 300); }

std::string number_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.10g", number);
  return text;
}

std::string nearest_name(std::string_view wrong, const std::vector<std::string>& names, std::size_t edits) {
  if (wrong.size() > 64) return {};
  std::string nearest;
  std::size_t least = edits + 1;
  for (const std::string& name : names) {
    if (name.size() > 64 || name.size() + edits < wrong.size() || wrong.size() + edits < name.size()) continue;
    const std::size_t distance = edit_distance(wrong, name);
    // Of a short name half of the letters must be right.
    if (distance < least && 2 * distance <= std::min(wrong.size(), name.size())) {
      least = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace dwell::config
