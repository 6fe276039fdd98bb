// check: every device probed once, either directly through its plugin or by asking the running service.
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "core/result/condition.hpp"
#include "daemon/acquire/plugin.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/control_client.hpp"
#include "daemon/ctl/tables.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

constexpr const char* kNoAnswer = "no answer";

// What the plugin tells of one device; a copy of it reaches the plugin as `context`.
struct Probe {
  const config::DeviceSettings* settings = nullptr;
  const Rig* rig = nullptr;
  std::vector<Probed>* channels = nullptr;  // by Rig::channels
  std::set<std::int64_t> latencies_ns;      // one per transaction: channels read together share theirs
};

void probed(void* context, size_t channel, double raw, std::int64_t latency_ns, const char* error) {
  auto& probe = *static_cast<Probe*>(context);
  if (channel >= probe.settings->channels.size()) return;
  const std::size_t index = probe.settings->channels[channel].index;
  if (index >= probe.channels->size()) return;
  Probed& result = (*probe.channels)[index];
  if (error != nullptr) {
    result.status = kNoAnswer;
    result.reason = error;
    return;
  }
  const Channel& wiring = probe.rig->channels[index];
  result.value = wiring.scale * raw + wiring.offset;
  const bool below = wiring.range.low && result.value < *wiring.range.low;
  const bool above = wiring.range.high && result.value > *wiring.range.high;
  result.status = to_string(below || above ? Condition::overrange : Condition::ok);
  result.reason.clear();
  result.latency_s = 1e-9 * static_cast<double>(latency_ns);
  probe.latencies_ns.insert(latency_ns);
}

std::vector<Probed> probe_all(const config::RigFile& file) {
  std::vector<Probed> channels(file.rig.channels.size());
  for (std::size_t i = 0; i < channels.size(); ++i) {
    channels[i].name = file.rig.channels[i].name;
    channels[i].unit = file.rig.channels[i].unit;
    channels[i].status = kNoAnswer;
  }
  for (const config::DeviceSettings& device : file.devices) {
    for (const config::ChannelSettings& channel : device.channels) channels[channel.index].device = device.name;
    const auto table = acquire::load_plugin(device.driver);
    if (!table) {
      for (const config::ChannelSettings& channel : device.channels) channels[channel.index].reason = table.error();
      continue;
    }
    const config::DriverSettings settings(device, file.directory);
    Probe probe{&device, &file.rig, &channels, {}};
    (*table)->probe(&settings.get(), &probed, &probe);
    double scan_s = 0.0;
    for (const std::int64_t latency_ns : probe.latencies_ns) scan_s += 1e-9 * static_cast<double>(latency_ns);
    if (scan_s <= 0.0) continue;
    for (const config::ChannelSettings& channel : device.channels) {
      if (channels[channel.index].answers()) channels[channel.index].rate_hz = 1.0 / scan_s;
    }
  }
  return channels;
}

int show(const std::vector<Probed>& channels, const Json& document, bool json) {
  const std::string text = json ? dump(document, 2) + "\n" : check_table(channels);
  std::fwrite(text.data(), 1, text.size(), stdout);
  bool all = !channels.empty();
  for (const Probed& channel : channels) {
    all = all && channel.answers() && !channel.gated();
    if (!channel.gated()) continue;
    const std::string why = channel.reason.empty() ? "" : ": " + channel.reason;
    std::fprintf(stderr, "dwellctl: %s answers, and its readings cannot be relied on: %s%s\n",
                 printable(channel.name).c_str(), channel.status.c_str(), printable(why).c_str());
  }
  return all ? kDone : kNo;
}

int refuse(int code, const std::string& why) {
  std::fprintf(stderr, "dwellctl: %s\n", printable(why).c_str());
  return code;
}

// Whether the service that runs serves this very rig file: then its devices are busy with it.
bool serves(const Service& service, const config::RigFile& file) {
  ControlLimits soon;
  soon.time = std::chrono::seconds(2);
  const auto line = control_exchange(service.control, R"({"verb":"status"})", soon);
  const Json answer = line ? Json::parse(*line, nullptr, false) : Json();
  const auto health = answer.is_object() ? answer.find("health") : answer.end();
  return health != answer.end() && health->is_object() && health->contains("rig_sha256") &&
         (*health)["rig_sha256"] == file.sha256;
}

int check_service(const Service& service) {
  const auto line = control_exchange(service.control, R"({"verb":"check"})");
  if (!line)
    return refuse(kUnreachable, line.error() +
                                    "; where no service runs, dwellctl check --rig FILE asks the devices "
                                    "themselves");
  const Json answer = Json::parse(*line, nullptr, false);
  const bool object = answer.is_object();
  if (object && answer.contains("error") && answer["error"].is_string()) {
    return refuse(kNo, service.control + ": " + answer["error"].get<std::string>());
  }
  const auto list = object ? answer.find("channels") : answer.end();
  if (list == answer.end() || !list->is_array()) {
    return refuse(kUnreachable, service.control + ": what answers is not the service");
  }
  return show(probed_from_json(*list), answer, service.json);
}

}  // namespace

int check(const Service& service, const std::string& rig) {
  if (rig.empty()) return check_service(service);
  const auto file =
      config::load(rig, [](std::string_view driver) { return acquire::load_plugin(std::string(driver)); });
  if (!file) {
    std::fputs(config::to_string(rig, file.error()).c_str(), stderr);
    return kUsage;
  }
  if (serves(service, *file)) {
    std::fprintf(stderr, "dwellctl: the service measures with %s and has its devices: what it reads is shown\n",
                 printable(rig).c_str());
    return check_service(service);
  }
  const std::vector<Probed> channels = probe_all(*file);
  return show(channels, check_json(channels), service.json);
}

}  // namespace dwell::ctl
