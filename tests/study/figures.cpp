#include "tests/study/figures.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dwell::study {
namespace {

constexpr double kCountedPeriods = 50.0;  // at least, for a figure against the bound
constexpr double kWellDetermined = 10.0;  // |Z| over its bound, at least

std::string disturbance_of(Population population) {
  switch (population) {
    case Population::white:
      return "white noise";
    case Population::type_b:
      return "type B errors drawn";
    case Population::quantized:
      return "quantized, noise of half a step or more";
    case Population::coarse:
      return "quantized, less noise than that";
    case Population::resonance:
      return "the drive at a natural frequency";
    case Population::knocks:
      return "knocks during settling";
    default:
      return name_of(population);
  }
}

}  // namespace

double quantile(std::vector<double> values, double part) {
  if (values.empty()) return NAN;
  const std::ptrdiff_t at = std::lround(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

double late_by(const Outcome& outcome, double periods, double taus) {
  if (!outcome.settled) return INFINITY;
  return outcome.lateness_s() / (outcome.period_s * std::max(periods, taus * outcome.tau_periods));
}

bool counts_for_bound(const Outcome& outcome, const ElementOutcome& element) {
  return outcome.completed && outcome.counted_periods >= kCountedPeriods && element.reported &&
         element.snr_Z > kWellDetermined * std::numbers::sqrt2;
}

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
  row.met = ratio <= target + 0.25 * slack;
  row.value = row.cost = ratio;
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
  row.figure = "truth inside the 95 % interval: " + disturbance_of(population);
  double low = 94, high = 96;
  if (population == Population::quantized) low = 93, high = 98;
  if (population == Population::coarse) low = 93, high = 100;
  row.target = high < 100 ? text("%.0f … %.0f %%", low, high) : text(">= %.0f %%", low);
  row.met = share >= low - 5 * slack && share <= high + 4 * slack;
  row.value = share;
  row.cost = std::max({0.0, low - share, share - high});
  if (excluded > 0) row.figure += text(" (inseparable hum: %ld, warned of %ld)", excluded, warned);
  return row;
}

std::vector<Row> settling_rows(const std::vector<Outcome>& outcomes, double slack) {
  long early = 0, never = 0;
  std::vector<double> median, tail;
  for (const Outcome& outcome : outcomes) {
    never += !outcome.settled;
    early += outcome.settled && outcome.left > 1;
    median.push_back(late_by(outcome, 4, 0.5));
    tail.push_back(late_by(outcome, 10, 1));
  }
  const auto count = static_cast<long>(outcomes.size());
  const double share = 100.0 * static_cast<double>(early) / static_cast<double>(count);
  const double half = quantile(median, 0.5), most = quantile(tail, 0.95);
  return {{"settled too early: transient left at the verdict above its threshold", text("%.2f %%", share), "<= 0.5 %",
           count, share <= 0.5 + 2 * slack, share, share},
          {text("lateness of the verdict, median, over max(4 periods, 0.5 tau) (never: %ld)", never),
           text("%.2f", half), "<= 1", count, half <= 1 + 0.25 * slack, half, half},
          {"lateness of the verdict, 95th percentile, over max(10 periods, tau)", text("%.2f", most), "<= 1", count,
           most <= 1 + slack, most, most}};
}

std::vector<Row> reported_rows(const std::vector<Outcome>& outcomes, double slack) {
  long unseen = 0, wrong = 0, plain = 0, withheld = 0;
  for (const Outcome& outcome : outcomes)
    for (const ElementOutcome& element : outcome.elements) {
      if (element.snr_d < 1) {
        ++unseen;
        wrong += element.reported;
      }
      // σ_Z of the complex number, as u(Z): √2 of each component.
      if (element.snr_d > 6 && element.snr_Z > 6 * std::numbers::sqrt2) {
        ++plain;
        withheld += !element.reported;
      }
    }
  const double share = 100.0 * static_cast<double>(withheld) / static_cast<double>(plain);
  return {{"elements reported although |d| is below its standard deviation", text("%ld", wrong), "0", unseen,
           wrong <= static_cast<long>(slack * 0.05 * static_cast<double>(unseen)), static_cast<double>(wrong),
           static_cast<double>(wrong)},
          {"elements withheld although |d| and |Z| exceed six of theirs", text("%.2f %%", share), "<= 5 %", plain,
           share <= 5 + 5 * slack, share, share}};
}

Row early_row(const std::vector<Outcome>& outcomes, Population population, double slack) {
  long early = 0, never = 0;
  std::vector<double> tail;
  for (const Outcome& outcome : outcomes) {
    never += !outcome.settled;
    early += outcome.settled && outcome.left > 1;
    tail.push_back(late_by(outcome, 10, 1));
  }
  const double share = 100.0 * static_cast<double>(early) / static_cast<double>(outcomes.size());
  Row row;
  row.figure = "settled too early: " + disturbance_of(population) +
               text(" (never: %ld; lateness, 95th percentile: %.2f)", never, quantile(tail, 0.95));
  row.reached = text("%.2f %%", share);
  row.target = "<= 0.5 %";
  row.count = static_cast<long>(outcomes.size());
  row.met = share <= 0.5 + 2 * slack;
  row.value = row.cost = share;
  return row;
}

Row late_row(const std::vector<Outcome>& outcomes, Population population, double slack) {
  long never = 0;
  std::vector<double> tail;
  for (const Outcome& outcome : outcomes) {
    never += !outcome.settled;
    tail.push_back(late_by(outcome, 10, 1));
  }
  const double most = quantile(tail, 0.95);
  Row row;
  row.figure = "lateness of the verdict, 95th percentile, over max(10 periods, tau): " + disturbance_of(population) +
               text(" (never within twice that: %ld)", never);
  row.reached = text("%.2f", most);
  row.target = "<= 1";
  row.count = static_cast<long>(outcomes.size());
  row.met = most <= 1 + slack;
  row.value = row.cost = most;
  return row;
}

std::vector<Row> blamed_rows(const std::vector<Outcome>& outcomes, double slack) {
  const long blamed =
                 std::count_if(outcomes.begin(), outcomes.end(), [](const Outcome&o) { return !o.blamed.empty(); }),
             by_chance = std::count_if(outcomes.begin(), outcomes.end(), [](const Outcome&o) { return o.by_chance; });
  const auto count = static_cast<long>(outcomes.size());
  return {{"healthy dwells (white, tracked, type B, quantized) that blame a channel, an element or the drive",
           text("%ld", blamed), "<= 1 in 1000", count,
           static_cast<double>(blamed) <= (1e-3 + 0.02 * slack) * static_cast<double>(count),
           static_cast<double>(blamed), static_cast<double>(blamed)},
          {"  … that withhold an element whose coefficient comes out negative, and say that chance may have made it so",
           text("%ld", by_chance), "", count, true, static_cast<double>(by_chance), static_cast<double>(by_chance)}};
}

Row step_row(const std::vector<StepOutcome>& outcomes, Population population, double slack) {
  long measured = 0, in_time = 0;
  for (const StepOutcome& outcome : outcomes) {
    if (!outcome.measured) continue;
    ++measured;
    in_time += outcome.seen_periods <= outcome.limit_periods;
  }
  Row row;
  switch (population) {
    case Population::amplitude_step:
      row.figure = "re-armed within two periods of an amplitude step";
      break;
    case Population::frequency_step:
      row.figure = "re-armed within two periods of a frequency step";
      break;
    case Population::small_step:
      row.figure = "re-armed by a smaller amplitude step once it has reached nine standard deviations";
      break;
    default:
      row.figure = "idle within three periods of the drive's stop";
  }
  row.reached = text("%ld", in_time);
  row.target = "all";
  row.count = measured;
  const double wide = population == Population::small_step ? 0.9 : 0.1;
  row.met = static_cast<double>(in_time) >= (1 - wide * slack) * static_cast<double>(measured) &&
            10 * measured >= 9 * static_cast<long>(outcomes.size());
  row.value = static_cast<double>(in_time);
  row.cost = static_cast<double>(measured - in_time);
  return row;
}

Row hours_row(const std::vector<HoursOutcome>& outcomes, long others, double slack) {
  double hours = 0.0;
  long rearmed = others;
  for (const HoursOutcome& outcome : outcomes) hours += outcome.hours, rearmed += outcome.rearmed;
  return {"false re-arms, in so many hours measured of a steady drive, and in the dwells above",
          text("%ld", rearmed),
          "0",
          std::lround(hours),
          rearmed <= std::lround(5 * slack),
          static_cast<double>(rearmed),
          static_cast<double>(rearmed)};
}

Row ramps_row(const std::vector<RampsOutcome>& outcomes, double slack) {
  long found = 0, beyond = 0;
  for (const RampsOutcome& outcome : outcomes) found += outcome.found && !outcome.beyond, beyond += outcome.beyond;
  const double share = 100.0 * static_cast<double>(found) / static_cast<double>(outcomes.size());
  return {text("three periods between ramps found, nothing of the ramps in them (with some: %ld)", beyond),
          text("%.1f %%", share),
          ">= 95 %",
          static_cast<long>(outcomes.size()),
          share >= 95 - 45 * slack,
          share,
          -share};
}

std::vector<std::string> beside(const std::vector<Outcome>& outcomes) {
  std::vector<double> c, r, naive_c, naive_r, answer, naive_answer;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.completed) continue;
    answer.push_back(outcome.answer_s);
    naive_answer.push_back(outcome.naive_answer_s);
    for (const ElementOutcome& element : outcome.elements) {
      if (!element.reported) continue;
      c.push_back(element.c_relative);
      r.push_back(element.r_relative);
      naive_c.push_back(element.naive_c);
      naive_r.push_back(element.naive_r);
    }
  }
  const auto line = [](const char* what, const std::vector<double>& values, const std::vector<double>& script,
                       double factor, const char* unit) {
    std::string cells;
    for (const std::vector<double>* of : {&values, &script})
      for (const double part : {0.5, 0.95}) cells += text(" %11.3g %s |", factor * quantile(*of, part), unit);
    return text("| %-19s |", what) + cells;
  };
  return {"",
          text("Beside it, on the same %zu recordings, for the elements that are reported: a script that takes the "
               "channels as simultaneous,",
               answer.size()),
          "waits 10 s, transforms 1024 samples of the table's channel and as long of the others, and divides.",
          "",
          "|                     | median        | 95 % below    | its median    | 95 % below    |",
          "|---------------------|---------------|---------------|---------------|---------------|",
          line("error of c", c, naive_c, 100, "%"),
          line("error of r", r, naive_r, 100, "%"),
          line("time to that answer", answer, naive_answer, 1, "s")};
}

}  // namespace dwell::study
