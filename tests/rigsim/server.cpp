#include "tests/rigsim/server.hpp"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "tests/rigsim/can_node.hpp"
#include "tests/rigsim/canopen_nodes.hpp"
#include "tests/rigsim/control.hpp"
#include "tests/rigsim/exchange.hpp"
#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/simulated_clock.hpp"
#include "tests/rigsim/sockets.hpp"
#include "tests/rigsim/truth.hpp"

namespace rigsim {
namespace {

using dwell::driver::monotonic_ns;

constexpr std::size_t kMostControlClients = 8;

struct Client {
  Fd fd;
  std::string in;
};

}  // namespace

struct Server::Impl {
  explicit Impl(Options the_options)
      : options(std::move(the_options)),
        clock(options.clock_ns ? options.clock_ns : dwell::driver::raw_ns),
        time(clock(), options.clock_drift_ppm),
        responder(options),
        exchange(responder, clock, time),
        can(options, responder, clock, time),
        canopen(options, responder, clock, time) {}

  // Set up before the thread starts, read-only afterwards.
  Options options;
  std::function<std::int64_t()> clock;
  std::uint16_t port = 0;
  std::string rtu_path;
  SimulatedClock time;

  // The server's thread's own.
  Responder responder;
  Exchange exchange;
  CanNodes can;
  CanopenNodes canopen;
  Fd tcp_listener, control_listener;
  std::vector<Client> clients;

  // Between threads.
  Fd wake;
  std::mutex mutex;
  std::deque<std::packaged_task<std::string()>> commands;
  bool stopping = false;
  std::thread thread;

  Result<void> open();
  void run();
  void serve_once();
  void take_commands();
  std::string execute_line(const std::string& line);
  std::string status();

  void serve_client(Client& client);
};

Result<void> Server::Impl::open() {
  wake = Fd(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC));
  if (!wake) return tl::make_unexpected(std::string("cannot make an eventfd: ") + std::strerror(errno));
  if (options.tcp_port) {
    auto listener = listen_tcp(options.tcp_host, *options.tcp_port);
    if (!listener) return tl::make_unexpected(listener.error());
    tcp_listener = std::move(*listener);
    port = bound_port(tcp_listener);
  }
  if (options.rtu) {
    auto made = open_pseudo_terminal();
    if (!made) return tl::make_unexpected(made.error());
    rtu_path = made->path;
    if (!options.rtu_link.empty()) {
      struct stat what {};
      if (::lstat(options.rtu_link.c_str(), &what) == 0 && S_ISLNK(what.st_mode)) ::unlink(options.rtu_link.c_str());
      if (::symlink(rtu_path.c_str(), options.rtu_link.c_str()) != 0) {
        const std::string reason = std::strerror(errno);
        return tl::make_unexpected("cannot link " + options.rtu_link + ": " + reason);
      }
      rtu_path = options.rtu_link;
    }
    exchange.add_terminal(std::move(*made), options.parity);
  }
  if (auto opened = can.open(); !opened) return opened;
  if (auto opened = canopen.open(); !opened) return opened;
  if (!options.control_path.empty()) {
    auto listener = listen_unix(options.control_path);
    if (!listener) return tl::make_unexpected(listener.error());
    control_listener = std::move(*listener);
  }
  return {};
}

std::string Server::Impl::status() {
  const Tally& tally = responder.tally;
  const dwell::Drive& drive = responder.device.drive();
  return "ok {\"t_s\":" + std::to_string(time.at(clock())) +
         ",\"running\":" + (responder.device.running() ? "true" : "false") +
         ",\"frequency_hz\":" + std::to_string(drive.frequency_hz) +
         ",\"amplitude\":" + std::to_string(drive.amplitude) +
         ",\"sync_missing\":" + std::to_string(responder.device.faults.sync_missing) +
         ",\"sync_twice\":" + std::to_string(responder.device.faults.sync_twice) +
         ",\"requests\":" + std::to_string(tally.requests) + ",\"answers\":" + std::to_string(tally.answers) +
         ",\"exceptions\":" + std::to_string(tally.exceptions) + ",\"unanswered\":" + std::to_string(tally.unanswered) +
         ",\"resets\":" + std::to_string(tally.resets) +
         ",\"connections\":" + std::to_string(exchange.connection_count()) +
         ",\"silent\":" + (responder.silent ? "true" : "false") + (options.can.empty() ? "" : "," + can.status()) +
         (options.canopen.empty() ? "" : "," + canopen.status()) + "}";
}

std::string Server::Impl::execute_line(const std::string& line) {
  if (line.size() > kLongestLine) return "error: the line is too long";
  const auto words = split_words(line);
  if (words.empty()) return "error: an empty line";
  if (auto answer = execute(responder.device, time.at(clock()), words)) return *answer;
  if (auto answer = can.command(words)) return *answer;
  if (auto answer = canopen.command(words)) return *answer;
  const std::string& verb = words[0];
  const bool alone = words.size() == 1;
  const bool on = words.size() == 2 && words[1] == "on";
  const bool off = words.size() == 2 && words[1] == "off";
  if (verb == "status" && alone) return status();
  if (verb == "truth" && alone) return "ok " + truth_json(options.chain, responder.device.drive());
  if (verb == "reset" && alone) {
    exchange.reset_connections();
    return "ok";
  }
  if (verb == "silent" && (on || off)) {
    responder.silent = on;
    return "ok";
  }
  if (verb == "listen" && (on || off) && options.tcp_port) {
    if (off) {
      tcp_listener.close();
      exchange.close_connections();
    } else if (!tcp_listener) {
      auto listener = listen_tcp(options.tcp_host, port);
      if (!listener) return "error: " + listener.error();
      tcp_listener = std::move(*listener);
    }
    return "ok";
  }
  if (verb == "clock-drift" && words.size() == 2) {
    const auto ppm = number(words[1]);
    if (!ppm || std::abs(*ppm) > 1e5) return "error: expected: clock-drift PPM, at most 100000";
    time.set_drift(clock(), *ppm);
    can.set_drift(*ppm);
    canopen.set_drift(*ppm);
    return "ok";
  }
  return "error: cannot make out: " + line;
}

