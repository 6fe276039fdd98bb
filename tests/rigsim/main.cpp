#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include "tests/rigsim/can_frames.hpp"
#include "tests/rigsim/canopen_nodes.hpp"
#include "tests/rigsim/control.hpp"
#include "tests/rigsim/device.hpp"
#include "tests/rigsim/recording.hpp"
#include "tests/rigsim/server.hpp"
#include "tests/rigsim/sockets.hpp"
#include "tests/rigsim/sync_pulses.hpp"
#include "tests/rigsim/truth.hpp"

namespace {

using rigsim::Options;
using rigsim::RecordingOptions;

constexpr int kWrongUsage = 2;

struct Arguments {
  Options rig;
  RecordingOptions recording;
  rigsim::SyncOptions sync;
  std::string boundary = "clamped";
  std::string parity = "even";
  std::string masses, tcp, unit = "m", csv;
  std::vector<std::string> harmonics, stuck, friction, cubic, side;
  std::vector<std::string> knocks;
  std::string hunt, drift;
  std::vector<std::pair<const char*, std::vector<std::string>>> readings{
      {"refresh", {}}, {"sample", {}}, {"clip", {}},   {"converter", {}}, {"zeros", {}},
      {"repeats", {}}, {"stale", {}},  {"freeze", {}}, {"garbage", {}},   {"low-byte", {}},
      {"glitch", {}},  {"scale", {}},  {"lag", {}},    {"swap", {}}};
  bool print_truth = false;
  bool print_dbc = false;
};

int wrong(const std::string& message) {
  std::cerr << "rigsim: " << message << '\n';
  return kWrongUsage;
}

void define(CLI::App& app, Arguments& arguments) {
  Options& rig = arguments.rig;
  app.add_option("--boundary", arguments.boundary, "clamped or free")->check(CLI::IsMember({"clamped", "free"}));
  app.add_option("--masses", arguments.masses, "m_1,m_2,... kg; none: a clamped element alone");
  app.add_option("--stiffness", rig.chain.stiffness, "c_1,c_2,... N/m")->delimiter(',');
  app.add_option("--damping", rig.chain.damping, "r_1,r_2,... N*s/m")->delimiter(',');
  app.add_option("--frequency", rig.drive.frequency_hz, "of the drive, Hz")->check(CLI::Range(0.0, 1e4));
  app.add_option("--amplitude", rig.drive.amplitude, "of the table, m")->check(CLI::NonNegativeNumber);
  app.add_option("--offset", rig.drive.offset, "of the table, m");
  app.add_option("--harmonic", arguments.harmonics, "MULTIPLE:AMPLITUDE[:PHASE] of the table, m and rad; repeatable");
  app.add_option("--ramp", rig.drive.ramp_s, "within which the drive's amplitude goes over, s")
      ->check(CLI::Range(0.0, 1e3));
  app.add_flag("--from-steady", rig.from_steady, "begin in the steady state instead of at rest");
  app.add_flag("--stopped", rig.stopped, "the drive awaits the control line 'start'");
  app.add_option("--unit", arguments.unit, "of floats and CSV: m or mm")->check(CLI::IsMember({"m", "mm"}));
  app.add_option("--tcp", arguments.tcp, "serve Modbus TCP at ADDRESS:PORT (port 0: any)");
  app.add_option("--rtu", rig.rtu_link, "serve Modbus RTU on a pseudo-terminal, linked from this path");
  app.add_option("--baud", rig.baud, "of the simulated wire; default: as the client sets it")
      ->check(CLI::Range(300, 10000000));
  app.add_option("--parity", arguments.parity, "of the simulated wire: a pseudo-terminal does not tell the client's")
      ->check(CLI::IsMember({"even", "odd", "none"}));
  app.add_option("--can", rig.can, "send CAN frames on this interface, or on unix:PATH, a local bus made for it");
  app.add_option("--canopen", rig.canopen, "CANopen nodes on this interface, or on unix:PATH, one for each channel");
  app.add_option("--can-rate", rig.can_rate_hz, "frames per second and channel")->check(CLI::Range(0.1, 1e4));
  app.add_flag("--print-dbc", arguments.print_dbc, "print the DBC file of these frames, and end");
  app.add_option("--control", rig.control_path, "unix stream socket for control lines");
  app.add_option("--clock-drift", rig.clock_drift_ppm, "of the rig's clock, ppm")->check(CLI::Range(-1e5, 1e5));
  app.add_option("--stuck", arguments.stuck, "a channel stuck from the beginning; repeatable");
  static constexpr const char* kReadings[] = {
      "[TARGET:]S, a register takes a new value this often; TARGET a channel or a station; repeatable",
      "[STATION:]request|middle|answer, when in its turnaround a station samples; repeatable",
      "CHANNEL:LOW:HIGH, where its readings end, in its steady amplitudes; repeatable",
      "CHANNEL:BITS:REACH, its converter ends at +-REACH steady amplitudes; repeatable",
      "[CHANNEL:]P, probability of a zero in place of a reading (without CHANNEL: of a whole scan); repeatable",
      "[CHANNEL:]P, probability of the reading before in its place (likewise); repeatable",
      "[CHANNEL:]N, every Nth reading is the one before once more; repeatable",
      "CHANNEL|all:P:S, probability that a register then holds for S seconds; repeatable",
      "[CHANNEL:]P, probability of a float32 in the wrong order of words; repeatable",
      "CHANNEL:CODE, the low byte of its converter is stuck at 0 ... 255; repeatable",
      "CHANNEL:X[:P], the first reading (with P: with this probability each) is off by X steady amplitudes; repeatable",
      "CHANNEL:FACTOR[:P], its readings (with P: each with this probability) are multiplied by this (-1: reversed); "
      "repeatable",
      "CHANNEL:S[:SPREAD], its readings are so late, each by up to SPREAD more at random; repeatable",
      "CHANNEL:CHANNEL, two channels swapped; repeatable"};
  for (std::size_t i = 0; i < arguments.readings.size(); ++i)
    app.add_option("--" + std::string(arguments.readings[i].first), arguments.readings[i].second, kReadings[i]);
  app.add_option("--friction", arguments.friction, "ELEMENT:N, Coulomb friction in an element; repeatable");
  app.add_option("--cubic", arguments.cubic, "ELEMENT:N/M3, a cubic spring in an element; repeatable");
  app.add_option("--side-spring", arguments.side,
                 "MASS:TO:N/M[:N*S/M], beside the chain, TO a mass, 0 (the table) or ground; repeatable");
  app.add_option("--hunt", arguments.hunt, "PART:HZ, the table's amplitude swings by this part");
  app.add_option("--drift", arguments.drift, "PART:HZ, by which the table's amplitude and frequency grow each second");
  app.add_option(
      "--knocks", arguments.knocks,
      "MASS:N*S:EVERY_S[:UNTIL_S], an impulse to a mass at random instants, so often on average; repeatable");
  app.add_option("--seed", rig.seed, "of everything random");
  for (const rigsim::FaultName& fault : rigsim::fault_names())
    app.add_option("--" + std::string(fault.name), rig.faults.*fault.member, fault.help)
        ->check(CLI::Range(0.0, fault.highest));
  app.add_option("--sync", arguments.sync.file, "the sync output's line, a simulated GPIO chip's sim_gpioK/pull");
  app.add_flag("--print-truth", arguments.print_truth, "print coefficients and steady phasors as JSON, and end");
  RecordingOptions& recording = arguments.recording;
  app.add_option("--csv", arguments.csv, "write a recording to this file (-: standard output), and end");
  app.add_option("--duration", recording.duration_s, "of the recording, s")->check(CLI::Range(0.0, 1e6));
  app.add_option("--rate", recording.rate_hz, "samples per second and channel")->check(CLI::Range(1e-3, 1e6));
  app.add_option("--skew", recording.skew_s, "by which the last channel is sampled after the first, s")
      ->check(CLI::Range(0.0, 10.0));
  app.add_option("--jitter", recording.jitter, "of the instants, uniform, +- this part of the interval")
      ->check(CLI::Range(0.0, 0.49));
  app.add_flag("--long", recording.long_form, "t,channel,value: each sample its own instant");
  app.add_option("--at", recording.script, "\"SECONDS CONTROL LINE\" during the recording; repeatable, in order");
}

// MULTIPLE:AMPLITUDE[:PHASE]
std::optional<dwell::Harmonic> parse_harmonic(const std::string& text) {
  dwell::Harmonic harmonic;
  char rest = 0;
  const int fields =
      std::sscanf(text.c_str(), "%d:%lf:%lf%c", &harmonic.multiple, &harmonic.amplitude, &harmonic.phase_rad, &rest);
  if ((fields != 2 && fields != 3) || harmonic.multiple < 2 || harmonic.multiple > 100) return std::nullopt;
  return harmonic;
}

std::string settle_masses(Arguments& arguments) {
  auto& masses = arguments.rig.chain.masses;
  if (arguments.masses.empty()) return {};
  masses.clear();
  if (arguments.masses == "none") return {};
  std::stringstream list(arguments.masses);
  for (std::string word; std::getline(list, word, ',');) {
    const auto mass = rigsim::number(word);
    if (!mass) return "--masses " + arguments.masses + ": expected numbers with commas between, or none";
    masses.push_back(*mass);
  }
  return {};
}

std::vector<std::string> fields_of(const std::string& text) {
  std::vector<std::string> fields;
  std::stringstream list(text);
  for (std::string field; std::getline(list, field, ':');) fields.push_back(field);
  return fields;
}

// Numbers with colons between, so many at least and at most; empty: they are not.
std::vector<double> numbers_of(const std::string& text, std::size_t fewest, std::size_t most) {
  std::vector<double> numbers;
  for (const std::string& field : fields_of(text)) {
    const auto value = field == "ground" ? std::optional(-1.0) : rigsim::number(field);
    if (!value) return {};
    numbers.push_back(*value);
  }
  return numbers.size() < fewest || numbers.size() > most ? std::vector<double>{} : numbers;
}

std::string settle_bend(Arguments& arguments) {
  rigsim::Bend& bend = arguments.rig.bend;
  for (const auto& [texts, name, member] :
       {std::tuple{&arguments.friction, "friction", &rigsim::Bend::Element::friction},
        {&arguments.cubic, "cubic", &rigsim::Bend::Element::cubic}})
    for (const std::string& text : *texts) {
      const auto values = numbers_of(text, 2, 2);
      if (values.empty()) return "--" + std::string(name) + " " + text + ": expected ELEMENT:NUMBER";
      rigsim::Bend::Element element{static_cast<int>(values[0])};
      element.*member = values[1];
      bend.elements.push_back(element);
    }
  for (const std::string& text : arguments.side) {
    const auto values = numbers_of(text, 3, 4);
    if (values.empty()) return "--side-spring " + text + ": expected MASS:TO:N/M[:N*S/M]";
    bend.side.push_back(
        {static_cast<int>(values[0]), static_cast<int>(values[1]), values[2], values.size() > 3 ? values[3] : 0.0});
  }
  if (!arguments.hunt.empty()) {
    const auto values = numbers_of(arguments.hunt, 2, 2);
    if (values.empty() || values[0] < 0 || values[0] > 1 || values[1] < 0 || values[1] > 1e3)
      return "--hunt " + arguments.hunt + ": expected PART:HZ, the part 0 to 1, at most 1000 Hz";
    bend.hunt = values[0];
    bend.hunt_hz = values[1];
  }
  if (!arguments.drift.empty()) {
    const auto values = numbers_of(arguments.drift, 2, 2);
    if (values.empty() || std::abs(values[0]) > 1 || std::abs(values[1]) > 1e3)
      return "--drift " + arguments.drift + ": expected PART:HZ, each second, the part -1 to 1, at most 1000 Hz";
    bend.drift = values[0];
    bend.drift_hz = values[1];
  }
  return bend.fault(arguments.rig.chain);
}

std::string settle_knocks(Arguments& arguments) {
  for (const std::string& text : arguments.knocks) {
    const auto values = numbers_of(text, 3, 4);
    std::string fault = "expected MASS:N*S:EVERY_S[:UNTIL_S]";
    if (!values.empty()) {
      rigsim::Knocking knocking;
      const bool whole = std::abs(values[0]) < 1e6 && values[0] == std::floor(values[0]);
      knocking.mass = whole ? static_cast<int>(values[0]) : 0;
      knocking.impulse = values[1];
      knocking.every_s = values[2];
      if (values.size() > 3) knocking.until_s = values[3];
      fault = knocking.fault(arguments.rig.chain);
      arguments.rig.knocks.push_back(knocking);
    }
    if (!fault.empty()) return "--knocks " + text + ": " + fault;
  }
  return {};
}

// Control lines of the options that stand for one.
std::string settle_readings(Arguments& arguments) {
  for (const std::string& channel : arguments.stuck) arguments.rig.lines.push_back("stuck " + channel + " on");
  for (const auto& [verb, texts] : arguments.readings)
    for (const std::string& text : texts) {
      const auto fields = fields_of(text);
      std::string line = std::string(verb) + (fields.size() == 1 ? " all" : "");
      for (const std::string& field : fields) line += " " + field;
      arguments.rig.lines.push_back(line);
    }
  return rigsim::Device::fault(arguments.rig);
}

std::string settle(Arguments& arguments) {
  Options& rig = arguments.rig;
  rig.chain.boundary = arguments.boundary == "free" ? dwell::Boundary::free : dwell::Boundary::clamped;
  if (std::string fault = settle_masses(arguments); !fault.empty()) return fault;
  if (std::string fault = rig.chain.fault(); !fault.empty()) return fault;
  for (const std::string& text : arguments.harmonics) {
    const auto harmonic = parse_harmonic(text);
    if (!harmonic) return "--harmonic " + text + ": expected MULTIPLE:AMPLITUDE[:PHASE]";
    rig.drive.harmonics.push_back(*harmonic);
  }
  if (std::string fault = settle_bend(arguments); !fault.empty()) return fault;
  if (std::string fault = settle_knocks(arguments); !fault.empty()) return fault;
  if (std::string fault = settle_readings(arguments); !fault.empty()) return fault;
  rig.millimetres = arguments.unit == "mm";
  arguments.sync.seed = rig.seed;
  rig.rtu = !rig.rtu_link.empty();
  if (!rig.can.empty() && rig.chain.masses.size() > rigsim::kMostCanMasses)
    return "--can: expected at most " + std::to_string(rigsim::kMostCanMasses) + " masses";
  if (!rig.canopen.empty() && rig.chain.masses.size() > rigsim::kMostCanopenMasses)
    return "--canopen: expected at most " + std::to_string(rigsim::kMostCanopenMasses) + " masses";
  if (!rig.canopen.empty() && rig.canopen == rig.can) return "--canopen: expected another interface than that of --can";
  rig.parity = arguments.parity != "none";
  rig.tcp_port.reset();
  if (!arguments.tcp.empty()) {
    const auto colon = arguments.tcp.rfind(':');
    const auto port = colon == std::string::npos ? std::nullopt : rigsim::number(arguments.tcp.substr(colon + 1));
    if (!port || *port < 0 || *port > 65535) return "--tcp " + arguments.tcp + ": expected ADDRESS:PORT";
    rig.tcp_host = arguments.tcp.substr(0, colon);
    rig.tcp_port = static_cast<std::uint16_t>(*port);
  }
  return {};
}

int record(const Arguments& arguments) {
  std::ofstream file;
  if (arguments.csv != "-") file.open(arguments.csv);
  std::ostream& out = arguments.csv == "-" ? std::cout : file;
  if (!out) return wrong("cannot write " + arguments.csv);
  if (const std::string fault = rigsim::write_recording(out, arguments.rig, arguments.recording); !fault.empty())
    return wrong(fault);
  out.flush();
  return out ? 0 : wrong("cannot write " + arguments.csv);
}

// Answers control lines from standard input until a signal comes; the end of the input alone ends nothing.
void attend(rigsim::Server& server, int signals) {
  std::array<pollfd, 2> polled{pollfd{signals, POLLIN, 0}, pollfd{STDIN_FILENO, POLLIN, 0}};
  std::string in;
  while (true) {
    if (::poll(polled.data(), polled.size(), -1) < 0) continue;
    if (polled[0].revents != 0) return;
    if (polled[1].revents == 0) continue;
    std::array<char, 512> chunk{};
    const ssize_t size = ::read(STDIN_FILENO, chunk.data(), chunk.size());
    if (size <= 0) {
      polled[1].fd = -1;
      continue;
    }
    in.append(chunk.data(), static_cast<std::size_t>(size));
    for (auto end = in.find('\n'); end != std::string::npos; end = in.find('\n')) {
      std::cout << server.command(in.substr(0, end)) << std::endl;
      in.erase(0, end + 1);
    }
    if (in.size() > rigsim::kLongestLine) in.clear();
  }
}

int serve(const Arguments& arguments) {
  if (!arguments.rig.tcp_port && !arguments.rig.rtu && arguments.rig.can.empty() && arguments.rig.canopen.empty())
    return wrong("nothing to do: expected --tcp, --rtu, --can, --canopen, --csv, --print-truth or --print-dbc");
  // Blocked before the server's thread is made, so that it inherits this and the signal comes to us.
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  ::sigprocmask(SIG_BLOCK, &set, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  const rigsim::Fd signals(::signalfd(-1, &set, SFD_CLOEXEC));
  auto server = rigsim::Server::start(arguments.rig);
  if (!server) return wrong(server.error());
  std::unique_ptr<rigsim::SyncPulses> sync;
  if (!arguments.sync.file.empty()) {
    auto started = rigsim::SyncPulses::start(arguments.sync, **server);
    if (!started) return wrong(started.error());
    sync = std::move(*started);
  }
  if (arguments.rig.tcp_port) std::cout << "tcp " << arguments.rig.tcp_host << ':' << (*server)->tcp_port() << '\n';
  if (arguments.rig.rtu) std::cout << "rtu " << (*server)->rtu_path() << '\n';
  if (!arguments.rig.can.empty()) std::cout << "can " << arguments.rig.can << '\n';
  if (!arguments.rig.canopen.empty()) std::cout << "canopen " << arguments.rig.canopen << '\n';
  if (!arguments.rig.control_path.empty()) std::cout << "control " << arguments.rig.control_path << '\n';
  std::cout << "ready" << std::endl;
  attend(**server, signals.get());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app(
      "A simulated rig: a driven chain of masses, served as Modbus devices or written as a recording.\n"
      "Station 1 float32 abcd, 2 cdab, 3 badc, 4 dcba; 5-8 float64; 9-12 int32 (nm, mN); 13-16 uint32; 17-20 int16\n"
      "(um, 0.1 N); 21-24 uint16; unsigned ones count from mid-range. Channel i (the table, the masses, the ground\n"
      "force) begins at register i times the type's words, in both tables. Control lines are read from standard "
      "input.");
  define(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kWrongUsage;
  }
  if (const std::string fault = settle(arguments); !fault.empty()) return wrong(fault);
  if (arguments.print_truth) {
    std::cout << rigsim::truth_json(arguments.rig.chain, arguments.rig.drive) << '\n';
    return 0;
  }
  if (arguments.print_dbc) {
    const rigsim::Device device(arguments.rig);
    std::cout << rigsim::can_dbc(device.channels(), arguments.rig.chain.boundary == dwell::Boundary::clamped,
                                 1e3 / arguments.rig.can_rate_hz);
    return 0;
  }
  return arguments.csv.empty() ? serve(arguments) : record(arguments);
}
