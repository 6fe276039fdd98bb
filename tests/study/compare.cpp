#include <algorithm>
#include <cmath>
#include <map>

#include "tests/study/figures.hpp"
#include "tests/study/random.hpp"
#include "tests/study/results.hpp"

namespace dwell::study {
namespace {

constexpr int kRedraws = 1000;      // halved: the ends of an interval scatter by 8 % of its width instead of 5 %
constexpr std::uint64_t kSeed = 9;  // of the bootstrap

// Leaves the dwells that are in both, in the order of their indices.
template <typename One>
void match(std::vector<One>& a, std::vector<One>& b) {
  const auto by_index = [](const One& x, const One& y) { return x.index < y.index; };
  std::sort(a.begin(), a.end(), by_index);
  std::sort(b.begin(), b.end(), by_index);
  std::vector<One> in_a, in_b;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(in_a), by_index);
  std::set_intersection(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(in_b), by_index);
  a = std::move(in_a);
  b = std::move(in_b);
}

template <typename One>
void match(std::map<Population, std::vector<One>>& a, std::map<Population, std::vector<One>>& b) {
  for (auto& [population, outcomes] : a) match(outcomes, b[population]);
  for (auto& [population, outcomes] : b) match(outcomes, a[population]);
  std::erase_if(a, [](const auto& each) { return each.second.empty(); });
  std::erase_if(b, [](const auto& each) { return each.second.empty(); });
}

template <typename One>
void redraw(Draws& draws, const std::vector<One>& a, const std::vector<One>& b, std::vector<One>& to_a,
            std::vector<One>& to_b) {
  to_a.clear();
  to_b.clear();
  for (std::size_t i = 0; i < a.size(); ++i) {
    const auto at = static_cast<std::size_t>(draws.integer(0, static_cast<int>(a.size()) - 1));
    to_a.push_back(a[at]);
    to_b.push_back(b[at]);
  }
}

template <typename One>
void redraw(Draws& draws, const std::map<Population, std::vector<One>>& a,
            const std::map<Population, std::vector<One>>& b, std::map<Population, std::vector<One>>& to_a,
            std::map<Population, std::vector<One>>& to_b) {
  for (const auto& [population, outcomes] : a)
    redraw(draws, outcomes, b.at(population), to_a[population], to_b[population]);
}

// ∞ less ∞ is no difference.
double difference(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)) ? 0.0 : a - b; }

}  // namespace

std::string compare(const Results& given_before, const Results& given_after, std::vector<std::string>& lines,
                    bool& worse) {
  worse = false;
  Results before = given_before, after = given_after;
  if (before.seed != after.seed)
    return text("the seeds are %llu and %llu: expected the same", static_cast<unsigned long long>(before.seed),
                static_cast<unsigned long long>(after.seed));
  match(before.begun, after.begun);
  match(before.steps, after.steps);
  match(before.hours, after.hours);
  match(before.ramps, after.ramps);
  match(before.disturbed, after.disturbed);
  const std::vector<Row> was = rows_of(before, 0), is = rows_of(after, 0);
  if (was.empty()) return "no dwell is in both";
  std::vector<std::vector<double>> differences(was.size()), costs(was.size());
  Draws draws(kSeed);
  Results a, b;
  for (int k = 0; k < kRedraws; ++k) {
    redraw(draws, before.begun, after.begun, a.begun, b.begun);
    redraw(draws, before.steps, after.steps, a.steps, b.steps);
    redraw(draws, before.hours, after.hours, a.hours, b.hours);
    redraw(draws, before.ramps, after.ramps, a.ramps, b.ramps);
    redraw(draws, before.disturbed, after.disturbed, a.disturbed, b.disturbed);
    const std::vector<Row> drawn_a = rows_of(a, 0), drawn_b = rows_of(b, 0);
    for (std::size_t i = 0; i < was.size(); ++i) {
      differences[i].push_back(difference(drawn_b[i].value, drawn_a[i].value));
      costs[i].push_back(difference(drawn_b[i].cost, drawn_a[i].cost));
    }
  }
  lines.push_back(text("Paired bootstrap, %d redraws, seed %llu; the interval is that of the difference, 95 %%.",
                       kRedraws, static_cast<unsigned long long>(kSeed)));
  lines.emplace_back("| before | after | difference | interval | of | is it worse | figure (target) |");
  lines.emplace_back("|--------|-------|------------|----------|----|-------------|-----------------|");
  for (std::size_t i = 0; i < was.size(); ++i) {
    const bool is_worse = quantile(costs[i], 0.025) > 0, is_better = quantile(costs[i], 0.975) < 0;
    worse = worse || is_worse;
    lines.push_back(text("| %s | %s | %.3g | %.3g … %.3g | %ld | %s | ", was[i].reached.c_str(), is[i].reached.c_str(),
                         difference(is[i].value, was[i].value), quantile(differences[i], 0.025),
                         quantile(differences[i], 0.975), is[i].count,
                         is_worse    ? "WORSE"
                         : is_better ? "better"
                                     : "no") +
                    is[i].figure + " (" + is[i].target + ") |");
  }
  return {};
}

}  // namespace dwell::study
