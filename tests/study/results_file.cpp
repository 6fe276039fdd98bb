#include <cstdio>
#include <cstdlib>
#include <istream>
#include <ostream>
#include <sstream>

#include "tests/study/results.hpp"

namespace dwell::study {
namespace {

constexpr const char* kFirst = "dwell_study outcomes, seed";

// Every figure of an outcome, by name: the same walk writes and reads.
template <typename Visit>
void walk(ElementOutcome& e, Visit&& visit) {
  visit("reported", e.reported);
  visit("snr_d", e.snr_d);
  visit("snr_Z", e.snr_Z);
  visit("c_error", e.c_error);
  visit("r_error", e.r_error);
  visit("c_U95", e.c_U95);
  visit("r_U95", e.r_U95);
  visit("c_relative", e.c_relative);
  visit("r_relative", e.r_relative);
  visit("naive_c", e.naive_c);
  visit("naive_r", e.naive_r);
}

template <typename Visit>
void walk(Outcome& o, Visit&& visit) {
  visit("masses", o.masses);
  visit("settled", o.settled);
  visit("rearmed", o.rearmed);
  visit("completed", o.completed);
  visit("hum_inseparable", o.hum_inseparable);
  visit("hum_warned", o.hum_warned);
  visit("by_chance", o.by_chance);
  bool blamed = !o.blamed.empty();
  visit("blamed", blamed);
  if (blamed && o.blamed.empty()) o.blamed = "blamed";
  visit("tau_periods", o.tau_periods);
  visit("period_s", o.period_s);
  visit("verdict_s", o.verdict_s);
  visit("oracle_s", o.oracle_s);
  visit("left", o.left);
  visit("naive_answer_s", o.naive_answer_s);
  visit("counted_periods", o.counted_periods);
  visit("answer_s", o.answer_s);
  auto elements = static_cast<long>(o.elements.size());
  visit("elements", elements);
  o.elements.resize(static_cast<std::size_t>(std::min(elements, 1000L)));
  for (ElementOutcome& element : o.elements) walk(element, visit);
}

template <typename Visit>
void walk(StepOutcome& o, Visit&& visit) {
  visit("measured", o.measured);
  visit("disturbed", o.disturbed);
  visit("seen_periods", o.seen_periods);
  visit("limit_periods", o.limit_periods);
}

template <typename Visit>
void walk(HoursOutcome& o, Visit&& visit) {
  visit("hours", o.hours);
  visit("rearmed", o.rearmed);
}

template <typename Visit>
void walk(RampsOutcome& o, Visit&& visit) {
  visit("found", o.found);
  visit("beyond", o.beyond);
}

template <typename Visit>
void walk(DisturbedOutcome& o, Visit&& visit) {
  auto kinds = static_cast<long>(o.kinds.size());
  visit("kinds", kinds);
  o.kinds.resize(static_cast<std::size_t>(std::min(kinds, 10L)));
  for (Kind& kind : o.kinds) {
    auto number = static_cast<int>(kind);
    visit("kind", number);
    kind = static_cast<Kind>(number);
  }
  visit("counts", o.counts);
  visit("covered", o.covered);
  visit("harmless", o.harmless);
  visit("settled", o.settled);
  visit("reported", o.reported);
  visit("trusted", o.trusted);
  visit("warned", o.warned);
  visit("worst", o.worst);
  visit("worst_silent", o.worst_silent);
  visit("doubted", o.doubted);
  visit("told_beside", o.told_beside);
  visit("told_live", o.told_live);
  visit("moved", o.moved);
}

struct Writer {
  std::ostream& out;
  template <typename Number>
  void operator()(const char* name, Number& value) const {
    char buffer[40];
    std::snprintf(buffer, sizeof buffer, " %.17g", static_cast<double>(value));
    out << ' ' << name << buffer;
  }
};

struct Reader {
  std::istream& in;
  std::string& wrong;
  template <typename Number>
  void operator()(const char* name, Number& value) const {
    std::string found, number;
    if (!wrong.empty()) return;
    char* end = nullptr;
    if (!(in >> found >> number) || found != name)
      wrong = "expected " + std::string(name) + ", found " + (found.empty() ? "the end of the line" : found);
    else if (const double read = std::strtod(number.c_str(), &end); *end != '\0')
      wrong = "expected a number as " + std::string(name) + ", found " + number;
    else
      value = static_cast<Number>(read);
  }
};

template <typename One>
void write_all(std::ostream& out, Population population, const std::vector<One>& outcomes) {
  for (One outcome : outcomes) {
    out << name_of(population) << ' ' << outcome.index;
    walk(outcome, Writer{out});
    out << '\n';
  }
}

template <typename One>
std::string read_one(std::istream& in, std::vector<One>& outcomes) {
  One outcome;
  std::string wrong, rest;
  if (!(in >> outcome.index)) return "expected the dwell's index";
  walk(outcome, Reader{in, wrong});
  if (wrong.empty() && in >> rest) wrong = "expected the end of the line, found " + rest;
  outcomes.push_back(std::move(outcome));
  return wrong;
}

std::string read_line(const std::string& line, Results& results) {
  std::istringstream in(line);
  std::string name;
  in >> name;
  for (int p = 0; p < kPopulations; ++p) {
    const auto population = static_cast<Population>(p);
    if (name != name_of(population)) continue;
    switch (population) {
      case Population::amplitude_step:
      case Population::frequency_step:
      case Population::small_step:
      case Population::stop:
        return read_one(in, results.steps[population]);
      case Population::steady:
        return read_one(in, results.hours);
      case Population::ramps:
        return read_one(in, results.ramps);
      case Population::disturbed:
        return read_one(in, results.disturbed);
      default:
        return read_one(in, results.begun[population]);
    }
  }
  return "expected a population, found " + name;
}

}  // namespace

void write(std::ostream& out, const Results& results) {
  out << kFirst << ' ' << results.seed << '\n';
  for (const auto& [population, outcomes] : results.begun) write_all(out, population, outcomes);
  for (const auto& [population, outcomes] : results.steps) write_all(out, population, outcomes);
  write_all(out, Population::steady, results.hours);
  write_all(out, Population::ramps, results.ramps);
  write_all(out, Population::disturbed, results.disturbed);
}

std::string read(std::istream& in, Results& results) {
  std::string line;
  std::getline(in, line);
  if (line.rfind(kFirst, 0) != 0) return "line 1: expected \"" + std::string(kFirst) + " N\"";
  results.seed = std::strtoull(line.c_str() + std::string(kFirst).size(), nullptr, 10);
  for (int number = 2; std::getline(in, line); ++number)
    if (std::string wrong = read_line(line, results); !wrong.empty())
      return "line " + std::to_string(number) + ": " + wrong;
  return {};
}

}  // namespace dwell::study
