// The can plugin: signals of a CAN bus by SocketCAN, by a DBC file or as the rig file declares them.
#include <poll.h>

#include <memory>
#include <vector>

#include "drivers/can/reader.hpp"
#include "drivers/can/setup.hpp"
#include "drivers/dwell_driver.hpp"

namespace dwell::can {
namespace {

constexpr std::int64_t kProbe_ns = 1'000'000'000;

socketcan::Open opener(const Setup& setup) {
  return [interface = setup.interface, filters = Reader::filters(setup)] {
    return socketcan::open_socket(interface, filters);
  };
}

class CanDriver {
 public:
  CanDriver(const driver::Settings& settings, const driver::Host& host) : CanDriver(read_setup(settings), host) {}

  void run(driver::Stop& stop) { reader_->run(stop); }

  static void check(const driver::Settings& settings, driver::Report& report) {
    std::vector<Mistake> mistakes;
    static_cast<void>(read_setup(settings, mistakes));
    socketcan::tell(mistakes, report);
  }

  // A frame is pushed as soon as the kernel hands it out; how often it comes is its sender's choice.
  static void describe(const driver::Settings&, dwell_traits& traits) { traits.age_ns = socketcan::kQueueing_ns; }

  // Listens for a second until each channel's frame has come.
  static void probe(const driver::Settings& settings, driver::Probed& probed) {
    const Setup setup = read_setup(settings);
    const driver::Stop never(nullptr);
    Decoder decoder(setup.wanted);
    socketcan::Bus bus(setup.interface, opener(setup));
    std::vector<std::string> missing;
    for (const Channel& channel : setup.channels) missing.push_back(channel.source + ": no frame within 1 s");
    std::string error = bus.open();
    const std::int64_t begin_ns = driver::monotonic_ns(), end_ns = begin_ns + kProbe_ns;
    std::size_t left = setup.channels.size();
    while (error.empty() && left > 0 && never.wait(bus.descriptor(), POLLIN, end_ns) == driver::Stop::Wait::ready) {
      const socketcan::Receipt receipt = bus.read();
      for (const socketcan::Frame& frame : receipt.frames) {
        for (const Reading& reading : decoder.decode(frame.can)) {
          std::string& why = missing[reading.wanted];
          if (why.empty() || reading.verdict == Verdict::absent) continue;
          if (reading.verdict == Verdict::value) {
            probed.value(reading.wanted, reading.value, driver::monotonic_ns() - begin_ns);
            why.clear();
            --left;
          } else {
            why = setup.channels[reading.wanted].source + (reading.verdict == Verdict::short_frame
                                                               ? ": the frame ends before the signal"
                                                               : ": the frame holds what is not a number");
          }
        }
      }
      if (receipt.bus_off) error = bus.name() + ": bus-off";
      if (receipt.error != 0) error = bus.reason(receipt.error);
    }
    for (std::size_t i = 0; i < missing.size(); ++i)
      if (!missing[i].empty()) probed.error(i, error.empty() ? missing[i] : error);
  }

 private:
  CanDriver(Setup setup, const driver::Host& host) {
    socketcan::Open open = opener(setup);
    reader_ = std::make_unique<Reader>(std::move(setup), host, std::move(open));
  }

  std::unique_ptr<Reader> reader_;
};

}  // namespace
}  // namespace dwell::can

DWELL_DRIVER(dwell::can::CanDriver, "can", "1.0.0", "CAN by SocketCAN: signals of a DBC file, or declared by hand",
             dwell::can::keys())
