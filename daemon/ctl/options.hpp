// Options of the command line that several verbs have, each with one wording. Heavy: include it in .cpp only.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/record/words.hpp"

namespace dwell::ctl {

inline CLI::Option* add_json(CLI::App* verb, bool& json) { return verb->add_flag("--json", json, "print JSON"); }

inline void add_service(CLI::App* verb, Service& service) {
  verb->add_option("--url", service.url, "address of the service's HTTP interface")
      ->envname("DWELL_URL")
      ->capture_default_str();
  verb->add_option("--token-file", service.token_file,
                   "holds the token that the service asks for from another computer")
      ->envname("DWELL_TOKEN_FILE");
  add_json(verb, service.json);
}

inline void add_control(CLI::App* verb, Service& service) {
  verb->add_option("--control", service.control, "the service's control socket")
      ->envname("DWELL_CONTROL")
      ->capture_default_str();
}

// The keys that a verb trusts: pinned_keys() reads them.
inline CLI::Option* add_pinned_keys(CLI::App* verb, std::vector<std::string>& keys) {
  return verb
      ->add_option("--key", keys,
                   "the key that must have signed: a vkey, or a file that holds it; repeated: one of them")
      ->allow_extra_args(false);
}

inline void add_persons(CLI::App* verb, std::vector<std::string>& persons) {
  verb->add_option("--person", persons,
                   "a person's public key that you trust: a vkey, or a file with vkeys, one a line; may be repeated")
      ->allow_extra_args(false);
}

// A text for the record, of at most so many bytes.
inline CLI::Option* add_text(CLI::App* verb, const std::string& name, std::string& text, std::size_t most,
                             const std::string& help) {
  return verb->add_option(name, text, help + "; at most " + std::to_string(most) + " bytes")
      ->check([most](const std::string& given) { return record::why_not_words(given, most); }, "");
}

inline CLI::Option* add_ledger(CLI::App* verb, std::string& ledger) {
  return verb->add_option("--ledger", ledger, "the ledger that knows all runs: shows what was removed");
}

}  // namespace dwell::ctl
