#include "tests/rigsim/exchange.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "drivers/dwell_driver.hpp"

namespace rigsim {
namespace {

using dwell::driver::monotonic_ns;

constexpr std::size_t kMostLinks = 64;
constexpr std::size_t kMostPending = 256;
constexpr std::size_t kMostUnread = 2048;             // bytes of requests kept while one is being answered
constexpr std::int64_t kFrameSilenceNs = 50'000'000;  // after which half an RTU frame is forgotten
constexpr std::uint64_t kRtu = 0;                     // link id; TCP connections count from 1

std::int64_t to_ns(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }

}  // namespace

Exchange::Exchange(Responder& responder, const std::function<std::int64_t()>& clock, const SimulatedClock& time)
    : responder_(responder), clock_(clock), time_(time) {}

void Exchange::add_terminal(PseudoTerminal terminal, bool parity) {
  parity_ = parity;
  terminal_ = std::move(terminal);
  links_.push_back({kRtu, {}, {}});
}

int Exchange::descriptor(const Link& link) const {
  return link.id == kRtu ? terminal_.master.get() : link.connection.get();
}

Exchange::Link* Exchange::find(std::uint64_t id) {
  const auto found = std::find_if(links_.begin(), links_.end(), [id](const Link& link) { return link.id == id; });
  return found == links_.end() || descriptor(*found) < 0 ? nullptr : &*found;
}

void Exchange::accept_connection(const Fd& listener) {
  Fd connection = accept_from(listener, true);
  if (connection && links_.size() < kMostLinks) links_.push_back({next_id_++, std::move(connection), {}});
}

void Exchange::close_connections() {
  for (Link& link : links_) link.connection.close();
}

void Exchange::reset_connections() {
  for (Link& link : links_)
    if (link.connection) reset_connection(link.connection);
}

std::size_t Exchange::connection_count() const {
  return static_cast<std::size_t>(
      std::count_if(links_.begin(), links_.end(), [](const Link& link) { return bool(link.connection); }));
}

void Exchange::watch(std::vector<pollfd>& polled) const {
  for (const Link& link : links_) {
    const bool wanted = !link.busy || link.in.size() < kMostUnread;
    polled.push_back({descriptor(link), static_cast<short>(wanted ? POLLIN : 0), 0});
  }
}

void Exchange::serve(std::span<const pollfd> polled) {
  run_due();
  for (std::size_t i = 0; i < polled.size(); ++i)
    if (polled[i].fd >= 0 && polled[i].revents != 0 && descriptor(links_[i]) >= 0) receive(links_[i]);
}

std::optional<std::int64_t> Exchange::next_due_ns() const {
  const auto next = std::min_element(pending_.begin(), pending_.end(),
                                     [](const Pending& a, const Pending& b) { return a.due_ns() < b.due_ns(); });
  return next == pending_.end() ? std::nullopt : std::optional(next->due_ns());
}

void Exchange::sweep() {
  std::erase_if(links_, [this](const Link& link) { return descriptor(link) < 0; });
  std::erase_if(pending_, [this](const Pending& one) { return find(one.link) == nullptr; });
}

void Exchange::receive(Link& link) {
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
  const std::int64_t now = monotonic_ns();
  if (link.id == kRtu && now - link.last_received_ns > kFrameSilenceNs) link.in.clear();
  link.last_received_ns = now;
  link.in.insert(link.in.end(), chunk.begin(), chunk.begin() + size);
  process(link);
}

void Exchange::process(Link& link) {
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

void Exchange::handle(Link& link, const Request& request) {
  const bool rtu = link.id == kRtu;
  const std::int64_t clock_ns = clock_();
  const std::int64_t now = monotonic_ns();
  const Line line = rtu ? line_settings(terminal_, parity_) : Line{};
  const Fate fate = responder_.decide(request, static_cast<double>(now) * 1e-9, rtu ? &line : nullptr);
  if (fate.kind == Fate::Kind::nothing) return;
  if (fate.kind == Fate::Kind::reset) return reset_connection(link.connection);
  const double t_s = time_.at(clock_ns + to_ns(fate.sample_s));
  if (fate.send_s <= 0.0) return transmit(link, responder_.answer(request, fate, t_s, rtu));
  if (pending_.size() >= kMostPending) return;
  pending_.push_back({link.id, request, fate, t_s, now + to_ns(fate.sample_s), now + to_ns(fate.send_s), false, {}});
  link.busy = !fate.out_of_turn;
}

// A client that does not read its answers loses the connection (TCP) or the answer (RTU).
void Exchange::transmit(Link& link, const Bytes& frame) {
  if (frame.empty()) return;
  if (link.id == kRtu) {
    [[maybe_unused]] const ssize_t written = ::write(terminal_.master.get(), frame.data(), frame.size());
    return;
  }
  const ssize_t sent = ::send(link.connection.get(), frame.data(), frame.size(), MSG_NOSIGNAL);
  if (sent != static_cast<ssize_t>(frame.size())) link.connection.close();
}

void Exchange::run_due() {
  while (!pending_.empty()) {
    const auto next = std::min_element(pending_.begin(), pending_.end(),
                                       [](const Pending& a, const Pending& b) { return a.due_ns() < b.due_ns(); });
    if (next->due_ns() > monotonic_ns()) return;
    if (!next->sampled) {
      next->frame = responder_.answer(next->request, next->fate, next->t_s, next->link == kRtu);
      next->sampled = true;
      continue;
    }
    const Pending done = std::move(*next);
    pending_.erase(next);
    if (Link* link = find(done.link)) {
      transmit(*link, done.frame);
      if (!done.fate.out_of_turn) {
        link->busy = false;
        process(*link);
      }
    }
  }
}

}  // namespace rigsim
