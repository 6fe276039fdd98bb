#include "daemon/record/utc_text.hpp"

#include <cstdio>
#include <ctime>

namespace dwell::record {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::string formatted(std::int64_t utc_ns, const char* format) {
  // Floor: an instant before 1970 is no reason to fail.
  const auto seconds = static_cast<std::time_t>(utc_ns / kSecond_ns - (utc_ns % kSecond_ns < 0 ? 1 : 0));
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[40];
  return {text, std::strftime(text, sizeof text, format, &parts)};
}

}  // namespace

std::string iso_utc(std::int64_t utc_ns) {
  const std::int64_t within_ns = (utc_ns % kSecond_ns + kSecond_ns) % kSecond_ns;
  char fraction[16];
  std::snprintf(fraction, sizeof fraction, ".%06dZ", static_cast<int>(within_ns / 1000));
  return formatted(utc_ns, "%Y-%m-%dT%H:%M:%S") + fraction;
}

std::string compact_utc(std::int64_t utc_ns) { return formatted(utc_ns, "%Y%m%dT%H%M%SZ"); }

}  // namespace dwell::record
