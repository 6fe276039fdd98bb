// The verbs of the command line. Heavy: include it in .cpp only.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/commands.hpp"

namespace dwell::ctl {

class Verbs {
 public:
  // app: outlives this.
  explicit Verbs(CLI::App& app) : app_(app) { app.require_subcommand(1); }

  // Adds a verb; its options are the caller's to add. does: what it does, and its exit code. What that refers to must
  // live until run() returns.
  CLI::App* add(const std::string& name, const std::string& help, std::function<int()> does) {
    CLI::App* const verb = app_.add_subcommand(name, help);
    verbs_.emplace_back(verb, std::move(does));
    return verb;
  }
  // Does the verb that the parsed command line names. Returns its exit code.
  [[nodiscard]] int run() const {
    for (const auto& [verb, does] : verbs_)
      if (*verb) return does();
    return kUsage;
  }

 private:
  CLI::App& app_;
  std::vector<std::pair<CLI::App*, std::function<int()>>> verbs_;
};

}  // namespace dwell::ctl
