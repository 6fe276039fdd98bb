// Run files for tests of the verbs that take them.
#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <string>

#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/temporary.hpp"
#include "tests/record/sample_run.hpp"

namespace dwell::test {

inline bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A folder for run files, and the key that signs them.
struct RecordedRuns : ::testing::Test {
  record::SampleRun make(const std::string& name) const {
    return record::sample_run_file(folder.path(name), key, to_json(sample_dwell(), sample_rig(), sample_run()));
  }
  std::string written(const std::string& name) const {
    const record::SampleRun run = make(name);
    write(run, key);
    return run.path;
  }
  void alter(const std::string& path, const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK);
    sqlite3_close(database);
  }

  const TemporaryFolder folder;
  const record::SigningKey key = record::sample_key("bench2");
};

}  // namespace dwell::test
