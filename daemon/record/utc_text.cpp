#include "daemon/record/utc_text.hpp"

#include <cstdio>
#include <ctime>

namespace dwell::record {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::string seconds_text(std::int64_t utc_ns) {
  // Floor: an instant before 1970 is no reason to fail.
  const auto seconds = static_cast<std::time_t>(utc_ns / kSecond_ns - (utc_ns % kSecond_ns < 0 ? 1 : 0));
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[40];
  return {text, std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts)};
}

}  // namespace

std::string iso_utc(std::int64_t utc_ns) {
  const std::int64_t within_ns = (utc_ns % kSecond_ns + kSecond_ns) % kSecond_ns;
  char fraction[16];
  std::snprintf(fraction, sizeof fraction, ".%06dZ", static_cast<int>(within_ns / 1000));
  return seconds_text(utc_ns) + fraction;
}

std::string compact_utc(const std::string& iso) {
  std::string text;
  for (const char c : iso) {
    if (c == '.' || c == 'Z') break;
    if (c != '-' && c != ':') text += c;
  }
  return text + 'Z';
}

Result<std::int64_t> parse_utc(const std::string& iso) {
  std::tm parts{};
  int micro = 0, used = 0;
  const int read = std::sscanf(iso.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d.%6dZ%n", &parts.tm_year, &parts.tm_mon,
                               &parts.tm_mday, &parts.tm_hour, &parts.tm_min, &parts.tm_sec, &micro, &used);
  if (read != 7 || static_cast<std::size_t>(used) != iso.size())
    return tl::unexpected("\"" + iso + "\" is no instant: expected for instance 2026-11-23T03:12:17.250000Z");
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  return std::int64_t{timegm(&parts)} * kSecond_ns + std::int64_t{micro} * 1000;
}

}  // namespace dwell::record
