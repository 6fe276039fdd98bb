#include "daemon/handon/uff.hpp"

#include <algorithm>
#include <vector>

#include "config/units.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/handon/printf_text.hpp"
#include "daemon/handon/resampler.hpp"
#include "daemon/handon/uff_plan.hpp"
#include "daemon/handon/uff_text.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kBufferBytes = 32U << 20U;  // bytes, of all channels together
constexpr double kPlanning = 0.1;                 // part of the time that the first pass takes

double seconds(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

// The texts and numbers of one dataset, without the error, which is known only after reading the channel.
UffFunction describe(const Selection& selection, std::size_t index, const EvenChannel& even, std::size_t stretch,
                     const Resampler::Check& check, const UffOptions& options) {
  const Rig& rig = selection.rig();
  const Channel& channel = rig.channels[index];
  const record::RunHeader& run = selection.header();
  const std::string unit =
      channel.measures == Quantity::auxiliary ? channel.unit : config::si_unit(channel.measures, rig.motion);
  UffFunction f;
  f.description = channel.name + ": " + measurand_text(channel) + (unit.empty() ? "" : ", " + unit);
  f.run = "run " + std::to_string(run.run) + (run.label.empty() ? "" : " " + run.label) + "; rig " + rig.name;
  f.date = uff_date(run.start_utc);
  const double rate_hz = 1e9 / even.interval_ns;
  f.method = format("resampled from %.4g Hz, band-limited to %.4g Hz, stretch %zu of %zu", rate_hz,
                    Resampler::kBand * rate_hz, stretch + 1, even.stretches.size());
  f.error = check.count == 0
                ? "error not known: too few readings"
                : format("error, noise included: rms %.2g, at most %.2g %s seen in %llu readings", check.rms(),
                         check.largest, unit.c_str(), static_cast<unsigned long long>(check.count));
  f.channel = &channel;
  f.motion = rig.motion;
  f.node_of_ground = rig.mass_count() + 1;
  f.number = static_cast<int>(index) + 1;
  f.stretch = static_cast<int>(stretch) + 1;
  f.count = even.stretches[stretch].count;
  f.start_s = seconds(even.stretches[stretch].first_ns - selection.zero_ns());
  f.step_s = seconds(even.step_ns);
  f.binary = options.binary;
  return f;
}

// Writes one channel's values at their planned places.
class ChannelValues {
 public:
  ChannelValues(const Channel& channel, const EvenChannel& even, std::vector<std::int64_t> places, std::size_t buffer,
                bool binary)
      : channel_(channel),
        even_(even),
        places_(std::move(places)),
        resampler_(std::max(1.0, even.interval_ns), std::max<std::int64_t>(1, even.step_ns)),
        buffer_(buffer),
        binary_(binary) {}

  void take(SharedInstants& shared, const Record& record, OutputFile& file) {
    if (even_.interval_ns <= 0.0) return;
    if (gaps_.begins(record.t_ns, even_.interval_ns)) begin(record.t_ns, file);
    if (!inside_) return;
    resampler_.push(shared, record.t_ns, in_si(channel_, record.value), [&](std::int64_t, double y) {
      const std::int64_t count = even_.stretches[stretch_].count;
      if (index_ == count) return;
      uff_value(text_, y, index_++, count, binary_);
      if (text_.size() >= buffer_) flush(file);
    });
  }
  void flush(OutputFile& file) {
    if (!text_.empty()) file.write_at(place_, text_);
    place_ += static_cast<std::int64_t>(text_.size());
    text_.clear();
  }
  [[nodiscard]] const Resampler::Check& check() const { return resampler_.check(); }

 private:
  void begin(std::int64_t t_ns, OutputFile& file) {
    flush(file);
    inside_ = next_ < even_.stretches.size() && even_.stretches[next_].begin_ns == t_ns;
    if (!inside_) return;
    stretch_ = next_++;
    index_ = 0;
    place_ = places_[stretch_];
    resampler_.begin(even_.stretches[stretch_].first_ns);
  }

  const Channel& channel_;
  const EvenChannel& even_;
  std::vector<std::int64_t> places_;  // of each stretch's values in the file
  Resampler resampler_;
  GapFinder gaps_;
  std::string text_;  // values not written yet
  std::size_t buffer_, next_ = 0, stretch_ = 0;
  std::int64_t index_ = 0, place_ = 0;
  bool inside_ = false, binary_;
};

std::string front(const Selection& selection, const Provenance& provenance) {
  return uff_header({"dwell run " + selection.header().id, "head " + head_text(provenance), provenance.program,
                     selection.header().start_utc, provenance.made_utc}) +
         uff_units();
}

// First all values, then the texts around them: these hold the errors seen while resampling.
Result<UffDone> write(Selection& selection, const UffOptions& options, const std::vector<EvenChannel>& plan,
                      std::int64_t place, OutputFile& file, const Progress& progress) {
  const std::vector<Channel>& channels = selection.rig().channels;
  const std::size_t buffer =
      std::clamp<std::size_t>(kBufferBytes / std::max<std::size_t>(1, plan.size()), 256, 1U << 18U);
  std::vector<ChannelValues> values;
  std::vector<std::vector<std::int64_t>> begins(plan.size());  // of each dataset
  for (std::size_t i = 0; i < plan.size(); ++i) {
    std::vector<std::int64_t> places;
    for (std::size_t k = 0; k < plan[i].stretches.size(); ++k) {
      begins[i].push_back(place);
      place += static_cast<std::int64_t>(uff_function(describe(selection, i, plan[i], k, {}, options)).size());
      places.push_back(place);
      place += uff_values_size(plan[i].stretches[k].count, options.binary) + static_cast<std::int64_t>(kUffMark.size());
    }
    values.emplace_back(channels[i], plan[i], std::move(places), buffer, options.binary);
  }
  UffDone done;
  SharedInstants shared;
  const auto take = [&](const Record& record) {
    values[record.channel].take(shared, record, file);
    ++done.samples;
    return true;
  };
  if (auto read = selection.samples(take, progress); !read) return tl::make_unexpected(read.error());
  for (std::size_t i = 0; i < plan.size(); ++i) {
    values[i].flush(file);
    done.left_out += plan[i].left_out;
    for (std::size_t k = 0; k < plan[i].stretches.size(); ++k) {
      const std::string text = uff_function(describe(selection, i, plan[i], k, values[i].check(), options));
      file.write_at(begins[i][k], text);
      file.write_at(begins[i][k] + static_cast<std::int64_t>(text.size()) +
                        uff_values_size(plan[i].stretches[k].count, options.binary),
                    kUffMark);
      done.values += static_cast<std::uint64_t>(plan[i].stretches[k].count);
      ++done.datasets;
    }
  }
  return done;
}

}  // namespace

Result<UffDone> export_uff(Selection& selection, const Provenance& provenance, const UffOptions& options,
                           const Target& target, const Progress& progress) {
  const auto part = [&progress](double from, double to) -> Progress {
    if (!progress) return {};
    return [=](double done) { progress(from + (to - from) * done); };
  };
  auto file = OutputFile::create(target);
  if (!file) return tl::make_unexpected(file.error());
  const auto plan = plan_even(selection, part(0.0, kPlanning));
  if (!plan) return tl::make_unexpected(plan.error());
  const std::string text = front(selection, provenance);
  file->write_at(0, text);
  auto done = write(selection, options, *plan, static_cast<std::int64_t>(text.size()), *file, part(kPlanning, 1.0));
  if (!done) return done;
  if (auto kept = file->keep(); !kept) return tl::make_unexpected(kept.error());
  return done;
}

}  // namespace dwell::handon
