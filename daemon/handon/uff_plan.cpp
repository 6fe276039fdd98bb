#include "daemon/handon/uff_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "daemon/handon/resampler.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kFirst = 256;       // readings that tell the usual interval
constexpr std::size_t kStretches = 1000;  // of a channel at most: a tool shows each as a signal of its own
constexpr int kHalf = Resampler::kReadings / 2;

double median_interval_ns(const std::vector<std::int64_t>& t_ns) {
  std::vector<std::int64_t> intervals;
  for (std::size_t i = 1; i < t_ns.size(); ++i) intervals.push_back(t_ns[i] - t_ns[i - 1]);
  if (intervals.empty()) return 0.0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return std::max(1.0, static_cast<double>(*middle));
}

// Counts the readings of one stretch, to find the even instants that have enough readings on both sides.
struct OpenRun {
  std::int64_t begin_ns = 0, earliest_ns = 0;  // earliest: the 16th reading
  std::uint64_t readings = 0;
  std::array<std::int64_t, kHalf> last_ns{};

  void take(std::int64_t t_ns) {
    if (readings == 0) begin_ns = t_ns;
    last_ns[readings % kHalf] = t_ns;
    if (++readings == kHalf) earliest_ns = t_ns;
  }
  [[nodiscard]] bool enough() const { return readings >= Resampler::kFewest; }
  [[nodiscard]] std::int64_t before_ns() const { return last_ns[readings % kHalf]; }  // 16th from the end
};

// Survey of one channel.
class ChannelSurvey {
 public:
  void take(std::int64_t t_ns) {
    ++readings_;
    if (interval_ns_ > 0.0) {
      sort(t_ns);
      return;
    }
    first_.push_back(t_ns);
    if (first_.size() == kFirst) start();
  }
  void finish() {
    if (interval_ns_ <= 0.0) start();
    close();
  }
  [[nodiscard]] bool irregular() const { return done_.size() > kStretches; }
  [[nodiscard]] double interval_ns() const { return interval_ns_; }

  // The plan of the channel, for this step.
  [[nodiscard]] EvenChannel even(std::int64_t zero_ns, std::int64_t step_ns) const {
    EvenChannel channel{interval_ns_, step_ns, {}, readings_, left_out_};
    for (const Done& stretch : done_) {
      const std::int64_t first_ns = zero_ns + even_start_ns(stretch.earliest_ns - zero_ns, step_ns);
      const std::int64_t count = stretch.before_ns > first_ns ? (stretch.before_ns - 1 - first_ns) / step_ns + 1 : 0;
      if (count > 0) {
        channel.stretches.push_back({stretch.begin_ns, first_ns, count});
      } else {
        channel.left_out += stretch.readings;
      }
    }
    return channel;
  }

 private:
  struct Done {
    std::int64_t begin_ns, earliest_ns, before_ns;
    std::uint64_t readings;
  };

  void start() {
    interval_ns_ = median_interval_ns(first_);
    if (interval_ns_ > 0.0)
      for (const std::int64_t t_ns : first_) sort(t_ns);
    first_ = {};
  }
  void sort(std::int64_t t_ns) {
    if (gaps_.begins(t_ns, interval_ns_)) close();
    open_.take(t_ns);
  }
  void close() {
    if (open_.enough() && !irregular()) {
      done_.push_back({open_.begin_ns, open_.earliest_ns, open_.before_ns(), open_.readings});
    } else {
      left_out_ += open_.readings;
    }
    open_ = {};
  }

  std::vector<std::int64_t> first_;
  double interval_ns_ = 0.0;
  GapFinder gaps_;
  OpenRun open_;
  std::vector<Done> done_;
  std::uint64_t readings_ = 0, left_out_ = 0;
};

// Whether six significant digits hold this time, in seconds, exactly.
bool six_digits(std::int64_t t_ns) {
  while (t_ns != 0 && t_ns % 10 == 0) t_ns /= 10;
  return std::llabs(t_ns) < 1'000'000;
}

}  // namespace

bool GapFinder::begins(std::int64_t t_ns, double interval_ns) noexcept {
  const bool begins = last_ns_ == INT64_MIN || static_cast<double>(t_ns - last_ns_) > Resampler::kGap * interval_ns;
  last_ns_ = t_ns;
  return begins;
}

std::int64_t even_step_ns(double interval_ns) {
  constexpr std::array<std::int64_t, 6> mantissas{10, 20, 25, 40, 50, 80};
  std::int64_t step_ns = 10;
  for (std::int64_t decade = 1; decade <= 100'000'000'000; decade *= 10)
    for (const std::int64_t mantissa : mantissas)
      if (static_cast<double>(mantissa * decade) <= 1.02 * interval_ns) step_ns = mantissa * decade;
  return step_ns;
}

std::int64_t even_start_ns(std::int64_t t_ns, std::int64_t step_ns) {
  // Tries multiples ten times coarser: they need fewer digits.
  for (std::int64_t coarse_ns = step_ns;; coarse_ns *= 10) {
    const std::int64_t start_ns = (t_ns / coarse_ns + (t_ns % coarse_ns > 0 ? 1 : 0)) * coarse_ns;
    if (six_digits(start_ns) || coarse_ns > std::numeric_limits<std::int64_t>::max() / 100) return start_ns;
  }
}

Result<std::vector<EvenChannel>> plan_even(Selection& selection, const Progress& progress) {
  const std::vector<Channel>& channels = selection.rig().channels;
  std::vector<ChannelSurvey> surveys(channels.size());
  const auto take = [&surveys](const Record& record) {
    surveys[record.channel].take(record.t_ns);
    return true;
  };
  if (auto done = selection.samples(take, progress); !done) return tl::make_unexpected(done.error());
  double fastest_ns = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    surveys[i].finish();
    if (surveys[i].irregular())
      return tl::make_unexpected(selection.path() + ": the readings of channel " + channels[i].name +
                                 " have more than " + std::to_string(kStretches) +
                                 " gaps; a universal file holds even instants: expected fewer, or csv or hdf5");
    if (channels[i].measures != Quantity::auxiliary && surveys[i].interval_ns() > 0.0)
      fastest_ns = std::min(fastest_ns, surveys[i].interval_ns());
  }
  std::vector<EvenChannel> even;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const bool own = channels[i].measures == Quantity::auxiliary;
    const double interval_ns = own ? surveys[i].interval_ns() : fastest_ns;
    const bool told = surveys[i].interval_ns() > 0.0;
    even.push_back(surveys[i].even(selection.zero_ns(), told ? even_step_ns(interval_ns) : 1));
  }
  return even;
}

}  // namespace dwell::handon
