#include "daemon/ctl/result_comparison.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

constexpr double kTiny = 1e-300;  // least size for a relative difference: below it numbers count as zero

double real(const Json& object, std::string_view name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_number() ? found->get<double>() : kNaN;
}

// The member of the same object that holds a number's standard uncertainty; empty: it has none.
std::string_view uncertainty_of(std::string_view member) {
  struct Pair {
    std::string_view member, u;
  };
  static constexpr std::array<Pair, 8> pairs{{{"value", "u"},
                                              {"U95", "u"},
                                              {"amplitude", "u_amplitude"},
                                              {"phase_rad", "u_phase_rad"},
                                              {"mean", "u_amplitude"},
                                              {"harmonics", "u_amplitude"},
                                              {"u", "u"},
                                              {"u_amplitude", "u_amplitude"}}};
  for (const Pair& pair : pairs)
    if (pair.member == member) return pair.u;
  if (member.substr(0, 2) == "u_") return member;
  return {};
}

// Durations that the pipeline estimates; every other "…_s" is an instant.
bool is_instant(std::string_view member) {
  const bool seconds = member.size() > 2 && member.substr(member.size() - 2) == "_s";
  return seconds && member.substr(0, 6) != "memory" && member != "settles_in_s";
}

bool is_share(std::string_view member) { return member == "stiffness_share" || member == "damping_share"; }

// Members that only later programs tell, by the list whose entries have them. They say in fields what a text beside
// them says as well: a result that was stored without them lacks nothing. path: of the object that has the member.
bool came_later(std::string_view path, std::string_view member) {
  struct Later {
    std::string_view list, member;  // list empty: any object
  };
  static constexpr std::array<Later, 6> later{{{"budget", "kind"},
                                               {"budget", "channel"},
                                               {"budget", "device"},
                                               {"budget", "mass"},
                                               {"limits", "doubted"},
                                               {"", "warned"}}};
  const std::string_view list = path.substr(0, path.rfind('['));  // "elements[0].budget[2]": that ends with its name
  return std::any_of(later.begin(), later.end(), [&](const Later& one) {
    return one.member == member && (one.list.empty() || list.ends_with(one.list));
  });
}

// What the difference of a number is measured in.
struct Scale {
  double u = kNaN;        // its standard uncertainty; NaN: none
  double allowed = kNaN;  // difference that another build may make; NaN: a part of the number itself
};

Scale scale_of(const Json& object, std::string_view member) {
  Scale scale;
  std::string_view name = uncertainty_of(member);
  if (member == "amplitude" && object.find("u_amplitude") == object.end()) name = "u";  // of a deformation
  if (!name.empty()) scale.u = std::fabs(real(object, name));
  if (is_instant(member)) scale.allowed = kInstantTolerance_s;
  // A share of the whole variance; shares of negligible sources are rounding noise.
  if (is_share(member)) scale.allowed = kReplayTolerance;
  if (scale.u > 0.0) scale.allowed = kReplayTolerance * scale.u;
  return scale;
}

// A value in a few words, for it may be nested to any depth.
std::string in_words(const Json& value) {
  if (value.is_object()) return "an object";
  if (value.is_array()) return "an array";
  return dump(value);
}

class Walk {
 public:
  void values(const std::string& path, const Json& stored, const Json& replayed, const Scale& scale) {
    if (stored.is_number() && replayed.is_number()) return numbers(path, stored, replayed, scale);
    if (stored.type() != replayed.type()) return differ(path, in_words(stored), in_words(replayed));
    if (stored.is_object()) return objects(path, stored, replayed);
    if (stored.is_array()) return arrays(path, stored, replayed, scale);
    if (stored != replayed) differ(path, in_words(stored), in_words(replayed));
  }

  Comparison result;

 private:
  void objects(const std::string& path, const Json& stored, const Json& replayed) {
    const std::string front = path.empty() ? "" : path + ".";
    for (const auto& [name, value] : stored.items()) {
      const auto other = replayed.find(name);
      if (other == replayed.end()) {
        differ(front + name, in_words(value), "");
      } else if (name == "covariance" && value.is_array()) {
        covariances(front + name, value, *other);
      } else if (name == "budget" && sources(value) != sources(*other)) {
        budgets(front + name, value, *other);
      } else {
        values(front + name, value, *other, scale_of(stored, name));
      }
    }
    for (const auto& [name, value] : replayed.items())
      if (stored.find(name) == stored.end() && !came_later(path, name)) differ(front + name, "", in_words(value));
  }

  void arrays(const std::string& path, const Json& stored, const Json& replayed, const Scale& scale) {
    if (stored.size() != replayed.size())
      return differ(path, std::to_string(stored.size()) + " entries", std::to_string(replayed.size()) + " entries");
    for (std::size_t i = 0; i < stored.size(); ++i) values(at(path, i), stored[i], replayed[i], scale);
  }

