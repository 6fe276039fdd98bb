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
#include <ctime>
#include <deque>
#include <future>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/rigsim/control.hpp"
#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/sockets.hpp"
#include "tests/rigsim/truth.hpp"

namespace rigsim {
namespace {

constexpr std::size_t kMostConnections = 64;
constexpr std::size_t kMostClients = 8;
constexpr std::size_t kMostPending = 256;
constexpr std::size_t kMostUnread = 2048;             // bytes of requests kept while one is being answered
constexpr std::int64_t kFrameSilenceNs = 50'000'000;  // after which half an RTU frame is forgotten
constexpr std::uint64_t kRtu = 0;                     // link id; TCP connections count from 1

std::int64_t now_ns(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

std::int64_t to_ns(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

// A connection, or the pseudo-terminal.
struct Link {
  std::uint64_t id = kRtu;
  Fd connection;  // TCP
  Bytes in;
  bool busy = false;  // a request is being answered; what follows waits
  std::int64_t last_received_ns = 0;
};

struct Pending {
  std::uint64_t link;
  Request request;
  Fate fate;
  double t_s;  // simulated: when it is sampled
  std::int64_t sample_ns, send_ns;
  bool sampled = false;
  Bytes frame;

  [[nodiscard]] std::int64_t due_ns() const { return sampled ? send_ns : sample_ns; }
};

struct Client {
  Fd fd;
  std::string in;
};

// Simulated time as a straight line of the host's clock; a change of the drift keeps it continuous.
class SimulatedClock {
 public:
  SimulatedClock(std::int64_t start_ns, double drift_ppm) : from_ns_(start_ns) { set_rate(drift_ppm); }
  [[nodiscard]] double at(std::int64_t clock_ns) const {
    const std::scoped_lock lock(mutex_);
    return from_s_ + static_cast<double>(clock_ns - from_ns_) * 1e-9 * rate_;
  }
  void set_drift(std::int64_t clock_ns, double drift_ppm) {
    const double t_s = at(clock_ns);
    const std::scoped_lock lock(mutex_);
    from_ns_ = clock_ns;
    from_s_ = t_s;
    set_rate(drift_ppm);
  }

 private:
  void set_rate(double drift_ppm) { rate_ = 1.0 + 1e-6 * drift_ppm; }
  mutable std::mutex mutex_;
  std::int64_t from_ns_;
  double from_s_ = 0.0;
  double rate_ = 1.0;
};

}  // namespace

struct Server::Impl {
  explicit Impl(Options the_options)
      : options(std::move(the_options)),
        clock(options.clock_ns ? options.clock_ns : [] { return now_ns(CLOCK_MONOTONIC_RAW); }),
        time(clock(), options.clock_drift_ppm),
        responder(options) {}

  // Set up before the thread starts, read-only afterwards.
  Options options;
  std::function<std::int64_t()> clock;
  std::uint16_t port = 0;
  PseudoTerminal terminal;
  SimulatedClock time;

  // The server's thread's own.
  Responder responder;
  Fd tcp_listener, control_listener;
  std::vector<Link> links;
  std::vector<Client> clients;
  std::vector<Pending> pending;
  std::uint64_t next_link = 1;

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

  [[nodiscard]] int descriptor(const Link& link) const {
    return link.id == kRtu ? terminal.master.get() : link.connection.get();
  }
  Link* find(std::uint64_t id);
  void accept_connection();
  void drop_closed();
  void receive(Link& link);
  void process(Link& link);
  void handle(Link& link, const Request& request);
  void transmit(Link& link, const Bytes& frame);
  void run_due();
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
    terminal = std::move(*made);
    links.emplace_back();
    if (!options.rtu_link.empty()) {
      struct stat what {};
      if (::lstat(options.rtu_link.c_str(), &what) == 0 && S_ISLNK(what.st_mode)) ::unlink(options.rtu_link.c_str());
      if (::symlink(terminal.path.c_str(), options.rtu_link.c_str()) != 0) {
        const std::string reason = std::strerror(errno);
        return tl::make_unexpected("cannot link " + std::exchange(options.rtu_link, {}) + ": " + reason);
      }
    }
  }
  if (!options.control_path.empty()) {
    auto listener = listen_unix(options.control_path);
    if (!listener) return tl::make_unexpected(listener.error());
    control_listener = std::move(*listener);
  }
  return {};
}

Link* Server::Impl::find(std::uint64_t id) {
  const auto found = std::find_if(links.begin(), links.end(), [id](const Link& link) { return link.id == id; });
  return found == links.end() || descriptor(*found) < 0 ? nullptr : &*found;
}

void Server::Impl::accept_connection() {
  Link link;
  link.connection = accept_from(tcp_listener, true);
  if (!link.connection || links.size() >= kMostConnections) return;
  link.id = next_link++;
  links.push_back(std::move(link));
}

void Server::Impl::drop_closed() {
  std::erase_if(links, [this](const Link& link) { return descriptor(link) < 0; });
  std::erase_if(clients, [](const Client& client) { return !client.fd; });
  std::erase_if(pending, [this](const Pending& one) { return find(one.link) == nullptr; });
}

void Server::Impl::receive(Link& link) {
  std::array<std::uint8_t, 1024> chunk{};
  const ssize_t size = ::read(descriptor(link), chunk.data(), chunk.size());
  if (size <= 0) {
    if (size == 0 || (errno != EAGAIN && errno != EINTR)) link.connection.close();
    return;
  }
  // Whoever keeps sending without awaiting answers is no Modbus client.
  if (link.in.size() >= kMostUnread) {
    link.in.clear();
    link.connection.close();
    return;
  }
  const std::int64_t now = now_ns(CLOCK_MONOTONIC);
  if (link.id == kRtu && now - link.last_received_ns > kFrameSilenceNs) link.in.clear();
  link.last_received_ns = now;
  link.in.insert(link.in.end(), chunk.begin(), chunk.begin() + size);
  process(link);
}

void Server::Impl::process(Link& link) {
  while (!link.busy && descriptor(link) >= 0) {
    const Parsed parsed = link.id == kRtu ? parse_rtu(link.in) : parse_tcp(link.in);
    if (parsed.kind == Parsed::Kind::incomplete) return;
    if (parsed.kind == Parsed::Kind::broken) {
      link.in.clear();
      link.connection.close();
      return;
    }
    link.in.erase(link.in.begin(), link.in.begin() + static_cast<std::ptrdiff_t>(parsed.request.size));
    handle(link, parsed.request);
  }
}

void Server::Impl::handle(Link& link, const Request& request) {
  const bool rtu = link.id == kRtu;
  const std::int64_t clock_ns = clock();
  const std::int64_t now = now_ns(CLOCK_MONOTONIC);
  const Line line = rtu ? line_settings(terminal) : Line{};
  const Fate fate = responder.decide(request, static_cast<double>(now) * 1e-9, rtu ? &line : nullptr);
  if (fate.kind == Fate::Kind::nothing) return;
  if (fate.kind == Fate::Kind::reset) return reset_connection(link.connection);
  const double t_s = time.at(clock_ns + to_ns(fate.sample_s));
  if (fate.send_s <= 0.0) return transmit(link, responder.answer(request, fate, t_s, rtu));
  if (pending.size() >= kMostPending) return;
  pending.push_back({link.id, request, fate, t_s, now + to_ns(fate.sample_s), now + to_ns(fate.send_s), false, {}});
  link.busy = !fate.out_of_turn;
}

// A client that does not read its answers loses the connection (TCP) or the answer (RTU).
void Server::Impl::transmit(Link& link, const Bytes& frame) {
  if (frame.empty()) return;
  if (link.id == kRtu) {
    [[maybe_unused]] const ssize_t written = ::write(terminal.master.get(), frame.data(), frame.size());
    return;
  }
  const ssize_t sent = ::send(link.connection.get(), frame.data(), frame.size(), MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(frame.size())) link.connection.close();
}

void Server::Impl::run_due() {
  while (!pending.empty()) {
    const auto next = std::min_element(pending.begin(), pending.end(),
                                       [](const Pending& a, const Pending& b) { return a.due_ns() < b.due_ns(); });
    if (next->due_ns() > now_ns(CLOCK_MONOTONIC)) return;
    if (!next->sampled) {
      next->frame = responder.answer(next->request, next->fate, next->t_s, next->link == kRtu);
      next->sampled = true;
      continue;
    }
    const Pending done = std::move(*next);
    pending.erase(next);
    if (Link* link = find(done.link)) {
      transmit(*link, done.frame);
      if (!done.fate.out_of_turn) {
        link->busy = false;
        process(*link);
      }
    }
  }
}

std::string Server::Impl::status() {
  const Tally& tally = responder.tally;
  const dwell::Drive& drive = responder.device.drive();
  const auto connections =
      std::count_if(links.begin(), links.end(), [](const Link& link) { return link.id != kRtu && link.connection; });
  return "ok {\"t_s\":" + std::to_string(time.at(clock())) +
         ",\"running\":" + (responder.device.running() ? "true" : "false") +
         ",\"frequency_hz\":" + std::to_string(drive.frequency_hz) +
         ",\"amplitude\":" + std::to_string(drive.amplitude) + ",\"requests\":" + std::to_string(tally.requests) +
         ",\"answers\":" + std::to_string(tally.answers) + ",\"exceptions\":" + std::to_string(tally.exceptions) +
         ",\"unanswered\":" + std::to_string(tally.unanswered) + ",\"resets\":" + std::to_string(tally.resets) +
         ",\"connections\":" + std::to_string(connections) + ",\"silent\":" + (responder.silent ? "true" : "false") +
         "}";
}

std::string Server::Impl::execute_line(const std::string& line) {
  if (line.size() > kLongestLine) return "error: the line is too long";
  const auto words = split_words(line);
  if (words.empty()) return "error: an empty line";
  if (auto answer = execute(responder.device, time.at(clock()), words)) return *answer;
  const std::string& verb = words[0];
  const bool alone = words.size() == 1;
  const bool on = words.size() == 2 && words[1] == "on";
  const bool off = words.size() == 2 && words[1] == "off";
  if (verb == "status" && alone) return status();
  if (verb == "truth" && alone) return "ok " + truth_json(options.chain, responder.device.drive());
  if (verb == "reset" && alone) {
    for (Link& link : links)
      if (link.connection) reset_connection(link.connection);
    return "ok";
  }
  if (verb == "silent" && (on || off)) {
    responder.silent = on;
    return "ok";
  }
  if (verb == "listen" && (on || off) && options.tcp_port) {
    if (off) {
      tcp_listener.close();
      for (Link& link : links) link.connection.close();
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
  const auto watch = [&](int fd, bool wanted) { polled.push_back({fd, static_cast<short>(wanted ? POLLIN : 0), 0}); };
  watch(wake.get(), true);
  watch(tcp_listener.get(), true);
  watch(control_listener.get(), true);
  const std::size_t link_count = links.size();
  const std::size_t client_count = clients.size();
  for (const Link& link : links) watch(descriptor(link), !link.busy || link.in.size() < kMostUnread);
  for (const Client& client : clients) watch(client.fd.get(), true);

  timespec wait{};
  const timespec* timeout = nullptr;
  if (!pending.empty()) {
    std::int64_t due = pending.front().due_ns();
    for (const Pending& one : pending) due = std::min(due, one.due_ns());
    const std::int64_t left = std::max<std::int64_t>(0, due - now_ns(CLOCK_MONOTONIC));
    wait = {left / 1'000'000'000, left % 1'000'000'000};
    timeout = &wait;
  }
  if (::ppoll(polled.data(), polled.size(), timeout, nullptr) < 0) return;

  run_due();
  const auto ready = [&](std::size_t i) { return polled[i].fd >= 0 && polled[i].revents != 0; };
  for (std::size_t i = 0; i < link_count; ++i)
    if (ready(3 + i) && descriptor(links[i]) >= 0) receive(links[i]);
  for (std::size_t i = 0; i < client_count; ++i)
    if (ready(3 + link_count + i)) serve_client(clients[i]);
  if (ready(0)) take_commands();
  if (ready(1) && tcp_listener) accept_connection();
  if (ready(2)) {
    Client client{accept_from(control_listener, false), {}};
    if (client.fd && clients.size() < kMostClients) clients.push_back(std::move(client));
  }
  drop_closed();
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
  if (impl_->terminal.master && !impl_->options.rtu_link.empty()) ::unlink(impl_->options.rtu_link.c_str());
  if (impl_->control_listener) ::unlink(impl_->options.control_path.c_str());
}

std::uint16_t Server::tcp_port() const { return impl_->port; }

std::string Server::rtu_path() const {
  return impl_->options.rtu_link.empty() ? impl_->terminal.path : impl_->options.rtu_link;
}

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
