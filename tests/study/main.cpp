// dwell_study: how good the estimator is, on random rigs, against what it ought to reach. See --help.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "tests/study/figures.hpp"
#include "tests/study/pool.hpp"

namespace dwell::study {
namespace {

struct Options {
  std::vector<std::string> names;
  int dwells = 0;
  std::uint64_t seed = 1;
  bool is_short = false, list_bad = false;
  int only = -1;
};

const std::map<std::string, Population>& populations() {
  static const std::map<std::string, Population> all = [] {
    std::map<std::string, Population> by_name;
    for (int p = 0; p <= static_cast<int>(Population::coarse); ++p)
      by_name[name_of(static_cast<Population>(p))] = static_cast<Population>(p);
    return by_name;
  }();
  return all;
}

int run(const Options& options) {
  std::vector<Population> wanted;
  for (const auto& [name, population] : populations())
    if (options.names.empty() || std::count(options.names.begin(), options.names.end(), name))
      wanted.push_back(population);
  std::sort(wanted.begin(), wanted.end());
  if (options.only >= 0) {
    const Case about = draw(wanted.front(), options.seed, options.only);
    std::puts(about.description().c_str());
    (void)play_dwell(about, [](const std::string& line) { std::puts(line.c_str()); });
    return 0;
  }
  const double slack = options.is_short ? 1.0 : 0.0;
  const int dwells = options.dwells > 0 ? options.dwells : options.is_short ? 60 : 5000;
  std::vector<Row> rows;
  std::vector<Outcome> all;
  std::vector<std::string> bad;
  for (const Population population : wanted) {
    std::vector<Outcome> outcomes(static_cast<std::size_t>(dwells));
    for_all(dwells, name_of(population),
            [&](int i) { outcomes[static_cast<std::size_t>(i)] = play_dwell(draw(population, options.seed, i)); });
    if (population == Population::white || population == Population::tracked) {
      const bool tracked = population == Population::tracked;
      rows.push_back(bound_row(outcomes, tracked ? 1.10 : 1.05, slack));
      rows.back().figure = tracked ? "rms error over the Cramer-Rao bound, frequency tracked from 1 % off"
                                   : "rms error over the Cramer-Rao bound, frequency given";
    }
    if (population != Population::tracked) rows.push_back(coverage_row(outcomes, population, slack));
    if (options.list_bad)
      for (std::string& line : worst(outcomes, population, options.seed)) bad.push_back(std::move(line));
    all.insert(all.end(), outcomes.begin(), outcomes.end());
  }
  for (Row& row : settling_rows(all, slack)) rows.push_back(std::move(row));
  print(rows);
  for (const std::string& line : bad) std::puts(line.c_str());
  return std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.met; }) ? 0 : 1;
}

}  // namespace
}  // namespace dwell::study

int main(int argc, char** argv) {
  dwell::study::Options options;
  CLI::App app("How good the estimator is on random rigs, as a table: what was reached, what is to be reached");
  std::vector<std::string> names;
  for (const auto& [name, population] : dwell::study::populations()) names.push_back(name);
  app.add_option("population", options.names, "what is studied; all where none is named")->check(CLI::IsMember(names));
  app.add_option("--dwells", options.dwells, "of each population")->check(CLI::PositiveNumber);
  app.add_option("--seed", options.seed, "another seed draws other rigs");
  app.add_flag("--short", options.is_short, "few dwells, generous bounds");
  app.add_flag("--list-bad", options.list_bad, "name the dwells that did worst by each figure");
  app.add_option("--only", options.only, "play this dwell alone and tell what happens");
  CLI11_PARSE(app, argc, argv);
  return dwell::study::run(options);
}
