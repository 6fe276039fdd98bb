#include "daemon/record/utc_text.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>

#include "daemon/record/instants.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::string whole_seconds(std::int64_t utc_ns) {
  // Rounded down, so that instants before 1970 work too.
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
  return whole_seconds(utc_ns) + fraction;
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
  int used = 0;
  const int read = std::sscanf(iso.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d%n", &parts.tm_year, &parts.tm_mon, &parts.tm_mday,
                               &parts.tm_hour, &parts.tm_min, &parts.tm_sec, &used);
  auto at = static_cast<std::size_t>(used);
  std::int64_t within_ns = 0;
  if (read == 6 && at < iso.size() && iso[at] == '.') {
    ++at;
    for (std::int64_t unit = kSecond_ns / 10; at < iso.size() && iso[at] >= '0' && iso[at] <= '9'; ++at, unit /= 10)
      within_ns += unit * (iso[at] - '0');
  }
  if (read != 6 || iso.substr(std::min(at, iso.size())) != "Z")
    return tl::unexpected("\"" + iso + "\" is no instant: expected for instance 2026-11-23T03:12:17.250000Z");
  parts.tm_year -= 1900;
  parts.tm_mon -= 1;
  const std::int64_t seconds = timegm(&parts);
  if (seconds <= -kMostUtc_ns / kSecond_ns || seconds >= kMostUtc_ns / kSecond_ns)
    return tl::unexpected("\"" + iso + "\" is too far away: expected an instant of the years 1824 to 2115");
  return seconds * kSecond_ns + within_ns;
}

}  // namespace dwell::record
