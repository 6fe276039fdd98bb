#include "tests/rigsim/truth.hpp"

#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <vector>

#include "core/model/forward.hpp"

namespace rigsim {
namespace {

void write_list(std::ostream& out, const char* name, const std::vector<double>& values) {
  out << ",\"" << name << "\":[";
  for (std::size_t i = 0; i < values.size(); ++i) out << (i > 0 ? "," : "") << values[i];
  out << ']';
}

void write_phasor(std::ostream& out, const char* unit, dwell::Phasor Y) {
  out << R"(","unit":")" << unit << R"(","amplitude":)" << std::abs(Y) << R"(,"phase_rad":)" << std::arg(Y) << '}';
}

}  // namespace

std::string truth_json(const dwell::Chain& chain, const dwell::Drive& drive) {
  const bool clamped = chain.boundary == dwell::Boundary::clamped;
  const auto steady = dwell::steady_response(chain, 2.0 * std::numbers::pi * drive.frequency_hz, drive.amplitude);
  const double decay = dwell::slowest_decay_rate(chain);
  std::ostringstream out;
  out << std::setprecision(17) << R"({"boundary":")" << (clamped ? "clamped" : "free") << '"';
  write_list(out, "masses", chain.masses);
  write_list(out, "stiffness", chain.stiffness);
  write_list(out, "damping", chain.damping);
  out << R"(,"frequency_hz":)" << drive.frequency_hz << R"(,"offset":)" << drive.offset << R"(,"slowest_decay_per_s":)";
  if (std::isfinite(decay))
    out << decay;
  else
    out << "null";
  out << R"(,"phasors":[)";
  for (std::size_t k = 0; k < steady.Y.size(); ++k) {
    out << (k > 0 ? "," : "") << R"({"channel":"y)" << k;
    write_phasor(out, "m", steady.Y[k]);
  }
  if (clamped) {
    out << R"(,{"channel":"reaction)";
    write_phasor(out, "N", steady.F);
  }
  out << "]}";
  return out.str();
}

}  // namespace rigsim
