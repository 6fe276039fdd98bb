#include "tests/study/figures.hpp"

#include <algorithm>
#include <cmath>

namespace dwell::study {
namespace {

constexpr double kCountedPeriods = 50.0;  // at least, for a figure against the bound
constexpr double kWellDetermined = 10.0;  // |Z| over its bound, at least

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return NAN;
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double late_by(const Outcome& outcome, double periods, double taus) {
  if (!outcome.settled) return INFINITY;
  return outcome.lateness_s() / (outcome.period_s * std::max(periods, taus * outcome.tau_periods));
}

bool counts_for_bound(const Outcome& outcome, const ElementOutcome& element) {
  return outcome.completed && outcome.counted_periods >= kCountedPeriods && element.reported &&
         element.snr_Z > kWellDetermined;
}

}  // namespace

Row bound_row(const std::vector<Outcome>& outcomes, double target, double slack) {
  double squares = 0.0;
  long count = 0, dwells = 0;
  for (const Outcome& outcome : outcomes) {
    bool any = false;
    for (const ElementOutcome& element : outcome.elements)
      if (counts_for_bound(outcome, element)) {
        squares += element.c_error * element.c_error + element.r_error * element.r_error;
        count += 2;
        any = true;
      }
    dwells += any;
  }
  Row row;
  row.count = dwells;
  const double ratio = std::sqrt(squares / static_cast<double>(count));
  row.reached = text("%.3f", ratio);
  row.target = text("<= %.2f", target);
  row.met = ratio <= target + slack;
  return row;
}

Row coverage_row(const std::vector<Outcome>& outcomes, Population population, double slack) {
  long inside = 0, count = 0, dwells = 0, excluded = 0, warned = 0;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.completed) continue;
    if (outcome.hum_inseparable) {
      ++excluded;
      warned += outcome.hum_warned;
      continue;
    }
    ++dwells;
    for (const ElementOutcome& element : outcome.elements) {
      if (!element.reported) continue;
      inside += (std::abs(element.c_U95) <= 1) + (std::abs(element.r_U95) <= 1);
      count += 2;
    }
  }
  const double share = 100.0 * static_cast<double>(inside) / static_cast<double>(count);
  Row row;
  row.count = dwells;
  row.reached = text("%.1f %%", share);
  row.figure = text("truth inside the 95 %% interval: %s", name_of(population));
  double low = 94, high = 96;
  if (population == Population::quantized) low = 93, high = 98;
  if (population == Population::coarse) low = 93, high = 100;
  row.target = high < 100 ? text("%.0f … %.0f %%", low, high) : text(">= %.0f %%", low);
  row.met = share >= low - slack && share <= high + slack;
  if (excluded > 0) row.figure += text(" (inseparable hum: %ld, warned of %ld)", excluded, warned);
  return row;
}

std::vector<Row> settling_rows(const std::vector<Outcome>& outcomes, double slack) {
  long early = 0, settled = 0, never = 0;
  std::vector<double> median, tail;
  for (const Outcome& outcome : outcomes) {
    settled += outcome.settled;
    never += !outcome.settled;
    early += outcome.settled && outcome.left > 1;
    median.push_back(late_by(outcome, 4, 0.5));
    tail.push_back(late_by(outcome, 10, 1));
  }
  const auto count = static_cast<long>(outcomes.size());
  const double share = 100.0 * static_cast<double>(early) / static_cast<double>(count);
  const double half = quantile(median, 0.5), most = quantile(tail, 0.95);
  return {{"settled too early: transient left at the verdict above its threshold", text("%.2f %%", share), "<= 0.5 %",
           count, share <= 0.5 * (1 + slack)},
          {text("lateness of the verdict, median, over max(4 periods, 0.5 tau) (never: %ld)", never),
           text("%.2f", half), "<= 1", count, half <= 1 + 0.1 * slack},
          {"lateness of the verdict, 95th percentile, over max(10 periods, tau)", text("%.2f", most), "<= 1", count,
           most <= 1 + 0.5 * slack}};
}

std::vector<std::string> worst(const std::vector<Outcome>& outcomes, Population population, std::uint64_t seed) {
  struct Measure {
    const char* name;
    std::function<double(const Outcome&)> of;
  };
  const auto over_elements = [](const Outcome& outcome, const std::function<double(const ElementOutcome&)>& of) {
    double most = 0.0;
    for (const ElementOutcome& element : outcome.elements) most = std::max(most, of(element));
    return most;
  };
  const std::vector<Measure> measures = {
      {"transient left at the verdict over threshold", [](const Outcome& o) { return o.settled ? o.left : 0.0; }},
      {"lateness over max(10 periods, tau)", [](const Outcome& o) { return late_by(o, 10, 1); }},
      {"error over Cramer-Rao bound",
       [&](const Outcome& o) {
         return over_elements(o, [&](const ElementOutcome& e) {
           return counts_for_bound(o, e) ? std::max(std::abs(e.c_error), std::abs(e.r_error)) : 0.0;
         });
       }},
      {"error over U95",
       [&](const Outcome& o) {
         return over_elements(o,
                              [](const ElementOutcome& e) { return std::max(std::abs(e.c_U95), std::abs(e.r_U95)); });
       }},
      {"left measuring in a steady drive", [](const Outcome& o) { return o.rearmed ? 1.0 : 0.0; }}};
  std::vector<std::string> lines;
  for (const Measure& measure : measures) {
    std::vector<std::pair<double, int>> order;
    for (const Outcome& outcome : outcomes)
      if (const double bad = measure.of(outcome); bad > 0.5) order.emplace_back(bad, outcome.index);
    std::sort(order.rbegin(), order.rend());
    lines.push_back(text("%s, worst by %s:", name_of(population), measure.name));
    for (std::size_t i = 0; i < std::min<std::size_t>(10, order.size()); ++i)
      lines.push_back(text("  %6.3g  --only %d  ", order[i].first, order[i].second) +
                      draw(population, seed, order[i].second).description());
  }
  return lines;
}

}  // namespace dwell::study
