// The report as a browser parses it, and the pieces that keep outside text out of its markup.
#include "daemon/handon/report.hpp"

#include <gtest/gtest.h>

#include "config/sha256.hpp"
#include "daemon/handon/html.hpp"
#include "daemon/handon/picture.hpp"
#include "daemon/handon/report_dwell.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/handon/handed_run.hpp"

namespace dwell::handon {
namespace {

TEST(Report, IsOnePageThatHoldsEverythingAndRunsNothing) {
  const record::Scratch scratch;
  test::HandedRun run;
  run.events = {{2, "2026-11-23T03:12:18Z", "action", "<script>alert(1)</script>", record::Person{1000, "o'brien"}, "a",
                 "b", "c"}};
  const std::string dbc = "BO_ 385 motor: 8 amplifier\n", tape_sum(64, 'c');
  run.files = {{"motor <1>.dbc", config::sha256(dbc), dbc}, {"tape.csv", tape_sum, {}}, {"endless.csv", {}, {}}};
  test::write(run, scratch.path("run.dwell"));
  Selection selection = test::select(run);
  record::Audit audit;
  audit.state = record::AuditState::intact;
  audit.key = "1234";
  audit.head = "ab12";
  audit.signatures = {{"reviewed by o'brien", "", false}};
  const auto done = export_report(selection, audit, test::provenance(), scratch.path("report.html"), {});
  ASSERT_TRUE(done) << done.error();
  EXPECT_EQ(test::python("read_report.py",
                         {scratch.path("report.html"), selection.header().rig.sha256, config::sha256(dbc), tape_sum}),
            0);
  // A line of the phasors' table breaks between two harmonics, not within one.
  EXPECT_NE(record::Scratch::read(scratch.path("report.html")).find("<td>2f\u00a0"), std::string::npos);
}

TEST(Report, TellsWhatWasEstimatedAndVerifiedMeanwhile) {
  const record::Scratch scratch;
  test::HandedRun run;
  run.length_s = 2.0;
  run.models = {{"estimate", 400, "2026-11-23T03:12:18Z", R"({"last":390,"readings":250,"from_s":0.5,"until_s":3.125})",
                 R"({"motion":null,"motion_reason":"the table <rests>"})"},
                {"estimate", 300, "2026-11-23T03:12:18Z", R"({"last":290,"readings":200,"from_s":0.5,"until_s":2.5})",
                 R"({"motion":{"elements":[{"k":1,"identifiable":true,)"
                 R"("stiffness":{"value":24000.7,"U95":74.4,"unit":"N/m"},)"
                 R"("damping":{"value":60.22,"U95":0.81,"unit":"N*s/m"}},{"k":2,"identifiable":false}]}})"},
                {"verification", 900, "2026-11-23T03:12:20Z", R"({"position":880,"ended":false})",
                 R"({"dwell":1,"verdict":"adequate","e_n":0.42,"accuracy":{"asked":0.05,"seen":0.0015,"U":0.0008}})"}};
  test::write(run, scratch.path("run.dwell"));
  Selection selection = test::select(run);
  const RunStory story = tell_run(selection, {});
  const std::string page = report_page(selection, story, {}, test::provenance());
  EXPECT_NE(page.find("from 0.50 s to 3.12 s, 250 readings: no coefficients: the table &lt;rests&gt;"),
            std::string::npos);
  EXPECT_NE(page.find("of dwell 1: adequate, off by 0.150 ± 0.080 % (accuracy 5 %), E_n 0.42"), std::string::npos);
  EXPECT_NE(page.find("E_n: the error of the worst channel"), std::string::npos);
  EXPECT_NE(page.find("Coefficients of the last estimate"), std::string::npos);
  EXPECT_NE(page.find("24.001 ± 0.074 kN/m</td><td class=\"number\">60.22 ± 0.81 N·s/m</td>"), std::string::npos);
}

// An estimate that something stands against: it must not look as one that nothing does.
TEST(Report, TellsWhatStandsAgainstTheCoefficientsOfTheLastEstimate) {
  const record::Scratch scratch;
  const std::string element = R"({"k":1,"identifiable":true,"stiffness":{"value":24000.7,"U95":74.4,"unit":"N/m"},)"
                              R"("damping":{"value":60.22,"U95":0.81,"unit":"N*s/m"}})";
  const auto page_of = [&](const std::string& name, const std::string& last_result) {
    test::HandedRun run;
    run.length_s = 2.0;
    run.models = {{"estimate", 300, "2026-11-23T03:12:18Z", R"({"last":290,"readings":200,"from_s":0.5,"until_s":2.5})",
                   R"({"motion":{"elements":[)" + element + "]}}"},
                  {"estimate", 400, "2026-11-23T03:12:19Z", R"({"last":390,"readings":250,"from_s":0.5,"until_s":3.1})",
                   last_result}};
    test::write(run, scratch.path(name));
    Selection selection = test::select(run);
    return report_page(selection, tell_run(selection, {}), {}, test::provenance());
  };
  const std::string doubted = page_of(
      "doubted.dwell", R"({"motion":{"elements":[)" + element +
                           R"(],"missing":[],"warnings":["the table <errs> in a pattern"]},"motion_reason":"the chain )"
                           R"(does not explain the readings","objection":{"dwell":3,"what":"a spring of 799 N/m"}})");
  const std::size_t table = doubted.find("24.001 ± 0.074 kN/m</td>");
  ASSERT_NE(table, std::string::npos);
  for (const char* caution :
       {"<li>the chain does not explain the readings</li>", "<li>against dwell 3: a spring of 799 N/m</li>",
        "<li>the table &lt;errs&gt; in a pattern</li>"})
    EXPECT_LT(doubted.find(caution), table) << caution;
  const std::string refused = page_of("refused.dwell", R"({"motion":null,"motion_reason":"no linear chain"})");
  EXPECT_EQ(refused.find("Coefficients of the last estimate"), std::string::npos) << "those of an older one are shown";
}

