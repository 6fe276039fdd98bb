// What stands beside a live dwell: coefficients from its transient, the verdict on its model. As text, as JSON, and
// back.
#include "daemon/report/model_text.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "daemon/report/dwell_change.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/verification_json.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

TEST(TransientText, StandsAboveTheSettlingNoticeAndSaysThatItIsNoVerdict) {
  DwellView view = test::settling_view();
  view.dwell.unstated = {"mass 1", "scales of y0 and a1"};
  const std::string text = dwell_text(view);
  EXPECT_EQ(text.substr(0, text.find("reason ")), R"(dwell 2 · settling, about 3.2 s left

from the transient, 40.0 to 43.2 s, an estimate before the verdict:
element  stiffness               damping
      1    24.10 ±    0.59 kN/m  58.0 ± 7.9 N·s/m
      2        —                    —
      3  1.23457 ± 0.00020 MN/m   210 ± 790 mN·s/m n.s.
element 2 is not determined by the transient so far: the readings do not determine it
from the transient, warning: the residuals of y2 are not white: uncertainties are widened
± is the half width of the 95 % interval, if the rig is as its file says; n.s.: not significant, smaller than its standard uncertainty
± covers only noise, clock and what the rig file states; not stated: mass 1, scales of y0 and a1

settled    no
)") << text;
}

TEST(TransientText, HasLooksOfItsOwnAndThoseOfOldNumbersOnceItIsOld) {
  const DwellView view = test::settling_view();
  const std::vector<Section> fresh = transient_sections(view, {});
  ASSERT_EQ(fresh.size(), 1u);
  EXPECT_EQ(fresh[0].head[0].style, Style::tentative);
  EXPECT_EQ(fresh[0].body[0].style, Style::tentative);
  TextOptions old;
  old.age = "778 s";
  const std::vector<Section> gone = transient_sections(view, old);
  EXPECT_EQ(gone[0].head[0].style, Style::old);
  EXPECT_EQ(gone[0].body[0].style, Style::old);
  EXPECT_NE(gone[0].body[0].text.find("778 s"), std::string::npos);
}

TEST(TransientText, ShowsTheTruthOfASimulatedRigBesideIt) {
  const Truth truth{{24000.0, 15000.0, 1234567.0}, {60.0, 45.0, 0.2}};
  TextOptions options;
  options.truth = &truth;
  const std::string text = plain_text(transient_sections(test::settling_view(), options));
  EXPECT_NE(text.find("+0.3 u"), std::string::npos) << text;
}

TEST(TransientText, FitsANarrowTerminal) {
  TextOptions narrow;
  narrow.columns = 40;
  for (const Section& section : transient_sections(test::settling_view(), narrow)) {
    for (const TextLine& line : section.head) EXPECT_LE(width(line.text), 40u) << line.text;
    for (const TextLine& line : section.body) EXPECT_LE(width(line.text), 40u) << line.text;
  }
}

TEST(TransientText, SaysWhyThereIsNone) {
  DwellView view = test::settling_view();
  auto none = std::make_shared<MotionView>(*view.transient);
  none->estimate.elements.clear();
  none->estimate.reason = "too few readings: 30";
  view.transient = none;
  EXPECT_NE(dwell_text(view).find("from the transient: no coefficients: too few readings: 30\n"), std::string::npos);
  view.transient = nullptr;
  EXPECT_EQ(dwell_text(view).find("from the transient"), std::string::npos);
}

// The measured dwell and its coefficients from the transient, which differ most in the damping of element 2.
DwellView compared(double over_U, bool contradicts) {
  DwellView view = test::measured_view(0.6);
  auto beside = std::make_shared<MotionView>(*view.transient);
  beside->agreement = {2, CoefficientKind::damping, over_U, contradicts, 0.6};
  view.transient = beside;
  return view;
}

