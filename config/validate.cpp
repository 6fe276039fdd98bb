#include <map>

#include "config/draft.hpp"
#include "config/observability.hpp"

namespace dwell::config {
namespace {

constexpr double kLeastPeriods = 5.0;
constexpr double kMostPeriods = 1e8;  // of memory: what the estimator counts in quarters of a period stays an int

bool is_motion(const Channel& channel) {
  return channel.measures != Quantity::force && channel.measures != Quantity::auxiliary;
}

// Notes the second and every further thing of one name.
class Names {
 public:
  Names(const char* what, MistakeList& mistakes) : what_(what), mistakes_(&mistakes) {}
  void add(const std::string& name, const Section& section) {
    if (section.peek("name") == nullptr) return;
    const auto [first, is_new] = first_.emplace(name, section.where("name"));
    if (is_new) return;
    mistakes_->add(section.where("name"), std::string("two ") + what_ + " are named " + in_quotes(name) +
                                              ", the first in line " + std::to_string(first->second.line) +
                                              ": expected a name of its own");
  }

 private:
  const char* what_;
  MistakeList* mistakes_;
  std::map<std::string, Position> first_;
};

void check_names(Draft& draft) {
  Names devices("devices", draft.mistakes);
  for (std::size_t i = 0; i < draft.devices.size(); ++i) {
    devices.add(draft.file.devices[i].name, draft.devices[i].section);
  }
  Names channels("channels", draft.mistakes);
  for (std::size_t i = 0; i < draft.channels.size(); ++i) {
    channels.add(draft.file.rig.channels[i].name, draft.channels[i].section);
  }
}

void check_places(Draft& draft) {
  if (!draft.rig || !draft.masses_known || draft.channels.empty()) return;
  const Rig& rig = draft.file.rig;
  std::vector<Transducer> motions;
  for (std::size_t i = 0; i < draft.channels.size(); ++i) {
    const ChannelDraft& notes = draft.channels[i];
    // A channel whose `measures` is a mistake gets the benefit of the doubt.
    const bool motion = !notes.measures_known || is_motion(rig.channels[i]);
    if (motion && notes.place_known) motions.push_back({rig.channels[i].at, rig.channels[i].relative_to});
  }
  const toml::node* masses = draft.rig->peek("masses");
  for (const int place : undetermined_places(rig.mass_count(), motions)) {
    Position at = draft.rig->where("masses");
    std::string who = "the table";
    if (place > 0) {
      at = position(*masses->as_array()->get(static_cast<std::size_t>(place - 1)));
      who = "mass " + std::to_string(place);
    }
    draft.mistakes.add(at, "the motion of " + who +
                               " is given by no combination of transducers: expected a channel at " +
                               std::to_string(place) + ", or one across to a place whose motion is given");
  }
}

void check_boundary(Draft& draft) {
  if (!draft.rig || !draft.boundary_known) return;
  const Rig& rig = draft.file.rig;
  if (rig.boundary == Boundary::free) {
    if (draft.masses_known && rig.masses.empty()) {
      draft.rig->wrong("masses", "a free chain has no masses: expected at least one (none goes with \"clamped\")");
    }
    return;
  }
  if (draft.file.rig.channels.empty()) return;
  for (std::size_t i = 0; i < draft.channels.size(); ++i) {
    if (!draft.channels[i].measures_known || rig.channels[i].measures == Quantity::force) return;
  }
  draft.rig->wrong("boundary",
                   "the chain is clamped, and no channel measures the force on the ground: expected a channel "
                   "with measures = \"force\", at = \"ground\"");
}

void check_rates(Draft& draft) {
  if (!draft.frequency_known) return;
  const Excitation& drive = draft.file.rig.excitation;
  const double least_hz = 2.0 * (drive.harmonics + 1) * drive.frequency_hz;
  std::vector<bool> identified(draft.devices.size(), false);
  for (const Channel& channel : draft.file.rig.channels) {
    if (channel.device >= 0 && channel.measures != Quantity::auxiliary) {
      identified[static_cast<std::size_t>(channel.device)] = true;
    }
  }
  for (std::size_t i = 0; i < draft.devices.size(); ++i) {
    const std::optional<double>& rate_hz = draft.file.devices[i].rate_hz;
    if (!rate_hz || !identified[i] || *rate_hz >= least_hz) continue;
    const char* const whose = draft.devices[i].section.peek("rate") == nullptr ? " by default" : "";
    draft.devices[i].section.wrong("rate", "\"rate\" is " + number_text(*rate_hz) + whose + ", too slow for " +
                                               std::to_string(drive.harmonics) + " harmonics of " +
                                               number_text(drive.frequency_hz) +
                                               " Hz: expected at least 2 (H + 1) f = " + number_text(least_hz) + " Hz");
  }
}

void check_memory(Draft& draft) {
  if (!draft.frequency_known) return;
  const double frequency_hz = draft.file.rig.excitation.frequency_hz;
  const double periods = draft.file.rig.memory_s * frequency_hz;
  if (periods >= kLeastPeriods && periods <= kMostPeriods) return;
  const bool given = draft.estimation && draft.estimation->peek("memory") != nullptr;
  const std::string message = "a memory of " + number_text(draft.file.rig.memory_s) + " s holds " +
                              number_text(periods) + " periods: expected " + number_text(kLeastPeriods) + " to " +
                              number_text(kMostPeriods) + ", that is " + number_text(kLeastPeriods / frequency_hz) +
                              " to " + number_text(kMostPeriods / frequency_hz) + " s";
  if (given) {
    draft.estimation->wrong("memory", message);
  } else {
    draft.excitation->wrong("frequency", message + " (key \"memory\" in [estimation])");
  }
}

void check_sync(Draft& draft) {
  if (draft.file.rig.excitation.reference != Reference::sync) return;
  // A line with a mistake of its own is there all the same.
  if (draft.gpio && draft.gpio->peek("sync") != nullptr) return;
  draft.excitation->wrong("reference",
                          "\"reference\" is \"sync\", and [gpio] has no \"sync\": expected the line of the "
                          "sync input there");
}

// Two servers cannot listen on one port.
void check_listeners(Draft& draft) {
  if (!draft.file.modbus_server) return;
  const ServerSettings& server = draft.file.server;
  const ModbusServerSettings& modbus = *draft.file.modbus_server;
  if (!collide(server.listen, modbus.listen)) return;
  draft.mistakes.add(modbus.listen_at, "\"listen\" is " + in_quotes(modbus.listen.text) + ", and [server] listens on " +
                                           in_quotes(server.listen.text) + ": expected a port of its own");
}

}  // namespace

void validate(Draft& draft) {
  check_listeners(draft);
  check_names(draft);
  check_boundary(draft);
  check_places(draft);
  check_rates(draft);
  check_memory(draft);
  check_sync(draft);
  for (std::size_t i = 0; i < draft.devices.size(); ++i) run_driver_check(draft.devices[i], i, draft);
}

}  // namespace dwell::config
