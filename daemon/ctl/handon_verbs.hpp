// The command lines of export and report.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/handon_commands.hpp"

namespace dwell::ctl {

class HandonVerbs {
 public:
  // Outlives `app`.
  explicit HandonVerbs(CLI::App& app);
  HandonVerbs(const HandonVerbs&) = delete;
  HandonVerbs& operator=(const HandonVerbs&) = delete;

  // Call after the command line was parsed. Runs the verb and returns its exit code; nullopt: it is another verb.
  [[nodiscard]] std::optional<int> run();

 private:
  void add_export(CLI::App& app);
  void add_report(CLI::App& app);

  CLI::App* export_ = nullptr;
  CLI::App* report_ = nullptr;
  bool model_ = false;
  ExportOptions model_options_;
  ExportRunOptions exporting_;
  ReportOptions reporting_;
};

}  // namespace dwell::ctl