// A "1" close to the left of "0°" would read as "10°".
TEST(Report, TheNumberOfAnArrowStandsClearOfTheAngles) {
  const std::string svg = phasor_picture({{1.0, 1, 0}});
  const auto x_of = [&svg](const std::string& text) {
    const std::size_t at = svg.find(">" + text + "</text>"), begin = svg.rfind("<text x=\"", at);
    return std::stod(svg.substr(begin + 9));
  };
  constexpr double kDigit = 6.0;  // px: a bold digit at the picture's size
  EXPECT_GT(x_of("0°") - x_of("1"), 1.5 * kDigit) << "one is centred, the other begins there";
  EXPECT_NE(svg.find("text-anchor=\"start\" class=\"axis\">0°"), std::string::npos);
}

TEST(Report, SaysWhatWasTamperedWithFirst) {
  const record::Scratch scratch;
  test::HandedRun run;
  run.length_s = 2.0;
  run.closed = false;
  test::write(run, scratch.path("run.dwell"));
  Selection selection = test::select(run);
  const RunStory story = tell_run(selection, {});
  record::Audit audit;
  audit.where = "entry 3: its head does not follow";
  const std::string page = report_page(selection, story, audit, test::provenance());
  EXPECT_LT(page.find("tampered: entry 3: its head does not follow"), page.find("<h2>"));
  EXPECT_NE(page.find("not closed: still recorded, or cut off"), std::string::npos);
}

TEST(Report, HoldsADwellAgainstTheLimitsOfTheRigFile) {
  Rig rig = test::sample_rig();
  EXPECT_EQ(report_dwell(make_view(test::sample_dwell(), rig, test::sample_run())).find("Limits"), std::string::npos);
  rig.limits = {{1, Bounds{23000.0, 25000.0}, Bounds{60.0, 70.0}},
                {2, Bounds{1.0, 2.0}, std::nullopt},
                {3, Bounds{1e6, 1.1e6}, std::nullopt}};
  const std::string html = report_dwell(make_view(test::sample_dwell(), rig, test::sample_run()));
  const auto row_of = [&html](const std::string& what) {
    const auto at = html.find("<td>" + what + "</td>");
    return at == std::string::npos ? "" : html.substr(at, html.find("</tr>", at) - at);
  };
  EXPECT_NE(row_of("stiffness of element 1").find("<td>kept</td>"), std::string::npos) << html;
  EXPECT_NE(row_of("damping of element 1").find("<td>undecided</td>"), std::string::npos);
  EXPECT_NE(row_of("stiffness of element 3").find("violated"), std::string::npos);
  EXPECT_NE(row_of("stiffness of element 2").find("no verdict"), std::string::npos);
  EXPECT_NE(row_of("stiffness of element 1").find("24.010 ± 0.027 kN/m"), std::string::npos)
      << "what is held against it";
}

TEST(Report, SaysBelowTheCoefficientsWhatTheirUncertaintyDoesNotCover) {
  Dwell dwell = test::sample_dwell();
  const auto html = [&dwell] { return report_dwell(make_view(dwell, test::sample_rig(), test::sample_run())); };
  EXPECT_EQ(html().find("not stated"), std::string::npos);
  dwell.unstated = {"mass 1", "scale of <y0>"};
  const std::string said =
      "± covers only noise, clock and what the rig file states; not stated: mass 1, scale of &lt;y0&gt;";
  EXPECT_NE(html().find(said), std::string::npos) << html();
}

TEST(Html, EscapesWhatComesFromOutside) {
  EXPECT_EQ(escaped("<a href=\"x\">'&'</a>"), "&lt;a href=&quot;x&quot;&gt;&#39;&amp;&#39;&lt;/a&gt;");
  EXPECT_EQ(escaped("µm ± °C 𝛼"), "µm ± °C 𝛼");
  const std::string replacement = "\xEF\xBF\xBD";
  EXPECT_EQ(escaped(std::string("a\0b\x1b[31m", 7)), "a" + replacement + "b" + replacement + "[31");
  EXPECT_EQ(escaped("\xFF\xC0\xAF"), replacement + replacement + replacement) << "not UTF-8, or longer than it needs";
  EXPECT_EQ(escaped("\xED\xA0\x80").find('\xED'), std::string::npos) << "a surrogate";
  EXPECT_EQ(escaped("a\xE2\x80\xAE"
                    "b"),
            "a" + replacement + replacement + replacement + "b")
      << "turns the direction";
}

TEST(Picture, TicksAreRoundAndFew) {
  EXPECT_EQ(ticks(0.0, 10.0, 5), (std::vector<double>{0.0, 2.0, 4.0, 6.0, 8.0, 10.0}));
  EXPECT_EQ(ticks(-0.7, 0.7, 4), (std::vector<double>{-0.5, 0.0, 0.5}));
  EXPECT_TRUE(ticks(1.0, 1.0, 4).empty());
  for (const double high : {1e-9, 0.3, 7.0, 86400.0}) {
    EXPECT_LE(ticks(0.0, high, 8).size(), 9U) << high;
    EXPECT_GE(ticks(0.0, high, 8).size(), 3U) << high;
  }
}

}  // namespace
}  // namespace dwell::handon
