#include "daemon/gpio/panel.hpp"

#include <algorithm>
#include <utility>

namespace dwell::gpio {
namespace {

constexpr std::size_t kBatch = 16;
constexpr int kBatches = 8;  // per turn: a line that babbles must not keep the others waiting

bool is_input(Function function) { return function == Function::interlock || function == Function::sync; }

std::int64_t debounce_ns(const config::GpioLine& line) { return static_cast<std::int64_t>(line.debounce_s * 1e9); }

std::string name_of(Function function) { return kFunctionNames[static_cast<std::size_t>(function)]; }

}  // namespace

Panel::Panel(const config::GpioSettings& settings, LineSource& source, Link& link, Log& log)
    : settings_(settings), source_(source), link_(link), log_(log) {
  const std::optional<config::GpioLine>* const lines[kFunctions] = {&settings_.interlock, &settings_.sync,
                                                                    &settings_.ready, &settings_.fault};
  for (std::size_t i = 0; i < kFunctions; ++i) {
    held_[i].line = *lines[i] ? &**lines[i] : nullptr;
    status_[i].configured = held_[i].line != nullptr;
  }
  link_.tell(status_);
}

Panel::~Panel() {
  for (Held& lamp : held_)
    if (lamp.output) [[maybe_unused]]
      const auto told = lamp.output->set(false);
}

bool Panel::has_inputs() const noexcept { return settings_.interlock || settings_.sync; }

std::array<pollfd, 2> Panel::waited_for() const noexcept {
  std::array<pollfd, 2> waited{pollfd{-1, POLLIN, 0}, pollfd{-1, POLLIN, 0}};
  for (std::size_t i = 0; i < waited.size(); ++i)
    if (held_[i].input.line) waited[i].fd = held_[i].input.line->descriptor();
  return waited;
}

void Panel::turn(const ClockPair& now) {
  clocks_.add(now);
  if (previous_raw_ns_ == INT64_MIN) previous_raw_ns_ = now.raw_ns;
  for (const Function function : {Function::interlock, Function::sync, Function::ready, Function::fault})
    if (held(function).line != nullptr && !held(function).open() && now.monotonic_ns >= held(function).retry_ns)
      open(function);
  for (const Function function : {Function::interlock, Function::sync}) {
    if (input(function).line) take(function);
    if (input(function).line && now.monotonic_ns >= input(function).probe_ns) probe(function);
    if (function == Function::interlock && input(function).untold && link_.has_room())
      tell_edge(function, now.monotonic_ns, status(function).level.value_or(false));
  }
  light();
  previous_raw_ns_ = now.raw_ns;
  if (has_inputs()) link_.seen_to(now.raw_ns - kLateness_ns);
  link_.tell(status_);
}

void Panel::open(Function function) {
  Held& own = held(function);
  const std::int64_t now_ns = clocks_.now().monotonic_ns;
  if (!is_input(function)) {
    auto output = source_.output(*own.line, false);
    if (!output) return fail(function, output.error());
    own.output = std::move(*output);
    status(function).level = false;
  } else {
    // A pulse too short to be read after the interrupt has an edge all the same: without bounces to tell from it, the
    // rising ones are all that is asked for.
    const bool rising = function == Function::sync && own.line->debounce_s == 0.0;
    auto opened = source_.input(*own.line, rising ? Edges::rising : Edges::both);
    if (!opened) return fail(function, opened.error());
    // What came before the level is read is in it.
    std::array<LineEdge, kBatch> before;
    while ((*opened)->take(before.data(), before.size()).value_or(0) == before.size()) {
    }
    const auto level = (*opened)->level();
    if (!level) return fail(function, level.error());
    own.input = {};
    own.input.line = std::move(*opened);
    if (!rising) own.input.filter.emplace(*level, debounce_ns(*own.line));
    own.input.probe_ns = now_ns + kProbe_ns;
    if (function == Function::interlock) tell_edge(function, now_ns, *level);
  }
  LineStatus& told = status(function);
  if (!told.reason.empty()) log_.info("gpio: " + name_of(function) + " works again");
  told.works = true;
  told.reason.clear();
}

void Panel::fail(Function function, const std::string& reason) {
  Held& own = held(function);
  LineStatus& told = status(function);
  if (told.reason != reason)
    log_.error("gpio: " + name_of(function) + " does not work: " + reason, {{"DWELL_GPIO", name_of(function)}});
  const bool permitted = function == Function::interlock && told.level.value_or(false);
  own.input.line.reset();
  own.output.reset();
  own.retry_ns = clocks_.now().monotonic_ns + kRetry_ns;
  if (permitted) tell_edge(function, clocks_.now().monotonic_ns, false);
  told.works = false;
  told.reason = reason;
  told.level.reset();
}

void Panel::take(Function function) {
  Input& own = input(function);
  const auto tell = [&](std::int64_t t_ns, bool level) { tell_edge(function, t_ns, level); };
  std::array<LineEdge, kBatch> edges;
  for (int i = 0; i < kBatches; ++i) {
    const auto taken = own.line->take(edges.data(), edges.size());
    if (!taken) {
      fail(function, taken.error());
      return;
    }
    const std::size_t count = *taken;
    for (std::size_t k = 0; k < count; ++k) {
      const LineEdge& edge = edges[k];
      if (edge.gap) count_loss(function);
      if (own.filter) {
        own.filter->edge(edge, tell);
      } else if (edge.level) {
        tell(edge.t_ns, true);
      }
    }
    if (count < edges.size()) break;
  }
  if (!own.filter) return;
  own.filter->due(clocks_.now().monotonic_ns, tell);
  status(function).bounces = own.filter->bounces();
}

// The level itself: a chip that has gone says so, and an edge that was lost does not stay unknown.
void Panel::probe(Function function) {
  Input& own = input(function);
  const std::int64_t now_ns = clocks_.now().monotonic_ns;
  own.probe_ns = now_ns + kProbe_ns;
  const auto level = own.line->level();
  if (!level) return fail(function, level.error());
  if (function != Function::interlock || *level == own.filter->line()) return;
  take(function);  // it may just have changed
  if (!own.line || *level == own.filter->line()) return;
  count_loss(function);
  own.filter->edge({now_ns, *level, false}, [&](std::int64_t t_ns, bool to) { tell_edge(function, t_ns, to); });
}

void Panel::tell_edge(Function function, std::int64_t monotonic_ns, bool level) {
  LineStatus& told = status(function);
  const bool changed = told.level != level;
  if (function == Function::interlock || input(function).filter) told.level = level;
  if (function == Function::interlock && changed) {
    if (const auto changes = interlock_lines_[level ? 1 : 0].admit(clocks_.now().raw_ns)) {
      std::string line = level ? "gpio: the interlock permits the shaker to run" : "gpio: the interlock is open";
      if (*changes > 1) line += " (" + std::to_string(*changes) + " times since the last such line)";
      log_.write(level ? Level::info : Level::warning, line, {{"DWELL_GPIO", "interlock"}});
    }
  }
  if (function == Function::sync && !level) return;
  Record record;
  record.kind = Kind::edge;
  record.channel = static_cast<std::uint16_t>(function == Function::sync ? Line::sync : Line::interlock);
  record.value = level ? 1.0 : 0.0;
  record.t_ns = clocks_.raw_ns(monotonic_ns);
  record.t_half_ns = static_cast<std::uint32_t>(clocks_.now().half_ns);
  const std::int64_t now_ns = clocks_.now().raw_ns;
  if (record.t_ns < previous_raw_ns_ - kLateness_ns || record.t_ns > now_ns) {
    record.t_ns = now_ns;
    record.t_half_ns = static_cast<std::uint32_t>(std::min<std::int64_t>((now_ns - previous_raw_ns_) / 2, UINT32_MAX));
    record.flags |= kStampReplaced;
  }
  Input& own = input(function);
  if (std::exchange(own.gap, false)) record.flags |= kGap;
  ++told.edges;
  own.untold = !link_.push(record);
  if (own.untold) count_loss(function);
}

void Panel::count_loss(Function function) {
  ++status(function).lost;
  input(function).gap = true;
}

void Panel::light() {
  const std::int64_t now_ns = clocks_.now().raw_ns;
  const LampLevels levels = lamp_levels(link_.order(), now_ns - link_.ordered_ns(), now_ns);
  const bool anew = now_ns >= lamps_anew_ns_;
  if (anew) lamps_anew_ns_ = now_ns + kProbe_ns;
  for (const auto& [function, level] :
       {std::pair{Function::ready, levels.ready}, std::pair{Function::fault, levels.fault}}) {
    if (!held(function).output || (status(function).level == level && !anew)) continue;
    if (const auto set = held(function).output->set(level); !set) {
      fail(function, set.error());
    } else {
      status(function).level = level;
    }
  }
}

std::vector<std::string> lamps_off(const config::GpioSettings& settings, LineSource& source) {
  std::vector<std::string> faults;
  for (const auto* line : {&settings.ready, &settings.fault}) {
    if (!*line) continue;
    if (const auto output = source.output(**line, false); !output) faults.push_back(output.error());
  }
  return faults;
}

}  // namespace dwell::gpio
