// Prometheus' text format, version 0.0.4: families of samples, each with its help and its type. Bound to one thread;
// allocates.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dwell {

inline constexpr const char* kExpositionType = "text/plain; version=0.0.4; charset=utf-8";

class Exposition {
 public:
  using Label = std::pair<std::string_view, std::string_view>;  // name, value
  using Labels = std::vector<Label>;

  // Begins a family; its samples follow. A family without samples leaves no trace. help: one line.
  void gauge(std::string_view name, std::string_view help) { begin(name, "gauge", help); }
  void counter(std::string_view name, std::string_view help) { begin(name, "counter", help); }

  // A sample of the family. A value that is not finite is left out: every comparison with NaN is false, so an alert
  // would stay silent. Bytes of a label's value that are not UTF-8 become U+FFFD.
  void sample(double value, const Labels& labels = {});

  [[nodiscard]] const std::string& text() const noexcept { return text_; }

 private:
  void begin(std::string_view name, std::string_view type, std::string_view help);

  std::string text_;
  std::string name_;  // of the family
  std::string head_;  // its help and its type; empty: already written
};

}  // namespace dwell
