// The canopen plugin: a small master that has transducers (CiA 404, CiA 406 and others) sample at its SYNC.
#include <poll.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "drivers/canopen/master.hpp"
#include "drivers/canopen/sdo_client.hpp"
#include "drivers/canopen/setup.hpp"
#include "drivers/canopen/words.hpp"
#include "drivers/dwell_driver.hpp"

namespace dwell::canopen {
namespace {

socketcan::Open opener(const Setup& setup) {
  return [interface = setup.interface, filters = Network::filters(setup)] {
    return socketcan::open_socket(interface, filters, socketcan::OwnFrames::returned);
  };
}

// Reads one object without touching what the node does meanwhile.
class Asker {
 public:
  explicit Asker(const Setup& setup) : bus_(setup.interface, opener(setup)), error_(bus_.open()) {}

  // What is wrong, or empty.
  std::string ask(std::uint8_t node, const Wanted& wanted, double& value) {
    if (!error_.empty()) return error_;
    SdoClient client(node);
    client.upload(wanted.object, driver::monotonic_ns());
    // Attempts while there is time; one for every node.
    const std::int64_t end_ns = std::max(end_ns_, driver::monotonic_ns() + SdoClient::kTimeout_ns);
    while (client.state() == SdoClient::State::busy) {
      while (const auto frame = client.to_send()) {
        if (const int error = bus_.write(wide(*frame)); error != 0) return error_ = bus_.reason(error);
      }
      const std::int64_t now_ns = driver::monotonic_ns();
      if (now_ns >= end_ns) return "node " + std::to_string(node) + ": no answer";
      client.tick(now_ns);
      if (never_.wait(bus_.descriptor(), POLLIN, std::min(end_ns, now_ns + kTick_ns)) != driver::Stop::Wait::ready)
        continue;
      const socketcan::Receipt receipt = bus_.read();
      if (receipt.error != 0) return error_ = bus_.reason(receipt.error);
      if (receipt.bus_off) return error_ = bus_.name() + ": bus-off";
      for (const socketcan::Frame& frame : receipt.frames) {
        if (frame.own || frame.fd || frame.can.can_id != kSdoAnswer + node) continue;
        client.take(classic(frame.can), driver::monotonic_ns());
      }
    }
    const std::string what = "node " + std::to_string(node) + ", " + to_string(wanted.object) + ": ";
    if (client.state() != SdoClient::State::done) return what + abort_text(client.abort_code());
    const std::size_t bits = 8 * client.data().size();
    if (client.sized() ? bits != wanted.type.bits : bits < wanted.type.bits)
      return what + std::to_string(client.data().size()) + " bytes, but " + to_string(wanted.type) + " has " +
             std::to_string(wanted.type.bits / 8);
    const Reading reading = read_value(client.data(), 0, wanted.type);
    if (reading.verdict != Verdict::value) return what + "is no number";
    value = reading.value;
    return {};
  }

 private:
  static constexpr std::int64_t kTick_ns = 10'000'000, kTogether_ns = 900'000'000;

  driver::Stop never_{nullptr};
  std::int64_t end_ns_ = driver::monotonic_ns() + kTogether_ns;
  socketcan::Bus bus_;
  std::string error_;
};

class CanopenDriver {
 public:
  CanopenDriver(const driver::Settings& settings, const driver::Host& host) {
    const Setup setup = read_setup(settings);
    master_ = std::make_unique<Master>(setup, host, opener(setup));
  }

  void run(driver::Stop& stop) { master_->run(stop); }

  static void check(const driver::Settings& settings, driver::Report& report) {
    std::vector<Mistake> mistakes;
    static_cast<void>(read_setup(settings, mistakes));
    socketcan::tell(mistakes, report);
  }

  // A scan is delivered when the next SYNC is due, which a missing answer puts off.
  static void describe(const driver::Settings& settings, dwell_traits& traits) {
    std::vector<Mistake> mistakes;
    const Setup setup = read_setup(settings, mistakes);
    traits.rate_may_shift = settings.get<bool>("rate_shift", true) ? 1 : 0;
    traits.rate_hz = 1e9 / static_cast<double>(setup.period_ns);
    traits.age_ns = setup.period_ns + setup.late_ns;
  }

  // Reads the objects themselves by SDO: a node that is in operation stays as it is.
  static void probe(const driver::Settings& settings, driver::Probed& probed) {
    const Setup setup = read_setup(settings);
    Asker asker(setup);
    for (const Wish& wish : setup.nodes) {
      std::string silent;
      for (const Wanted& wanted : wish.wanted) {
        const std::int64_t begin_ns = driver::monotonic_ns();
        double value = 0.0;
        const std::string error = silent.empty() ? asker.ask(wish.node, wanted, value) : silent;
        if (error.empty())
          probed.value(wanted.channel, value, driver::monotonic_ns() - begin_ns);
        else
          probed.error(wanted.channel, error);
        if (!error.empty() && driver::monotonic_ns() - begin_ns >= SdoClient::kTimeout_ns) silent = error;
      }
    }
  }

 private:
  std::unique_ptr<Master> master_;
};

}  // namespace
}  // namespace dwell::canopen

DWELL_DRIVER(dwell::canopen::CanopenDriver, "canopen", "1.0.0",
             "CANopen master: objects of CiA 404 and 406 transducers, sampled at SYNC", dwell::canopen::keys())