void Server::Impl::take_commands() {
  std::uint64_t count = 0;
  [[maybe_unused]] const ssize_t size = ::read(wake.get(), &count, sizeof count);
  std::deque<std::packaged_task<std::string()>> taken;
  {
    const std::scoped_lock lock(mutex);
    taken.swap(commands);
  }
  for (auto& task : taken) task();
}

void Server::Impl::serve_client(Client& client) {
  std::array<char, 512> chunk{};
  const ssize_t size = ::read(client.fd.get(), chunk.data(), chunk.size());
  if (size <= 0) {
    if (size == 0 || (errno != EAGAIN && errno != EINTR)) client.fd.close();
    return;
  }
  client.in.append(chunk.data(), static_cast<std::size_t>(size));
  std::string answers;
  for (auto end = client.in.find('\n'); end != std::string::npos; end = client.in.find('\n')) {
    answers += execute_line(client.in.substr(0, end)) + "\n";
    client.in.erase(0, end + 1);
  }
  const bool endless = client.in.size() > kLongestLine;
  if (endless) answers += "error: the line is too long\n";
  const ssize_t sent = ::send(client.fd.get(), answers.data(), answers.size(), MSG_NOSIGNAL);
  if (endless || sent != static_cast<ssize_t>(answers.size())) client.fd.close();
}

void Server::Impl::serve_once() {
  std::vector<pollfd> polled;
  const auto watch = [&](int fd) { polled.push_back({fd, POLLIN, 0}); };
  watch(wake.get());
  watch(tcp_listener.get());
  watch(control_listener.get());
  for (const Client& client : clients) watch(client.fd.get());
  const std::size_t client_count = clients.size();
  const std::size_t first_link = polled.size();
  exchange.watch(polled);
  const std::size_t link_count = polled.size() - first_link;
  can.watch(polled);
  canopen.watch(polled);

  timespec wait{};
  auto due_ns = exchange.next_due_ns();
  for (const auto bus_ns : {can.next_due_ns(), canopen.next_due_ns()})
    if (bus_ns) due_ns = due_ns ? std::min(*due_ns, *bus_ns) : *bus_ns;
  if (due_ns) {
    const std::int64_t left = std::max<std::int64_t>(0, *due_ns - monotonic_ns());
    wait = {left / 1'000'000'000, left % 1'000'000'000};
  }
  if (::ppoll(polled.data(), polled.size(), due_ns ? &wait : nullptr, nullptr) < 0) return;

  exchange.serve(std::span(polled).subspan(first_link, link_count));
  can.serve(monotonic_ns());
  canopen.serve(monotonic_ns());
  const auto ready = [&](std::size_t i) { return polled[i].fd >= 0 && polled[i].revents != 0; };
  for (std::size_t i = 0; i < client_count; ++i)
    if (ready(3 + i)) serve_client(clients[i]);
  if (ready(0)) take_commands();
  if (ready(1) && tcp_listener) exchange.accept_connection(tcp_listener);
  if (ready(2)) {
    Client client{accept_from(control_listener, false), {}};
    if (client.fd && clients.size() < kMostControlClients) clients.push_back(std::move(client));
  }
  std::erase_if(clients, [](const Client& client) { return !client.fd; });
  exchange.sweep();
}

void Server::Impl::run() {
  ::pthread_setname_np(::pthread_self(), "rigsim");
  // A turnaround of 0.2 ms should not be 0.25 ms: timers are otherwise allowed 50 µs.
  ::prctl(PR_SET_TIMERSLACK, 1000UL, 0, 0, 0);
  while (true) {
    {
      const std::scoped_lock lock(mutex);
      if (stopping) return;
    }
    serve_once();
  }
}

tl::expected<std::unique_ptr<Server>, std::string> Server::start(Options options) {
  if (const std::string fault = options.chain.fault(); !fault.empty()) return tl::make_unexpected(fault);
  std::unique_ptr<Server> server(new Server(std::make_unique<Impl>(std::move(options))));
  Impl& impl = *server->impl_;
  if (auto opened = impl.open(); !opened) return tl::make_unexpected(opened.error());
  impl.thread = std::thread([&impl] { impl.run(); });
  return server;
}

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Server::~Server() {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->stopping = true;
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t size = ::write(impl_->wake.get(), &one, sizeof one);
  if (impl_->thread.joinable()) impl_->thread.join();
  if (!impl_->rtu_path.empty() && impl_->rtu_path == impl_->options.rtu_link) ::unlink(impl_->options.rtu_link.c_str());
  if (impl_->control_listener) ::unlink(impl_->options.control_path.c_str());
}

std::uint16_t Server::tcp_port() const { return impl_->port; }

std::string Server::rtu_path() const { return impl_->rtu_path; }

std::string Server::command(const std::string& line) {
  std::packaged_task<std::string()> task([this, line] { return impl_->execute_line(line); });
  auto answer = task.get_future();
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->commands.push_back(std::move(task));
  }
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t size = ::write(impl_->wake.get(), &one, sizeof one);
  return answer.get();
}

double Server::simulated_time_s(std::int64_t clock_ns) const { return impl_->time.at(clock_ns); }

}  // namespace rigsim
