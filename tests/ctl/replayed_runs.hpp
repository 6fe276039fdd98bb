// Run files of a simulated rig, and what a verb prints about them.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "tests/ctl/run_file_builder.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell::ctl {

using Value = nlohmann::json;
using test::SimulatedRig;
using test::StreamBuilder;

struct Printed {
  int code = -1;
  std::string out, err;
  [[nodiscard]] Value json() const { return Value::parse(out, nullptr, false); }
};
template <class Verb>
Printed printed(const Verb& verb) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Printed result;
  result.code = verb();
  result.out = testing::internal::GetCapturedStdout();
  result.err = testing::internal::GetCapturedStderr();
  return result;
}
inline Printed replayed(const std::string& file) {
  return printed([&] { return replay({.file = file, .json = true}); });
}

inline std::string contents_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// One mass between the table and a load cell; a drive that starts, holds for 14 s and stops.
inline const SimulatedRig& bench() {
  static const SimulatedRig rig{{Boundary::clamped, {12.5}, {24000.0, 9000.0}, {160.0, 90.0}}, 6.0, 200.0, 1e-6};
  return rig;
}
inline std::vector<Record> bench_stream() {
  StreamBuilder stream(bench(), {.frequency_hz = bench().frequency_hz}, 5);
  stream.run_to(1.0);
  stream.set_drive({.frequency_hz = bench().frequency_hz, .amplitude = 3e-3, .ramp_s = 0.2});
  stream.run_to(2.0);
  stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::begins));
  stream.run_to(15.0);
  stream.set_drive({.frequency_hz = bench().frequency_hz, .ramp_s = 0.2});
  stream.run_to(18.0);
  return stream.end();
}

struct ReplayTest : testing::Test {
  std::string write(const std::string& name, const test::Changes& changes = {}) {
    written = test::write_run(folder.path(name), bench().rig_text(), bench_stream(), changes);
    return folder.path(name);
  }
  test::TemporaryFolder folder;
  test::WrittenRun written;
};

}  // namespace dwell::ctl