  static std::vector<std::string> sources(const Json& budget) {
    std::vector<std::string> names;
    if (!budget.is_array()) return names;
    for (const Json& entry : budget) {
      const auto source = entry.is_object() ? entry.find("source") : entry.end();
      names.push_back(entry.is_object() && source != entry.end() && source->is_string() ? source->get<std::string>()
                                                                                        : "");
    }
    return names;
  }

  // A budget lists its sources by share and leaves out those without one. Rounding can therefore reorder or drop
  // negligible sources. So sources are matched by name, and a missing source has the share 0.
  void budgets(const std::string& path, const Json& stored, const Json& replayed) {
    const std::vector<std::string> a = sources(stored), b = sources(replayed);
    result.differences.push_back({path, "its order or sources", "others", kNaN, true});
    std::set<std::string> all(a.begin(), a.end());
    all.insert(b.begin(), b.end());
    const auto share = [](const Json& budget, const std::vector<std::string>& names, const std::string& source,
                          const char* of) {
      const auto at = std::find(names.begin(), names.end(), source);
      const double value = at == names.end() ? 0.0 : real(budget[static_cast<std::size_t>(at - names.begin())], of);
      return Json(std::isfinite(value) ? value : 0.0);
    };
    for (const std::string& source : all)
      for (const char* of : {"stiffness_share", "damping_share"})
        numbers(path + "[" + source + "]." + of, share(stored, a, source, of), share(replayed, b, source, of),
                {kNaN, kReplayTolerance});
  }

  // An entry C_ij is measured in √(C_ii·C_jj), which is u² on the diagonal.
  void covariances(const std::string& path, const Json& stored, const Json& replayed) {
    const auto sd = [&stored](std::size_t i) {
      const Json& row = stored[i];
      return row.is_array() && i < row.size() && row[i].is_number() ? std::sqrt(std::fabs(row[i].get<double>())) : kNaN;
    };
    if (!replayed.is_array() || stored.size() != replayed.size()) return values(path, stored, replayed, {});
    for (std::size_t i = 0; i < stored.size(); ++i) {
      const Json &row = stored[i], &other = replayed[i];
      if (!row.is_array() || !other.is_array() || row.size() != other.size() || row.size() != stored.size()) {
        values(at(path, i), row, other, {});
        continue;
      }
      for (std::size_t j = 0; j < row.size(); ++j) {
        const double u = sd(i) * sd(j);
        values(at(at(path, i), j), row[j], other[j], u > 0.0 ? Scale{u, kReplayTolerance * u} : Scale{});
      }
    }
  }

  void numbers(const std::string& path, const Json& stored, const Json& replayed, const Scale& scale) {
    ++result.numbers;
    const bool whole = stored.is_number_integer() && replayed.is_number_integer();
    const auto a = stored.get<double>(), b = replayed.get<double>();
    if (whole ? stored == replayed
              : stored.type() == replayed.type() && std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b))
      return;
    Difference difference{path, dump(stored), dump(replayed)};
    const double off = std::fabs(a - b);
    if (scale.u > 0.0) difference.in_u = off / scale.u;
    const double allowed =
        std::isfinite(scale.allowed) ? scale.allowed : kReplayTolerance * std::max({std::fabs(a), std::fabs(b), kTiny});
    difference.tolerable = !whole && off <= allowed;
    result.differences.push_back(std::move(difference));
  }

  void differ(const std::string& path, std::string stored, std::string replayed) {
    result.differences.push_back({path, std::move(stored), std::move(replayed)});
  }

  static std::string at(const std::string& path, std::size_t i) { return path + "[" + std::to_string(i) + "]"; }
};

// Where the string that begins at `at` ends: at its closing quotation mark, or at the end of the text.
std::size_t end_of_string(std::string_view json, std::size_t at) noexcept {
  std::size_t end = at + 1;
  while (end < json.size() && json[end] != '"') end += json[end] == '\\' ? 2 : 1;
  return end;
}

}  // namespace

std::uint64_t numbers_in(std::string_view json) noexcept {
  std::uint64_t numbers = 0;
  bool in_word = false;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const char c = json[i];
    if (c == '"') {
      i = end_of_string(json, i);
    } else {
      const bool begins = (c >= '0' && c <= '9') || c == '-';
      const bool separates = c == ',' || c == ':' || c == '[' || c == ']' || c == '{' || c == '}' || c <= ' ';
      if (begins && !in_word) ++numbers;
      in_word = !separates;
    }
  }
  return numbers;
}

tl::expected<Comparison, std::string> compare_results(std::string_view stored, std::string_view replayed) {
  const Json a = Json::parse(stored, nullptr, false), b = Json::parse(replayed, nullptr, false);
  if (!a.is_object()) return tl::unexpected(std::string("the stored result is not a JSON object"));
  if (!b.is_object()) return tl::unexpected(std::string("the replayed result is not a JSON object"));
  Walk walk;
  walk.values("", a, b, {});
  return std::move(walk.result);
}

}  // namespace dwell::ctl
