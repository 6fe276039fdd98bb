// The command lines of export and report.
#pragma once

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/handon_commands.hpp"

namespace dwell::ctl {

class Verbs;

class HandonVerbs {
 public:
  // Outlives `verbs`.
  explicit HandonVerbs(Verbs& verbs);
  HandonVerbs(const HandonVerbs&) = delete;
  HandonVerbs& operator=(const HandonVerbs&) = delete;

 private:
  void add_export(Verbs& verbs);
  void add_report(Verbs& verbs);
  [[nodiscard]] int do_export();

  bool model_ = false;
  ExportOptions model_options_;
  ExportRunOptions exporting_;
  ReportOptions reporting_;
};

}  // namespace dwell::ctl
