#include <gnu/libc-version.h>
#include <sys/timex.h>
#include <unistd.h>
#if !defined(__x86_64__)
#include <sys/auxv.h>
#endif

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "daemon/record/build.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/sources.hpp"
#include "daemon/version.hpp"

namespace dwell::record {
namespace {

// The features by which glibc's libm chooses a version of its functions, and those for wider vectors. The versions
// differ in the last bits of their results.
std::string cpu_features() {
  std::string features;
#if defined(__x86_64__)
  const auto add = [&](const char* name, bool there) {
    if (there) features += (features.empty() ? "" : " ") + std::string(name);
  };
  __builtin_cpu_init();
  add("avx", __builtin_cpu_supports("avx") != 0);
  add("avx2", __builtin_cpu_supports("avx2") != 0);
  add("avx512f", __builtin_cpu_supports("avx512f") != 0);
  add("fma", __builtin_cpu_supports("fma") != 0);
  add("fma4", __builtin_cpu_supports("fma4") != 0);
  add("sse4_1", __builtin_cpu_supports("sse4.1") != 0);
  add("sse4_2", __builtin_cpu_supports("sse4.2") != 0);
#else
  features = "hwcap " + std::to_string(::getauxval(AT_HWCAP)) + " " + std::to_string(::getauxval(AT_HWCAP2));
#endif
  // These can hide features from libm.
  if (const char* tunables = std::getenv("GLIBC_TUNABLES"); tunables != nullptr)
    features += std::string(" GLIBC_TUNABLES=") + tunables;
  return features;
}

std::string host_name() {
  std::array<char, 256> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

std::string time_zone() {
  if (const char* zone = std::getenv("TZ"); zone != nullptr && *zone != '\0') return *zone == ':' ? zone + 1 : zone;
  std::error_code error;
  const std::string target = std::filesystem::read_symlink("/etc/localtime", error).string();
  constexpr std::string_view kFolder = "zoneinfo/";
  const std::size_t at = target.rfind(kFolder);
  return at == std::string::npos ? "" : target.substr(at + kFolder.size());
}

// By what adjtimex returned.
bool is_synchronized(int state, const timex& clock) {
  return state >= 0 && state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0;
}

}  // namespace

Origin this_origin() {
  Origin origin;
  origin.version = dwell::kVersion;
  origin.build = std::string("sources ") + kSources + ", " + kBuild + ", glibc " + ::gnu_get_libc_version();
  origin.cpu = cpu_features();
  origin.host = host_name();
  origin.time_zone = time_zone();
  timex clock{};
  const int state = ::adjtimex(&clock);  // only asks
  origin.clock_synchronized = is_synchronized(state, clock);
  origin.clock_error_s =
      state >= 0 ? 1e-6 * static_cast<double>(clock.maxerror) : std::numeric_limits<double>::quiet_NaN();
  return origin;
}

bool clock_synchronized() noexcept {
  timex clock{};
  return is_synchronized(::adjtimex(&clock), clock);
}

}  // namespace dwell::record
