#include "daemon/report/model_files.hpp"

#include <Eigen/Core>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>

#include "daemon/report/verification_json.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Symmetric band of a chain: element e joins place e to place e + 1, place 0 the table, n + 1 the ground.
MatrixXd assembled(const std::vector<double>& coefficients, Index n) {
  MatrixXd out = MatrixXd::Zero(n, n);
  for (Index e = 0; e < static_cast<Index>(coefficients.size()); ++e) {
    const double value = coefficients[static_cast<std::size_t>(e)];
    if (e > 0) out(e - 1, e - 1) += value;
    if (e < n) out(e, e) += value;
    if (e > 0 && e < n) out(e, e - 1) = out(e - 1, e) = -value;
  }
  return out;
}

std::string exact(double value) {
  std::array<char, 40> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  return {text.data(), end};
}

std::string matrix_market(const MatrixXd& matrix, const std::string& unit) {
  std::string entries;
  int count = 0;
  for (Index j = 0; j < matrix.cols(); ++j)
    for (Index i = j; i < matrix.rows(); ++i) {
      if (matrix(i, j) == 0.0) continue;
      entries += std::to_string(i + 1) + " " + std::to_string(j + 1) + " " + exact(matrix(i, j)) + "\n";
      ++count;
    }
  return "%%MatrixMarket matrix coordinate real symmetric\n% unit: " + unit + "\n" + std::to_string(matrix.rows()) +
         " " + std::to_string(matrix.cols()) + " " + std::to_string(count) + "\n" + entries;
}

Json rows(const MatrixXd& matrix) {
  Json out = Json::array();
  for (Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    out.push_back(std::move(row));
  }
  return out;
}

struct Coefficients {
  std::vector<double> stiffness, damping;
};

Json state_space(const Rig& rig, const Coefficients& of, const MatrixXd& D, const MatrixXd& K) {
  const Index n = rig.mass_count();
  const VectorXd m = Eigen::Map<const VectorXd>(rig.masses.data(), n);
  const bool clamped = rig.boundary == Boundary::clamped;
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n), B = MatrixXd::Zero(2 * n, 2);
  MatrixXd C = MatrixXd::Zero(n + (clamped ? 1 : 0), 2 * n), through = MatrixXd::Zero(C.rows(), 2);
  if (n > 0) {
    A.topRightCorner(n, n).setIdentity();
    A.bottomLeftCorner(n, n) = -(m.cwiseInverse().asDiagonal() * K);
    A.bottomRightCorner(n, n) = -(m.cwiseInverse().asDiagonal() * D);
    B(n, 0) = of.stiffness.front() / m(0);
    B(n, 1) = of.damping.front() / m(0);
    C.leftCols(n).topRows(n).setIdentity();
  }
  if (clamped && n > 0) {
    C(n, n - 1) = of.stiffness.back();
    C(n, 2 * n - 1) = of.damping.back();
  } else if (clamped) {
    through(0, 0) = of.stiffness.front();
    through(0, 1) = of.damping.front();
  }
  const bool turns = rig.motion == Motion::rotation;
  const char *const y = turns ? "rad" : "m", *const v = turns ? "rad/s" : "m/s", *const f = turns ? "N*m" : "N";
  const auto signal = [](const std::string& name, const char* unit) { return Json{{"name", name}, {"unit", unit}}; };
  Json states = Json::array(), outputs = Json::array();
  for (Index k = 1; k <= n; ++k) outputs.push_back(signal("y_" + std::to_string(k), y));
  states = outputs;
  for (Index k = 1; k <= n; ++k) states.push_back(signal("y_" + std::to_string(k) + "'", v));
  if (clamped) outputs.push_back(signal("force on the ground", f));
  return {{"states", states},   {"inputs", Json::array({signal("y_0", y), signal("y_0'", v)})},
          {"outputs", outputs}, {"A", rows(A)},
          {"B", rows(B)},       {"C", rows(C)},
          {"D", rows(through)}};
}

// Where the coefficients were seen: beyond it they are an extrapolation.
Json validity(const Dwell& dwell) {
  Json deformations = Json::array();
  for (const ElementEstimate& element : dwell.elements)
    deformations.push_back({{"k", element.k}, {"deformation_amplitude", element.deformation.value}});
  return {{"frequency_hz", {{"value", dwell.frequency_hz.value}, {"u", dwell.frequency_hz.u}}},
          {"elements", deformations},
          {"note", "identified at this frequency and these amplitudes; elsewhere the coefficients are extrapolated"}};
}

}  // namespace

tl::expected<std::vector<ModelFile>, std::string> model_files(const Rig& rig, const RunInfo& run, const Dwell& dwell,
                                                              const Verification& verification) {
  Coefficients of;
  if (dwell.elements.empty()) return tl::make_unexpected("no coefficients: " + dwell.settling_reason);
  for (const ElementEstimate& element : dwell.elements) {
    if (!element.identifiable)
      return tl::make_unexpected("element " + std::to_string(element.k) + " is not identifiable: " + element.reason);
    of.stiffness.push_back(element.stiffness.value);
    of.damping.push_back(element.damping.value);
  }
  const Index n = rig.mass_count();
  const MatrixXd D = assembled(of.damping, n), K = assembled(of.stiffness, n);
  const bool turns = rig.motion == Motion::rotation;
  std::vector<ModelFile> files;
  if (n > 0)
    files = {{"mass.mtx",
              matrix_market(Eigen::Map<const VectorXd>(rig.masses.data(), n).asDiagonal(), turns ? "kg*m2" : "kg")},
             {"damping.mtx", matrix_market(D, damping_unit(rig.motion))},
             {"stiffness.mtx", matrix_market(K, stiffness_unit(rig.motion))}};
  const Json model = {{"rig", rig.name},
                      {"rig_sha256", run.rig_sha256},
                      {"version", run.version},
                      {"boundary", rig.boundary == Boundary::clamped ? "clamped" : "free"},
                      {"masses", rig.masses},
                      {"identified", json_value(make_view(dwell, rig, run))},
                      {"state_space", state_space(rig, of, D, K)},
                      {"validity", validity(dwell)},
                      {"verification", json_value(verification, rig, dwell)}};
  files.push_back({"model.json", dump(model, 1) + "\n"});
  return files;
}

}  // namespace dwell
