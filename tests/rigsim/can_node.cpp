#include "tests/rigsim/can_node.hpp"

#include <algorithm>

#include "drivers/dwell_driver.hpp"
#include "tests/rigsim/can_frames.hpp"

namespace rigsim {
namespace {

using dwell::driver::monotonic_ns;

constexpr canid_t kHighest = 0;  // of all priorities
constexpr int kReadings = 4;
constexpr std::int64_t kReadWithin_ns = 500'000;
constexpr double kFarBehind_ns = 1e9;

}  // namespace

CanNodes::CanNodes(const Options& options, Responder& responder, const std::function<std::int64_t()>& clock,
                   const SimulatedClock& time)
    : interface_(options.can),
      rate_hz_(options.can_rate_hz),
      drift_ppm_(options.clock_drift_ppm),
      responder_(responder),
      clock_(clock),
      time_(time),
      counters_(responder.device.channels().size()),
      values_(responder.device.channels().size()),
      trouble_(kHighest, responder.device.faults, options.seed),
      random_(options.seed ^ 0xCA11CA11ULL) {}

Result<void> CanNodes::open() {
  if (interface_.empty()) return {};
  auto wire = CanWire::open(interface_);
  if (!wire) return tl::make_unexpected(wire.error());
  wire_ = std::move(*wire);
  const std::int64_t now_ns = monotonic_ns();
  next_ns_.clear();
  for (std::size_t i = 0; i < values_.size(); ++i)
    next_ns_.push_back(
        now_ns + static_cast<std::int64_t>(period_ns() * static_cast<double>(i) / static_cast<double>(values_.size())));
  return {};
}

double CanNodes::period_ns() const noexcept { return 1e9 / (rate_hz_ * (1.0 + 1e-6 * drift_ppm_)); }

bool CanNodes::happens(double probability) {
  return probability > 0.0 && std::bernoulli_distribution(probability)(random_);
}

void CanNodes::watch(std::vector<pollfd>& polled) const {
  if (wire_) wire_->watch(polled);
}

std::optional<std::int64_t> CanNodes::next_due_ns() const {
  if (!active()) return std::nullopt;
  std::int64_t due_ns = *std::min_element(next_ns_.begin(), next_ns_.end());
  for (const Pending& each : pending_) due_ns = std::min(due_ns, each.due_ns);
  if (const auto babble_ns = trouble_.due_ns()) due_ns = std::min(due_ns, *babble_ns);
  return due_ns;
}

void CanNodes::serve(std::int64_t now_ns) {
  if (!wire_) return;
  received_.clear();
  wire_->receive(received_);
  if (!active()) return;
  refused_ += trouble_.babble(*wire_, now_ns);
  for (std::size_t i = 0; i < next_ns_.size(); ++i) {
    if (next_ns_[i] > now_ns) continue;
    sample(i, now_ns);
    next_ns_[i] += static_cast<std::int64_t>(period_ns());
    if (static_cast<double>(now_ns - next_ns_[i]) > kFarBehind_ns) next_ns_[i] = now_ns;
  }
  for (std::size_t i = 0; i < pending_.size();) {
    if (pending_[i].due_ns > now_ns) {
      ++i;
      continue;
    }
    send(pending_[i].frame);
    pending_.erase(pending_.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

void CanNodes::sample(std::size_t channel, std::int64_t now_ns) {
  const Faults& faults = responder_.device.faults;
  ++counters_[channel];
  if (happens(faults.dropout)) silent_until_ns_ = now_ns + static_cast<std::int64_t>(faults.dropout_length_s * 1e9);
  if (now_ns < silent_until_ns_ || happens(faults.missing)) {
    ++lost_;
    return;
  }
  // Sampled anew where something came between: a frame's instant is that of its reading, as a real node's is.
  for (int i = 0; i < kReadings; ++i) {
    const std::int64_t t_ns = clock_();
    responder_.device.read(time_.at(t_ns), values_);
    if (clock_() - t_ns <= kReadWithin_ns) break;
  }
  WireFrame frame = can_frame(channel, responder_.device.is_force(channel), values_[channel], counters_[channel]);
  if (happens(faults.short_frame)) frame.can.len /= 2;
  double delay_s = faults.latency_s;
  if (faults.latency_jitter_s > 0.0)
    delay_s += std::uniform_real_distribution<double>(0.0, faults.latency_jitter_s)(random_);
  if (happens(faults.late)) {
    delay_s += faults.late_by_s;
    ++late_;
  }
  if (delay_s <= 0.0)
    send(frame);
  else if (pending_.size() < kMostFrames)
    pending_.push_back({now_ns + static_cast<std::int64_t>(delay_s * 1e9), frame});
}

void CanNodes::send(const WireFrame& frame) {
  refused_ += wire_->send(frame);
  ++sent_;
}

std::optional<std::string> CanNodes::command(const std::vector<std::string>& words) {
  if (interface_.empty()) return std::nullopt;
  if (auto answer = trouble_.command(words, wire_ ? &*wire_ : nullptr)) {
    if (trouble_.off()) pending_.clear();
    return answer;
  }
  if (words[0] == "can" && words.size() == 2 && (words[1] == "on" || words[1] == "off")) {
    if (words[1] == "off") wire_.reset();
    if (words[1] == "on" && !wire_) {
      if (auto opened = open(); !opened) return "error: " + opened.error();
    }
    return "ok";
  }
  return std::nullopt;
}

std::string CanNodes::status() const {
  return "\"frames\":" + std::to_string(sent_) + ",\"frames_lost\":" + std::to_string(lost_) +
         ",\"frames_late\":" + std::to_string(late_) + ",\"frames_refused\":" + std::to_string(refused_) +
         ",\"bus_off\":" + (trouble_.off() ? "true" : "false");
}

}  // namespace rigsim
