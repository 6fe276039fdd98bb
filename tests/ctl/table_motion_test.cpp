#include "daemon/ctl/table_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

namespace dwell::ctl {
namespace {

Rig rig_at_4_hz() {
  Rig rig;
  rig.excitation.frequency_hz = 4.0;
  rig.excitation.search_low_hz = 3.9;
  rig.excitation.search_high_hz = 4.1;
  rig.excitation.minimum = 2e-5;
  rig.tolerance = 0.005;
  Channel y0;
  y0.name = "y0";
  y0.si_per_unit = 1e-3;
  rig.channels = {y0};
  return rig;
}

// 200 readings a second, in mm.
CsvRecording recording_of(double duration_s, const std::function<double(double)>& value) {
  CsvRecording recording;
  recording.channels = {"y0"};
  for (int i = 0; i < static_cast<int>(200.0 * duration_s); ++i) {
    CsvRecording::Sample sample{};
    sample.t_s = 0.005 * i;
    sample.value = value(sample.t_s);
    recording.samples.push_back(sample);
  }
  return recording;
}

double sine(double amplitude, double frequency_hz, double t_s) {
  return amplitude * std::sin(2.0 * std::numbers::pi * frequency_hz * t_s);
}

std::string why(const std::function<double(double)>& value, double duration_s = 40.0) {
  const Rig rig = rig_at_4_hz();
  return why_no_dwell(rig, table_motion(rig, CsvSource(rig, recording_of(duration_s, value))));
}

// "nowhere did the table move by more than 1e-6" was said of a table that moved by 6 mm for 40 s.
TEST(TableMotion, OutsideOfTheSearchSaysWhereItMoved) {
  EXPECT_EQ(why([](double t_s) { return sine(6.4, 1.99, t_s) + 3.0; }),
            "no dwell: the table (y0) moved by 6.4 mm at about 1.99 Hz, outside of excitation.search, 3.9 to 4.1 Hz");
}

TEST(TableMotion, StillIsSaidWithItsAmplitudeAndASpikeIsNoMotion) {
  EXPECT_EQ(why([](double t_s) { return sine(0.0012, 4.0, t_s) + (std::fabs(t_s - 7.0) < 1e-9 ? 5.0 : 0.0); }),
            "no dwell: the table (y0) moved by at most 1.2 µm; excitation.minimum asks for 20 µm");
}

TEST(TableMotion, TooShortIsSaidWithItsLength) {
  EXPECT_EQ(why([](double t_s) { return t_s >= 20.0 && t_s < 20.7 ? sine(5.0, 4.0, t_s) : 0.0; }),
            "no dwell: the table (y0) moved by 5.0 mm at about 4.00 Hz, for about 1.0 s only; a dwell needs more than "
            "3 periods "
            "of one amplitude");
}

TEST(TableMotion, WanderingIsSaidWithHowMuchAndWhatIsAllowed) {
  EXPECT_EQ(
      why([](double t_s) { return std::exp(-0.2 * t_s) * sine(50.0, 4.0, t_s); }, 20.0),
      "no dwell: the table (y0) moved by 49 mm at about 4.00 Hz, but its amplitude changed by 9.5 % or more within "
      "any four periods; settling.tolerance allows 0.5 %");
}

TEST(TableMotion, AnAccelerometersReadingsAreToldAsDisplacement) {
  Rig rig = rig_at_4_hz();
  rig.channels[0].measures = Quantity::acceleration;
  rig.channels[0].si_per_unit = 1.0;
  const double omega = 2.0 * std::numbers::pi * 2.0;
  const TableMotion motion = table_motion(
      rig, CsvSource(rig, recording_of(40.0, [omega](double t_s) { return sine(0.005 * omega * omega, 2.0, t_s); })));
  EXPECT_NEAR(motion.amplitude, 0.005, 1e-4);
  EXPECT_NEAR(motion.frequency_hz, 2.0, 0.01);
}

TEST(TableMotion, OddRecordingsDoNotHarm) {
  const Rig rig = rig_at_4_hz();
  for (const double duration_s : {0.0, 0.005, 0.02, 0.1})
    EXPECT_NE(why([](double t_s) { return sine(5.0, 4.0, t_s); }, duration_s), "");
  EXPECT_NE(why([](double) { return std::nan(""); }), "");
  EXPECT_NE(why([](double t_s) { return t_s; }), "");
  EXPECT_NE(why_no_dwell(rig, table_motion(rig, CsvSource(rig, {}))), "");
  const Rig none;
  EXPECT_EQ(why_no_dwell(rig, table_motion(none, CsvSource(none, {}))),
            "no dwell: no channel measures the motion of the table");
}

}  // namespace
}  // namespace dwell::ctl
