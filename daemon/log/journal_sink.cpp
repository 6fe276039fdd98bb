#include "daemon/log/journal_sink.hpp"

#include <sys/syslog.h>
#include <systemd/sd-journal.h>

#include <string>
#include <vector>

#include "daemon/log/log_payload.hpp"

namespace dwell {
namespace {

int priority_of(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::warn:
      return LOG_WARNING;
    case spdlog::level::err:
    case spdlog::level::critical:
      return LOG_ERR;
    case spdlog::level::trace:
    case spdlog::level::debug:
      return LOG_DEBUG;
    default:
      return LOG_INFO;
  }
}

}  // namespace

void JournalSink::sink_it_(const spdlog::details::log_msg& message) {
  std::string_view rest(message.payload.data(), message.payload.size());
  std::vector<std::string> entries{"MESSAGE=" + std::string(message_of(rest)),
                                   "PRIORITY=" + std::to_string(priority_of(message.level)),
                                   "SYSLOG_IDENTIFIER=dwelld"};
  for (auto mark = rest.find(kFieldMark); mark != std::string_view::npos; mark = rest.find(kFieldMark)) {
    rest.remove_prefix(mark + 1);
    entries.emplace_back(message_of(rest));
  }
  std::vector<iovec> parts;
  parts.reserve(entries.size());
  for (std::string& entry : entries) parts.push_back({entry.data(), entry.size()});
  if (sd_journal_sendv(parts.data(), static_cast<int>(parts.size())) < 0)
    throw spdlog::spdlog_ex("journald does not take the line");
}

}  // namespace dwell
