// The command lines of the verbs that look at run files and sign them.
#pragma once

#include <string>

#include "daemon/ctl/commands.hpp"

namespace CLI {
class Option;
}

namespace dwell::ctl {

class Verbs;

class RecordVerbs {
 public:
  // service: what `runs` and `sign` ask. It and this outlive `verbs`.
  RecordVerbs(Verbs& verbs, Service& service);
  RecordVerbs(const RecordVerbs&) = delete;
  RecordVerbs& operator=(const RecordVerbs&) = delete;

 private:
  AuditRequest auditing_;
  CLI::Option* ledger_ = nullptr;  // of audit
  SignOptions signing_;
  KeyOptions key_;
  std::string folder_, file_;
};

}  // namespace dwell::ctl
