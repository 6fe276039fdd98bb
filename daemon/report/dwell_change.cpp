#include "daemon/report/dwell_change.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace dwell {
namespace {

// The member that names an entry of these arrays; null: an array is told as a whole.
const char* name_of_entries(std::string_view array) {
  if (array == "phasors") return "channel";
  if (array == "elements") return "k";
  return nullptr;
}

bool is_left_out(std::string_view member) { return member == "covariance" || member == "budget"; }

bool same_members(const Json& a, const Json& b) {
  return std::equal(a.items().begin(), a.items().end(), b.items().begin(), b.items().end(),
                    [](const auto& x, const auto& y) { return x.key() == y.key(); });
}

std::optional<Json> members_that_differ(const Json& before, const Json& now);

// Of arrays whose entries have names; nullopt: these differ.
std::optional<Json> entries_that_differ(const Json& before, const Json& now, const char* name) {
  if (before.size() != now.size()) return std::nullopt;
  Json changed = Json::array();
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (before[i].value(name, Json()) != now[i].value(name, Json())) return std::nullopt;
    auto members = members_that_differ(before[i], now[i]);
    if (!members) return std::nullopt;
    if (members->empty()) continue;
    Json entry = {{name, now[i][name]}};
    entry.update(*members);
    changed.push_back(std::move(entry));
  }
  return changed;
}

// Of objects with the same members; nullopt: these differ.
std::optional<Json> members_that_differ(const Json& before, const Json& now) {
  if (!same_members(before, now)) return std::nullopt;
  Json changed = Json::object();
  for (auto was = before.begin(), is = now.begin(); is != now.end(); ++was, ++is) {
    if (is_left_out(is.key()) || *was == *is) continue;
    if (was->is_object() != is->is_object()) return std::nullopt;  // one that has come has parts that are left out
    const char* const name = name_of_entries(is.key());
    std::optional<Json> inner = *is;
    if (is->is_object() && was->is_object()) {
      inner = members_that_differ(*was, *is);
    } else if (name != nullptr) {
      inner = entries_that_differ(*was, *is, name);
    }
    if (!inner) return std::nullopt;
    if (name == nullptr || !inner->empty()) changed[is.key()] = std::move(*inner);
  }
  return changed;
}

bool merge(Json& target, const Json& change);

bool merge_entries(Json& target, const Json& change, const char* name) {
  if (!target.is_array()) return false;
  for (const Json& entry : change) {
    if (!entry.is_object() || !entry.contains(name)) return false;
    const auto found = std::find_if(target.begin(), target.end(), [&](const Json& candidate) {
      return candidate.is_object() && candidate.value(name, Json()) == entry[name];
    });
    if (found == target.end() || !merge(*found, entry)) return false;
  }
  return true;
}

bool merge(Json& target, const Json& change) {
  for (const auto& [key, value] : change.items()) {
    const auto member = target.find(key);
    if (member == target.end()) return false;
    const char* const name = name_of_entries(key);
    if (name != nullptr) {
      if (!value.is_array() || !merge_entries(*member, value, name)) return false;
    } else if (value.is_object() && member->is_object()) {
      if (!merge(*member, value)) return false;
    } else {
      *member = value;
    }
  }
  return true;
}

constexpr std::array kIdentity = {"index", "state"};

}  // namespace

std::optional<Json> change_between(const Json& before, const Json& now) {
  Json change = Json::object();
  for (const char* member : kIdentity) {
    if (!now.contains(member) || before.value(member, Json()) != now[member]) return std::nullopt;
    change[member] = now[member];
  }
  // That it has settled, or from when on the data count, is news as a change of state is.
  if (before.value("settled_s", Json()) != now.value("settled_s", Json())) return std::nullopt;
  const auto members = members_that_differ(before, now);
  if (!members) return std::nullopt;
  change.update(*members);
  return change;
}

bool apply_change(Json& dwell, const Json& change) {
  if (!dwell.is_object() || !change.is_object()) return false;
  for (const char* member : kIdentity)
    if (!change.contains(member) || !dwell.contains(member) || dwell[member] != change[member]) return false;
  Json merged = dwell;
  if (!merge(merged, change)) return false;
  dwell = std::move(merged);
  return true;
}

}  // namespace dwell
