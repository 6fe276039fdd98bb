#include "tests/rigsim/control.hpp"

namespace rigsim {

std::vector<std::string> split_words(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r\n";
  std::vector<std::string> words;
  while (true) {
    const auto begin = line.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    const auto end = line.find_first_of(kBlank);
    words.emplace_back(line.substr(0, end));
    if (end == std::string_view::npos) return words;
    line.remove_prefix(end);
  }
}

std::optional<std::string> execute(Device& device, double t_s, const std::vector<std::string>& words) {
  // "drop" is the short form; a bare "reset" is an act of the server's, not the probability.
  const std::string verb = words[0] == "drop" ? "dropout" : words[0];
  if (!(verb == "reset" && words.size() == 1)) {
    for (const FaultName& fault : fault_names()) {
      if (verb != fault.name) continue;
      const auto value = words.size() == 2 ? number(words[1]) : std::nullopt;
      if (!value || *value < 0.0 || *value > fault.highest)
        return "error: expected: " + verb + " NUMBER, 0 ... " + std::to_string(fault.highest) + " (" + fault.help + ")";
      device.faults.*fault.member = *value;
      return "ok";
    }
  }
  if (auto wrong = device.command(t_s, words)) return wrong->empty() ? "ok" : "error: " + *wrong;
  return std::nullopt;
}

}  // namespace rigsim
