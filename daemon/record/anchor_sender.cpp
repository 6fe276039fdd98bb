#include "daemon/record/anchor_sender.hpp"

#include <utility>

namespace dwell::record {

AnchorSender::AnchorSender(AnchorTarget target, RunFolder& folder, Tell tell)
    : target_(std::move(target)), folder_(folder), tell_(std::move(tell)) {}

void AnchorSender::turn(const ClockPair& now, const std::vector<EndedRunFile>& ended, bool run_changed) {
  if (!run_changed && now.raw_ns < next_ns_) return;
  const double minutes = target_.minutes > 0.0 ? target_.minutes : kAnchorMinutes;
  next_ns_ = now.raw_ns + static_cast<std::int64_t>(minutes * 60e9);
  for (const EndedRunFile& run : ended) ended_heads_.add(run.head);
  std::string lines;
  const auto add = [&](Anchor head) {
    head.utc = iso_utc(now.utc_ns);
    const std::string line = to_line(head);
    if (std::exchange(told_[head.origin], head.head) != head.head)
      tell_({Notice::Grade::info, "anchor: " + line, 0, hex(head.head)});
    lines += (lines.empty() ? "" : "\n") + line;
  };
  for (const Anchor& head : ended_heads_.all()) add(head);
  for (const Anchor& head : folder_.heads())
    if (std::exchange(sent_[head.origin], head.head) != head.head) add(head);
  if (sent_.size() > kOriginsKnown) sent_.clear();
  if (told_.size() > kOriginsKnown) told_.clear();
  deliver(now, std::move(lines));
}

void AnchorSender::deliver(const ClockPair& now, std::string lines) {
  const std::uint64_t added = ended_heads_.added();
  if (target_.file.empty() && target_.command.empty()) {
    ended_heads_.arrived(added);  // the log has them
    return;
  }
  if (lines.empty()) return;
  const bool posted =
      jobs_.post([target = target_, lines = std::move(lines), added, delivered = delivered_](const auto&) {
        const auto done = deliver_anchor(target, lines);
        delivered->put({done ? std::string() : std::string(done.error()), added});
      });
  if (posted)
    under_way_.push_back(now.raw_ns);
  else
    trouble_is("the anchors before have not arrived yet");
}

void AnchorSender::take_outcomes(const ClockPair& now) {
  for (Delivered& delivered : delivered_->take()) {
    under_way_.pop_front();
    if (!under_way_.empty()) under_way_.front() = now.raw_ns;  // only now does it begin
    if (delivered.trouble.empty()) ended_heads_.arrived(delivered.ended_heads);
    trouble_is(std::move(delivered.trouble));
  }
  if (!under_way_.empty() && now.raw_ns - under_way_.front() > kLate_ns && trouble_.empty())
    trouble_is("not delivered within " + std::to_string(kLate_ns / 1'000'000'000) + " s");
}

void AnchorSender::settle(const ClockPair& now, std::chrono::milliseconds limit) {
  const bool settled = wait(limit);
  take_outcomes(now);
  if (!settled) trouble_is("not delivered before the service ended");
}

void AnchorSender::trouble_is(std::string trouble) {
  if (!trouble.empty() && trouble_.empty()) tell_({Notice::Grade::warning, "anchor: " + trouble, 0, {}});
  if (!trouble.empty()) sent_.clear();  // all heads are sent again when the next anchor is due
  trouble_ = std::move(trouble);
}

}  // namespace dwell::record
