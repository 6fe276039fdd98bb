// The rig file: read, checked whole, and turned into plain structs.
//
// load() either returns everything, fit to be handed to the pipeline and to the plugins without another look, or every
// mistake in the file with its line and column. Nothing here keeps state; all functions are safe to call from any
// thread as long as the schema source is. Cost: milliseconds; never on the sample path.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "config/driver_settings.hpp"
#include "config/listen_address.hpp"
#include "config/mistake.hpp"
#include "core/rig/rig.hpp"
#include "drivers/dwell_driver.h"

namespace dwell::config {

struct ServerSettings {
  ListenAddress listen{"127.0.0.1:8380", "127.0.0.1", 8380};
  std::vector<std::string> names;  // by which clients may ask for it
  std::string token_file;          // absolute, or relative to the working directory; empty: none
  bool behind_proxy = false;       // a front proxy says who may read: whoever reaches the address is believed
  // Positions in the file, for messages of the service. The service checks address and token file itself, since an old
  // run must be replayed without them.
  Position listen_at, token_file_at;
};

// The Modbus TCP server for PLCs. Modbus has no access rights.
struct ModbusServerSettings {
  ListenAddress listen;
  bool open_to_network = false;  // an address beyond loopback is allowed: whoever reaches it may read
  Position listen_at;            // as in ServerSettings
};

// Anchors: every so often the newest head of each chain is copied to a place outside the record, so that an auditor
// sees whether the end of a file was cut off later.
struct AnchorSettings {
  double minutes = 10.0;             // between two anchors
  std::string file;                  // each anchor is a line of it; empty: none
  std::vector<std::string> command;  // program and arguments; it reads the line on its input; empty: none
};

struct RecordingSettings {
  bool on = false;                           // the file has a table [recording]: runs are recorded
  std::string directory = "/var/lib/dwell";  // a relative one starts at the rig file's directory
  double every_s = 1.0;                      // between two stored results of a dwell that goes on
  std::optional<double> retain_days;         // a run is deleted so long after its end; none: never
  std::optional<double> retain_gigabytes;    // while all runs are larger, the oldest is deleted; none: no bound
  std::optional<AnchorSettings> anchor;
};

struct VerificationSettings {
  double accuracy = 0.05;  // of each channel's rms: what the model is needed for
  bool live = true;  // the service estimates from transients and verifies; false: only dwellctl does, of recordings
};

struct GpioLine {
  enum class Bias : std::uint8_t { as_is, disabled, pull_up, pull_down };
  std::string chip;  // "/dev/gpiochip0"
  unsigned line = 0;
  bool active_low = false;
  Bias bias = Bias::as_is;  // inputs only
  double debounce_s = 0.0;  // inputs only
};

struct GpioSettings {
  std::optional<GpioLine> interlock;  // input: shaker permitted to run
  std::optional<GpioLine> sync;       // input: one pulse per excitation period
  std::optional<GpioLine> ready;      // output: lamp
  std::optional<GpioLine> fault;      // output: lamp
};

struct RigFile {
  Rig rig;
  std::vector<DeviceSettings> devices;  // in the order of rig.devices
  ServerSettings server;
  RecordingSettings recording;
  VerificationSettings verification;
  std::optional<ModbusServerSettings> modbus_server;  // none: PLCs do not read
  GpioSettings gpio;
  std::string path;       // as given
  std::string directory;  // of the file: relative paths in it start there
  std::string sha256;     // of the file's bytes, hexadecimal
  std::string text;       // these bytes
};

// The driver table of a name, or one line that says why there is none ("no driver \"x\": installed are modbus,
// replay"). An empty function leaves the drivers' keys unchecked: a rig file that goes with a recording as text needs
// no devices, and its channels no `device`.
using SchemaSource = std::function<tl::expected<const dwell_driver_table*, std::string>(std::string_view driver)>;

inline constexpr std::size_t kMaxFileBytes = 1u << 20;
inline constexpr std::size_t kMaxChannels = 65535;
inline constexpr std::size_t kMaxDevices = 1000;
// The covariance of all coefficients is (2n + 2)² numbers, told ten times a second: 0.3 MB each at 100 masses.
inline constexpr std::size_t kMaxMasses = 100;

// A warning: the line cannot carry this rate, with the highest that it can. Empty: it can, or that is not known.
[[nodiscard]] std::string line_note(const DeviceSettings& device);

// One line for people: why a device's rate was shifted; or, a warning, which harmonic of the drive a rate folds that
// was not (DeviceSettings::asked_rate_hz is not set). Empty: neither.
[[nodiscard]] std::string rate_note(const RigFile& file, const DeviceSettings& device);

// Reads and checks the file at `path`. Fails with every mistake (of syntax errors the first), sorted by position; a
// file that cannot be read, is no regular file or exceeds kMaxFileBytes is one mistake without a position.
[[nodiscard]] Result<RigFile> load(const std::string& path, const SchemaSource& schemas);

// The same for the file's text; `path` is only what the file is called.
[[nodiscard]] Result<RigFile> parse(std::string_view text, const std::string& path, const SchemaSource& schemas);

}  // namespace dwell::config
