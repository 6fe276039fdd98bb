#include "daemon/report/dwell_text.hpp"

#include <gtest/gtest.h>

#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

DwellView sample_view() { return make_view(test::sample_dwell(), test::sample_rig(), test::sample_run()); }

TEST(DwellText, IsWhatAnOperatorReads) {
  EXPECT_EQ(dwell_text(sample_view()), R"(dwell 1 · measuring, 24.6 s of data
settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
memory     5.90 s measured, 5.70 s predicted from the coefficients
frequency  4.000300 ± 0.000039 Hz

channel   amplitude               phase to y0        mean             harmonic  status
y0        5.00000 ± 0.00020 mm          0         °  1.20000 mm     0.2 % (2f)  ok
a1         4.2000 ±  0.0020 m/s²  173.789 ± 0.027 °      1.2 mm/s²  0.2 % (2f)  ok
y2              —                       —                  —                 —  stale: timeout
reaction   86.300 ±   0.098 N     -20.054 ± 0.067 °        1 mN     0.2 % (2f)  ok

element  stiffness               damping                   most of u²(c)     most of u²(r)
      1   24.010 ±   0.027 kN/m  60.20 ± 0.79 N·s/m        60 % scale of y1  85 % delay of y0
      2        —                     —                     —                 —
      3  1.23457 ± 0.00020 MN/m    210 ±  790 mN·s/m n.s.  60 % scale of y1  85 % delay of y0
element 2 is not identifiable: the deformation is less than three times its uncertainty
n.s.: not significant, smaller than its standard uncertainty
± is the half width of the 95 % interval

warning: channel y2 is stale: timeout
)");
}

TEST(DwellText, ShowsTheTruthBesideTheMeasuredWithTheDeviation) {
  const Truth truth{{24000.0, 5000.0, 1234500.0}, {60.0, 12.0, 0.2}};
  EXPECT_EQ(element_table(sample_view(), &truth),
            R"(element  stiffness               true          off by  damping                   true            off by
      1   24.010 ±   0.027 kN/m  24.0000 kN/m  +0.7 u  60.20 ± 0.79 N·s/m        60.0000 N·s/m   +0.5 u
      2        —                 5.00000 kN/m       —      —                     12.0000 N·s/m        —
      3  1.23457 ± 0.00020 MN/m  1.23450 MN/m  +0.7 u    210 ±  790 mN·s/m n.s.  200.000 mN·s/m  +0.0 u
element 2 is not identifiable: the deformation is less than three times its uncertainty
n.s.: not significant, smaller than its standard uncertainty
)");
}

TEST(DwellText, BeforeSettlingItSaysWhatIsAwaited) {
  EXPECT_EQ(dwell_text(make_view(test::settling_dwell(), test::sample_rig(), {})),
            R"(dwell 2 · settling, about 3.2 s left
settled    no
reason     2.1 % of the transient of reaction is left, 0.5 % allowed
frequency  4.00000 ± — Hz

channel   amplitude  phase  mean  harmonic  status
y0        —          —      —            —  too few samples
a1        —          —      —            —  too few samples
y2        —          —      —            —  too few samples
reaction  —          —      —            —  too few samples
)");
}

TEST(DwellText, IdleIsOneLine) { EXPECT_EQ(dwell_text(make_view(Dwell{}, test::sample_rig(), {})), "idle\n"); }

}  // namespace
}  // namespace dwell
