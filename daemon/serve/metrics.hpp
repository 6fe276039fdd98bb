// What GET /metrics answers: the service as Prometheus reads it. Names and labels: dwelld(8). Pure; allocates.
//
// Every label's value comes from the rig file or from a fixed list, so the rig bounds the number of series. A number
// that is withheld or stale is absent, and dwell_element_standing says why: no alert rests on an old number.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/serve/exposition.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

[[nodiscard]] std::string metrics_text(const ServiceView& now);

// Its parts: the measurement; what delivers the readings; the service itself.
void write_measurement_metrics(const ServiceView& now, Exposition& out);
void write_intake_metrics(const ServiceView& now, Exposition& out);
void write_service_metrics(const ServiceView& now, Exposition& out);

// A count as a sample's value: exact up to 2⁵³, which takes 285 000 years at 1 kHz.
[[nodiscard]] inline double count_value(std::uint64_t count) noexcept { return static_cast<double>(count); }

// The samples of a state metric: one for each of `all`, 1 for the one that holds and 0 for the others. Each has
// `labels` as well.
template <class State, class All>
void write_states(Exposition& out, const char* label, State holds, const All& all,
                  const Exposition::Labels& labels = {}) {
  for (const State state : all) {
    Exposition::Labels with = labels;
    with.emplace_back(label, to_string(state));
    out.sample(state == holds ? 1.0 : 0.0, with);
  }
}

}  // namespace dwell