TEST(TransientText, OnceTheDwellHasSettledSaysWhetherBothAgree) {
  const std::string agrees = dwell_text(compared(0.5, false));
  EXPECT_NE(agrees.find("agreement  the coefficients of any motion, 40.0 to 43.2 s, agree with these: the "
                        "largest difference, in the damping of element 2, is 0.5 of the joint U of both\n"),
            std::string::npos)
      << agrees;
  EXPECT_EQ(agrees.find("an estimate before the verdict"), std::string::npos) << "the dwell has taken over";
  const std::string contradicts = dwell_text(compared(2.5, true));
  EXPECT_NE(contradicts.find("warning: the coefficients of any motion, 40.0 to 43.2 s, contradict these: the "
                             "damping of element 2 differs by 2.5 of the joint U of both"),
            std::string::npos)
      << contradicts;
  EXPECT_EQ(contradicts.find("agreement"), std::string::npos);
  EXPECT_FALSE(dwell::contradicts(test::settling_view())) << "nothing to compare with yet";
}

// The verdict takes the place of the settling notice, and the reason must not go with it.
TEST(TransientText, OnceTheDwellHasSettledStillSaysWhyTheTransientGaveNoCoefficients) {
  DwellView view = test::measured_view(0.6);
  auto none = std::make_shared<MotionView>(*view.transient);
  none->estimate.elements.clear();
  none->estimate.reason = "the chain of the rig file does not explain y1";
  none->agreement = std::nullopt;
  view.transient = none;
  EXPECT_NE(dwell_text(view).find("agreement  not known, since any motion gives no coefficients: the chain of the rig "
                                  "file does not explain y1\n"),
            std::string::npos)
      << dwell_text(view);
}

TEST(ModelText, IsOneLineBelowTheVerdict) {
  EXPECT_NE(dwell_text(test::measured_view(0.4)).find("model      adequate, off by 1.20 ± 0.80 % (accuracy 5 %)\n"),
            std::string::npos)
      << dwell_text(test::measured_view(0.4));
  EXPECT_EQ(model_text({Verdict::adequate, true, 0.05, 0.012, 0.008, "any motion: the chain does not explain y1"}),
            "adequate, off by 1.20 ± 0.80 % (accuracy 5 %); any motion: the chain does not explain y1");
  EXPECT_EQ(model_text({Verdict::adequate, false, 0.05, 0.012, 0.008}),
            "adequate, off by 1.20 ± 0.80 % (accuracy 5 %); not consistent: dwellctl verify says why");
  EXPECT_EQ(model_text({Verdict::not_verified, {}, 0.05, kNaN, kNaN}), "not verified yet (accuracy 5 %)");
}

TEST(TransientJson, ComesBackAsItWas) {
  for (const DwellView& view : {test::settling_view(), test::measured_view(0.4)}) {
    const auto back = parse_dwell(to_json(view));
    ASSERT_TRUE(back) << back.error();
    EXPECT_EQ(dwell_text(*back), dwell_text(view));
  }
}

TEST(TransientJson, OfAServiceThatDoesNotTellIsNone) {
  Json value = json_value(test::settling_view());
  for (const char* member : {"motion", "motion_reason", "model"}) value.erase(member);
  const auto back = dwell_from_json(value);
  ASSERT_TRUE(back) << back.error();
  EXPECT_FALSE(back->transient);
  EXPECT_FALSE(back->model);
}

TEST(TransientJson, ComesWholeFirstAndThenWhatMoved) {
  DwellView before = test::measured_view(0.4);
  before.transient = nullptr;
  const DwellView now = test::measured_view(0.4);
  EXPECT_FALSE(change_between(json_value(before), json_value(now)));
  const auto change = change_between(json_value(now), json_value(test::measured_view(0.5)));
  ASSERT_TRUE(change);
  EXPECT_EQ((*change)["motion"].dump(), R"({"agrees_with_dwell":{"e_n":0.5}})") << change->dump();
}

TEST(VerificationText, IsTheSameOfTheServicesAnswer) {
  const Verification v = test::sample_verification();
  const VerificationView view = make_view(v, test::sample_rig(), test::sample_dwell());
  const auto back = verification_from_json(json_value(v, test::sample_rig(), test::sample_dwell()));
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ("rig bench\n\n" + verification_text(*back), verification_text(view));
  Json wrong;
  wrong["dwell"] = 1;
  EXPECT_EQ(verification_from_json(wrong).error(), "verification: verdict: expected to be there");
}

}  // namespace
}  // namespace dwell
