// show: what was estimated and verified while dwells were on.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/report/dwell_json.hpp"
#include "daemon/report/verification_json.hpp"
#include "tests/api_schema.hpp"
#include "tests/ctl/program.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/temporary.hpp"
#include "tests/record/sample_run.hpp"

namespace dwell::ctl {
namespace {

TEST(ShowModels, OnThePageAndAsJsonInTheOrderInWhichTheyWerePublished) {
  const test::TemporaryFolder folder;
  const record::SigningKey key = record::sample_key("bench2");
  record::SampleRun run = record::sample_run_file(
      folder.path("run.dwell"), key, to_json(test::sample_dwell(), test::sample_rig(), test::sample_run()));
  Verification verification;
  verification.verdict = Verdict::adequate;
  verification.e_n = 0.42;
  verification.accuracy = 0.05;
  verification.seen = 0.0015;
  verification.U = 0.0008;
  const std::string verified = dump(json_value(verification, test::sample_rig(), test::sample_dwell()));
  const std::string stretch = R"({"last":390,"readings":250,"from_s":0.5,"until_s":3.125})";
  run.models = {{"verification", 900, "2026-07-01T10:12:09.250000Z",
                 R"({"position":880,"ended":false,"evidence":)" + stretch + "}", verified},
                {"estimate", 400, "2026-07-01T10:12:04.500000Z", stretch,
                 R"({"motion":null,"motion_reason":"the table rests"})"}};
  write(run, key);
  const test::Outcome page = test::run({"show", run.path});
  const auto estimate = page.out.find("  10:12:04.500  estimate      from 0.50 s to 3.12 s, 250 readings: no\n");
  const auto verdict = page.out.find("  10:12:09.250  verification  of dwell 1: adequate, off by 0.150 ± 0.080 %\n");
  ASSERT_NE(estimate, std::string::npos) << page.out;
  ASSERT_NE(verdict, std::string::npos) << page.out;
  EXPECT_LT(estimate, verdict);
  EXPECT_NE(page.out.find("(accuracy 5 %), E_n 0.42\n"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("  E_n: the error of the worst channel over its"), std::string::npos) << page.out;

  const test::Outcome json = test::run({"show", "--json", run.path});
  const auto models = nlohmann::json::parse(json.out)["models"];
  ASSERT_EQ(models.size(), 2u);
  EXPECT_EQ(models[0]["kind"], "estimate");
  EXPECT_EQ(models[0]["from"]["last"], 390);
  EXPECT_EQ(models[1]["result"]["verdict"], "adequate");
  EXPECT_EQ(test::ApiSchema().faults_of_text("shown_run", json.out), "");
}

}  // namespace
}  // namespace dwell::ctl
