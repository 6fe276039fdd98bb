// What the plugins say of their devices' settings, and the rates that follow from it.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "config/draft.hpp"
#include "config/driver_table.hpp"
#include "core/fit/folding.hpp"

namespace dwell::config {
namespace {

dwell_traits traits_of(const DeviceDraft& device, const DeviceSettings& settings, const std::string& directory) {
  dwell_traits traits{};
  traits.size = sizeof traits;
  const auto describe = device.driver == nullptr ? nullptr : describe_of(*device.driver);
  if (describe == nullptr || !device.clean) return traits;
  const DriverSettings as_c(settings, directory);
  describe(&as_c.get(), &traits);
  return traits;
}

void set_rate(DeviceSettings& settings, double rate_hz) {
  const auto rate = std::find_if(settings.entries.begin(), settings.entries.end(),
                                 [](const Entry& entry) { return entry.key == "rate"; });
  if (rate == settings.entries.end()) {
    settings.entries.push_back({"rate", rate_hz});
  } else {
    rate->value = rate_hz;
  }
}

}  // namespace

std::string rate_note(const RigFile& file, const DeviceSettings& device) {
  if (!device.rate_hz) return {};
  const Excitation& drive = file.rig.excitation;
  const double asked_hz = device.asked_rate_hz.value_or(*device.rate_hz);
  const Folding folding = worst_folding(asked_hz, drive.frequency_hz, drive.harmonics);
  if (!device.asked_rate_hz) {
    if (folding.harmonic == 0 || folding.distance_hz() >= kClearOfHarmonics * drive.frequency_hz) return {};
    const double beside_hz = rate_beside_foldings(asked_hz, drive.frequency_hz, drive.harmonics);
    return "device " + device.name + " samples at " + number_text(asked_hz) + " Hz, near a whole multiple of " +
           number_text(drive.frequency_hz) + " Hz: harmonic " + std::to_string(folding.harmonic) +
           " of the drive, if there is any, folds onto " +
           (folding.onto == 0 ? std::string("a constant") : "harmonic " + std::to_string(folding.onto)) +
           (beside_hz != asked_hz ? "; " + number_text(beside_hz) + " Hz would keep them apart" : "");
  }
  return "device " + device.name + " samples at " + number_text(*device.rate_hz) + " Hz instead of " +
         number_text(*device.asked_rate_hz) + " Hz, at which harmonic " + std::to_string(folding.harmonic) +
         " of the drive reads as " +
         (folding.onto == 0 ? std::string("a constant") : "harmonic " + std::to_string(folding.onto)) +
         "; rate_shift = false forbids it";
}

std::string line_note(const DeviceSettings& device) {
  const double rate_hz = device.rate_hz.value_or(0.0);
  if (!(device.most_rate_hz > 0) || rate_hz <= device.most_rate_hz) return {};
  char most[32];
  std::snprintf(most, sizeof most, "%.3g", device.most_rate_hz);
  return "device " + device.name + " is asked for " + number_text(rate_hz) + " Hz, its serial line carries " + most +
         " Hz at most: choose a higher baud, fewer registers or a lower rate";
}

void describe_devices(Draft& draft) {
  const Excitation& drive = draft.file.rig.excitation;
  for (std::size_t i = 0; i < draft.devices.size(); ++i) {
    DeviceSettings& settings = draft.file.devices[i];
    const dwell_traits traits = traits_of(draft.devices[i], settings, draft.file.directory);
    settings.leads = traits.leads != 0;
    settings.recorded = traits.recorded != 0;
    settings.most_rate_hz = traits.most_rate_hz;
    settings.age_ns = std::max<std::int64_t>(0, traits.age_ns);
    if (!settings.rate_hz && traits.rate_hz > 0.0 && std::isfinite(traits.rate_hz)) settings.rate_hz = traits.rate_hz;
    if (traits.rate_may_shift != 0 && settings.rate_hz && draft.frequency_known) {
      const double rate_hz = rate_beside_foldings(*settings.rate_hz, drive.frequency_hz, drive.harmonics);
      if (rate_hz != *settings.rate_hz) {
        settings.asked_rate_hz = settings.rate_hz;
        settings.rate_hz = rate_hz;
        set_rate(settings, rate_hz);
      }
    }
    draft.file.rig.devices[i].rate_hz = settings.rate_hz.value_or(0.0);
  }
}

}  // namespace dwell::config
