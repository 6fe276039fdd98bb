#include "tests/ctl/sample_dwell.hpp"

#include <memory>

namespace dwell::test {

Rig sample_rig() {
  Rig rig;
  rig.name = "bench";
  rig.boundary = Boundary::clamped;
  rig.masses = {12.5, 8.0};
  Channel y0;
  y0.name = "y0";
  Channel a1;
  a1.name = "a1";
  a1.measures = Quantity::acceleration;
  a1.at = 1;
  Channel y2;
  y2.name = "y2";
  y2.at = 2;
  Channel force;
  force.name = "reaction";
  force.measures = Quantity::force;
  force.at = kGround;
  rig.channels = {y0, a1, y2, force};
  return rig;
}

RunInfo sample_run() { return {"ab12", "0.1.0", "2026-11-21T08:00:00Z"}; }

Dwell sample_dwell() {
  Dwell d;
  d.index = 1;
  d.state = State::measuring;
  d.start_s = 0.0;
  d.settled_s = 6.42;
  d.verdict_s = 7.1;
  d.end_s = 31.0;
  d.memory_time_s = 5.9;
  d.memory_time_predicted_s = 5.7;
  d.settling_reason = "0.2 % of the transient is left, 0.5 % allowed";
  d.frequency_hz = {4.0003, 2e-5};
  d.t_ref_s = 18.7;

  const auto phasor = [](double amplitude, double phase_rad, double u_amplitude, double u_phase_rad) {
    ChannelPhasor p;
    p.Y = std::polar(amplitude, phase_rad);
    p.u_amplitude = u_amplitude;
    p.u_phase_rad = u_phase_rad;
    p.u_relative_phase_rad = std::hypot(u_phase_rad, 2e-5);
    p.mean = 0.0012;
    p.harmonics = {0.002, 0.0007};
    p.sigma = 1e-6;
    p.samples = 12000;
    p.valid = true;
    return p;
  };
  d.phasors = {phasor(0.005, 0.25, 1e-7, 2e-5), phasor(4.2, -3.0, 1e-3, 2.4e-4), phasor(0.0, 0.0, 0.0, 0.0),
               phasor(86.3, -0.1, 0.05, 6e-4)};
  d.phasors[2] = ChannelPhasor{};
  d.phasors[2].samples = 512;
  d.phasors[2].reason = "stale: timeout";

  ElementEstimate e1;
  e1.k = 1;
  e1.identifiable = true;
  e1.deformation = {0.0021, 1e-7};
  e1.stiffness = {24010.0, 14.0, 3100.0, 27.4, true};
  e1.damping = {60.2, 0.4, 3100.0, 0.79, true};
  e1.loss_factor = {0.063, 0.0004};
  e1.budget = {{"scale of y1", 0.6, 0.1, SourceKind::scale, "y1"},
               {"delay of y0", 0.3, 0.85, SourceKind::delay, "y0"},
               {"noise of y1", 0.1, 0.05, SourceKind::noise, "y1"}};
  ElementEstimate e2;
  e2.k = 2;
  e2.reason = "the deformation is less than three times its uncertainty";
  e2.deformation = {2e-7, 1e-7};
  ElementEstimate e3 = e1;
  e3.k = 3;
  e3.stiffness = {1234567.0, 99.6, 3100.0, 195.0, true};
  e3.damping = {0.21, 0.4, 3100.0, 0.79, false};
  d.elements = {e1, e2, e3};
  d.covariance = {196.0, 0.1, 0.0, 0.0, 0.1, 0.16, 0.0, 0.0, 0.0, 0.0, 9920.16, 0.0, 0.0, 0.0, 0.0, 0.16};
  d.warnings = {{WarningKind::readings, "channel y2 is stale: timeout", {}, {"y2"}}};
  return d;
}

Dwell settling_dwell() {
  Dwell d;
  d.index = 2;
  d.state = State::settling;
  d.start_s = 40.0;
  d.settles_in_s = 3.25;
  d.settling_reason = "2.1 % of the transient of reaction is left, 0.5 % allowed";
  d.frequency_hz = {4.0, kNaN};
  d.phasors.resize(4);
  for (ChannelPhasor& p : d.phasors) p.reason = "too few samples";
  return d;
}

MotionEstimate sample_motion() {
  MotionEstimate m;
  m.start_s = 40.0;
  m.end_s = 43.2;
  m.elements = sample_dwell().elements;
  m.elements[0].stiffness = {24100.0, 300.0, 400.0, 590.0, true};
  m.elements[0].damping = {58.0, 4.0, 400.0, 7.9, true};
  m.elements[0].budget = {{"noise", 0.7, 0.9, SourceKind::other, {}}, {"scale of y1", 0.3, 0.1, SourceKind::other, {}}};
  m.elements[1].reason = "the readings do not determine it";
  m.covariance = sample_dwell().covariance;
  m.u_of_noise = {300.0, 4.0, kNaN, kNaN, 99.6, 0.4};
  m.channels = {{0, 1e-6, 1.02, 0.4, 0.001}, {1, 2e-3, 0.98, 0.2, 0.0}};
  m.readings = 2175;
  m.warnings = {"the residuals of y2 are not white: uncertainties are widened"};
  return m;
}

DwellView settling_view() {
  DwellView view = make_view(settling_dwell(), sample_rig(), sample_run());
  auto beside = std::make_shared<MotionView>(make_view(sample_motion(), {}, sample_rig()));
  beside->from_s = 39.25;
  beside->until_s = 43.2;
  beside->given = 2310;
  view.transient = beside;
  return view;
}

DwellView measured_view(double e_n) {
  DwellView view = make_view(sample_dwell(), sample_rig(), sample_run());
  auto beside = std::make_shared<MotionView>(*settling_view().transient);
  beside->agreement = {1, CoefficientKind::stiffness, 0.5, false, e_n};
  view.transient = beside;
  view.model = ModelVerdict{Verdict::adequate, true, 0.05, 0.012, 0.008};
  return view;
}

Verification sample_verification() {
  Verification v;
  v.verdict = Verdict::adequate;
  v.consistent = true;
  v.e_n = 0.7;
  v.chi2 = 1.1;
  v.p = 0.3;
  v.accuracy = 0.05;
  v.seen = 0.012;
  v.U = 0.008;
  ChannelComparison channel;
  channel.channel = 1;
  channel.verdict = Verdict::adequate;
  channel.samples = 1200;
  channel.rms = 2.5;
  channel.error = 0.012;
  channel.U = 0.008;
  channel.noise = 0.002;
  channel.beyond_steady = 0.3;
  channel.e_n = 0.7;
  channel.fit_percent = 98.8;
  channel.sprague_geers = {0.01, 0.004, 0.011};
  v.channels = {channel};
  v.evidence = {"transient from 0.20 s to 6.42 s"};
  return v;
}

}  // namespace dwell::test
