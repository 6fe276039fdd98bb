#include "daemon/ctl/watch_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <iterator>
#include <utility>

#include "daemon/ctl/deviation.hpp"
#include "daemon/ctl/pager.hpp"
#include "daemon/report/limit_text.hpp"
#include "daemon/report/model_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

void add(std::vector<TextLine>& lines, const std::string& text, std::size_t columns, Style style) {
  for (std::string& line : wrapped(printable(text), columns, 2)) lines.push_back({std::move(line), style});
}

// `right` at the right edge; both as long as they fit, else the left one is cut: it is only a name.
std::string spread(const std::string& left, const std::string& right, std::size_t columns) {
  const std::size_t taken = width(right) + 2;
  const std::size_t room = columns > taken ? columns - taken : 0;
  return pad_right(clipped(left, room), room) + "  " + right;
}

// Whether the numbers are of now: renewed, and of a dwell that goes on.
bool current(const WatchState& state, double now_s) { return !state.old(now_s) && !state.ended(); }

// How coefficients, and the words beside them, are shown.
Style style_of(const WatchState& state, double now_s) {
  return state.old(now_s) ? Style::old : state.ended() ? Style::past : Style::plain;
}

// How old the numbers are. Those of a dwell that has ended are as old as its end: the service goes on telling them.
std::string age_of(const WatchState& state, double now_s) {
  const double ended_s = state.ended_ago_s(now_s);
  if (std::isfinite(ended_s)) return age_text(ended_s);
  // In a fault, the numbers in view are those of the last dwell, so the age is theirs.
  if (state.dwell() && state.dwell()->dwell.state == State::fault) {
    const double last_s = state.last_ago_s(now_s);
    return std::isfinite(last_s) ? age_text(std::max(last_s, state.age_s(now_s))) : kNoNumber;
  }
  return state.ended() ? "ended" : age_text(state.age_s(now_s));
}

TextOptions options_of(const WatchState& state, const Truth* truth, std::size_t columns, double now_s) {
  TextOptions options;
  options.columns = columns;
  options.truth = truth;
  options.frequency = options.legend = false;
  if (!current(state, now_s)) options.age = age_of(state, now_s);
  options.result = state.ended() && !state.old(now_s);
  // An old list tells nothing of now.
  if (!state.dwell() || state.channels_age_s(now_s) > WatchState::kListOld_s) return options;
  for (const ChannelLabel& label : state.dwell()->channels) {
    ChannelNote& note = options.channels.emplace_back();
    const auto channel = state.channel(label.name, now_s);
    if (!channel || channel->status.empty()) continue;
    note.status = channel->status;
    if (channel->age_s > kOldAfter_s) note.age = age_text(channel->age_s);
  }
  return options;
}

// An instant of this computer's time zone; with the date where that is not today's.
std::string instant_text(std::int64_t utc_ns, std::int64_t now_utc_ns) {
  const auto local = [](std::int64_t ns) {
    const auto seconds = static_cast<std::time_t>(ns / 1'000'000'000);
    std::tm time{};
    localtime_r(&seconds, &time);
    return time;
  };
  const std::tm at = local(utc_ns), now = local(now_utc_ns);
  const bool today = at.tm_yday == now.tm_yday && at.tm_year == now.tm_year;
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), today ? "%H:%M:%S" : "%Y-%m-%d %H:%M:%S", &at);
  return text.data();
}

// What stands behind the state on the page: run, frequency, since when. What is not known is left out.
std::string facts_of(const WatchState& state, double now_s) {
  std::vector<std::string> facts{state.played() != Played::none ? "recording, not live" : "", state.run(),
                                 frequency_text(state.dwell()->dwell)};
  const auto since_ns = state.since_utc_ns(), now_ns = state.utc_ns(now_s);
  if (since_ns && now_ns)
    facts.push_back("since " + instant_text(*since_ns, *now_ns) + " (" +
                    age_text(1e-9 * static_cast<double>(*now_ns - *since_ns)) + ")");
  std::string text;
  for (const std::string& fact : facts)
    if (!fact.empty()) text += (text.empty() ? "" : " · ") + fact;
  return text;
}

// Why the numbers are old.
std::string why_old(const WatchState& state, double now_s) {
  switch (state.silence(now_s)) {
    case Silence::service:
      return "the service has said nothing for " + age_text(state.silent_s(now_s));
    case Silence::estimation:
      return "the service answers, but its estimation publishes nothing new";
    case Silence::data:
      return "the service answers, but no new data come";
  }
  return {};
}

// What an operator must know before reading any number. where: of the list of alarms, ", page 2" or nothing.
std::vector<TextLine> alarms(const WatchState& state, const Controls& controls, const std::string& where,
                             std::size_t columns, double now_s) {
  std::vector<TextLine> lines;
  if (controls.paused_s) {
    add(lines, "PAUSED for " + age_text(now_s - *controls.paused_s) + "; space goes on", columns, Style::alarm);
  }
  if (!state.trouble.empty()) add(lines, "NO CONNECTION: " + state.trouble, columns, Style::alarm);
  if (state.dwell() && state.played() == Played::to_its_end && state.trouble.empty()) {
    add(lines, "NOT OF NOW: the recording has been played to its end", columns, Style::plain);
  } else if (state.dwell() && state.old(now_s)) {
    const std::string why = controls.paused_s ? "paused" : why_old(state, now_s);
    add(lines, "OLD NUMBERS, from " + age_text(state.age_s(now_s)) + " ago: " + why, columns, Style::alarm);
  }
  if (state.ended()) {
    const double ago_s = state.ended_ago_s(now_s);
    const std::string ago = std::isfinite(ago_s) ? " " + age_text(ago_s) + " ago" : "";
    add(lines, "NOT OF NOW, ended" + ago + ": " + why_ended(state.dwell()->dwell), columns, Style::plain);
  }
  const auto heard = [](bool old) { return old ? std::string("when last heard: ") : std::string(); };
  std::string gpio = state.gpio();
  for (auto end = gpio.find('\n'); end != std::string::npos; end = gpio.find('\n')) {
    const bool well = gpio.compare(0, end, "interlock  closed") == 0;
    add(lines, heard(state.gpio_old(now_s)) + gpio.substr(0, end), columns, well ? Style::plain : Style::alarm);
    gpio.erase(0, end + 1);
  }
  if (state.alarms().unacknowledged > 0) {
    // The service lists alarms that last before those that are over. The latter must not look as if they lasted.
    const std::vector<ListedAlarm>& list = state.alarms().alarms;
    const auto over = static_cast<std::size_t>(
        std::count_if(list.begin(), list.end(), [](const ListedAlarm& a) { return a.state == kReturned; }));
    const std::size_t active = state.alarms().unacknowledged - std::min(over, state.alarms().unacknowledged);
    const std::size_t count = active > 0 ? active : over;
    std::string text = heard(state.alarms_old(now_s)) + std::to_string(count) + (count > 1 ? " alarms" : " alarm") +
                       " not acknowledged" + (active == 0 ? ", over" : "") + where;
    const std::string more = active > 0 && over > 0 ? "; " + std::to_string(over) + " more over" : "";
    // The first of them as far as the line goes; the list tells all.
    constexpr std::size_t kLeast = 12;
    const std::size_t taken = width(text) + width(more);
    if (!list.empty() && columns > taken + kLeast)
      text += ": " + clipped(printable(list.front().text), columns - taken - 2);
    add(lines, text + more, columns, active > 0 ? Style::alarm : Style::plain);
  }
  if (!controls.message.empty()) add(lines, controls.message, columns, Style::plain);
  return lines;
}

// Long doubts must not push the coefficients they concern off the first page: what is beyond half of it goes below
// them.
void make_room(std::vector<Section>& sections, std::size_t rows) {
  if (sections.size() < 2 || sections[0].name != kDoubts) return;
  const std::size_t most = std::max<std::size_t>(rows / 2, 2);
  std::vector<TextLine>& doubts = sections[0].body;
  if (doubts.size() <= most) return;
  Section more;
  more.head.push_back({"do not rely on these numbers, continued:", Style::alarm});
  more.body.assign(doubts.begin() + static_cast<std::ptrdiff_t>(most - 1), doubts.end());
  doubts.resize(most - 1);
  doubts.push_back({"… continued below the coefficients", Style::alarm});
  sections.insert(sections.begin() + 2, std::move(more));
}

// The end of the sections of this name; where there is none, the beginning of all.
std::vector<Section>::iterator behind(std::vector<Section>& sections, std::string_view name) {
  const auto last =
      std::find_if(sections.rbegin(), sections.rend(), [name](const Section& s) { return s.name == name; });
  return last == sections.rend() ? sections.begin() : last.base();
}

// While there is no dwell: the coefficients of the last one, as a result, with a legend of their own.
void put_last(std::vector<Section>& sections, const WatchState& state, std::size_t columns, double now_s) {
  const DwellView* const last = state.last();
  if (last == nullptr) return;
  const double ago_s = state.last_ago_s(now_s);
  const std::string ago = std::isfinite(ago_s) ? age_text(ago_s) : "not now";
  TextOptions options;
  options.columns = columns;
  options.age = ago;
  options.result = true;
  std::vector<Section> result;
  for (Section& section : dwell_sections(*last, options))
    if (section.name == kCoefficients || section.name == kLimits) result.push_back(std::move(section));
  if (result.empty()) return;
  const bool complete = last->dwell.state == State::complete;
  std::string title = "not of now · last dwell: " + std::to_string(last->dwell.index.value_or(0)) +
                      (std::isfinite(ago_s) ? (complete ? ", ended " : ", last seen ") + ago + " ago" : "") +
                      (complete ? std::string(": ") + to_string(last->dwell.ended_by) : "");
  for (const Doubt& doubt : last->dwell.doubts) title += "; " + doubt_text(doubt);
  if (last->model) title += "; model " + model_text(*last->model);
  std::vector<TextLine> head;
  add(head, title, columns, last->dwell.doubts.empty() ? Style::title : Style::alarm);
  result.front().head.insert(result.front().head.begin(), head.begin(), head.end());
  sections.insert(behind(sections, kDoubts), std::make_move_iterator(result.begin()),
                  std::make_move_iterator(result.end()));
}

// Behind the coefficients: how they moved over the hour, and against the dwell before, in the same columns.
void put_changes(std::vector<Section>& sections, const WatchState& state, std::size_t columns, double now_s) {
  Section changes = state.trend().section(*state.dwell(), now_s, columns);
  Section deviation = deviation_section(*state.dwell(), state.before_ago_s(now_s), columns);
  if (changes.body.empty()) {
    changes = std::move(deviation);
  } else if (!deviation.body.empty()) {
    // The columns' titles stand above the trend.
    changes.body.insert(changes.body.end(), deviation.head.begin(), deviation.head.end() - 1);
    changes.body.insert(changes.body.end(), deviation.body.begin(), deviation.body.end());
  }
  if (changes.body.empty()) return;
  if (!current(state, now_s))
    for (TextLine& line : changes.body) line.style = style_of(state, now_s);
  sections.insert(behind(sections, kCoefficients), std::move(changes));
}

// Below all that concerns the coefficients, as on the page; it may go overleaf alone.
void put_legend(std::vector<Section>& sections, const DwellView& view, std::size_t columns) {
  std::vector<TextLine> legend;
  for (const std::string& text : legend_of({&view.dwell})) add(legend, text, columns, Style::plain);
  for (const std::string_view name : {kLimits, kDeviation, kTrend, kCoefficients}) {
    const auto end = behind(sections, name);
    if (legend.empty() || end == sections.begin()) continue;
    Section& host = *std::prev(end);
    host.body.insert(host.body.end(), legend.begin(), legend.end());
    host.notes += legend.size();
    return;
  }
}

// The verdict on the model, as the page has it in its first line.
std::string verdict_of(const WatchState& state) {
  const auto& model = state.dwell()->model;
  if (!model) return {};
  const std::string why = state.why_unverified();
  return " · model " + model_brief(*model) + (why.empty() ? "" : ": " + why);
}

std::string where_of(std::size_t page, std::size_t pages) {
  return pages > 1 ? ", page " + std::to_string(page + 1) : "";
}

std::string count_of(std::size_t count, const char* what, std::size_t page, std::size_t pages) {
  if (count == 0) return {};
  std::string text = " · " + std::to_string(count) + " " + what + (count == 1 ? "" : "s");
  return text + where_of(page, pages);
}

// Without the line that the dwell has not settled: that is its state, not a warning.
std::size_t warnings_in(const DwellView& view) {
  const std::vector<Warning>& warnings = view.dwell.warnings;
  const auto count = std::count_if(warnings.begin(), warnings.end(),
                                   [](const Warning& warning) { return warning.kind != WarningKind::not_settled; });
  return static_cast<std::size_t>(count) + (contradicts(view) ? 1 : 0);
}

std::vector<TextLine> footer(const Controls& controls, std::size_t page, std::size_t pages, std::size_t columns) {
  std::vector<TextLine> lines;
  const std::string turned = "page " + std::to_string(page + 1) + " of " + std::to_string(pages);
  if (!controls.question.empty()) {
    add(lines, controls.question + " y n", columns, Style::alarm);
  } else if (!controls.keys) {
    add(lines, pages > 1 ? turned + "; Ctrl-C ends it" : "Ctrl-C ends it", columns, Style::hint);
  } else {
    std::string text = controls.paused_s ? "space go on" : "space pause";
    if (pages > 1) text += "  n b " + turned;
    if (controls.may_rearm) text += "  r rearm";
    add(lines, text + "  q quit", columns, Style::hint);
  }
  return lines;
}

// On which pages the header's doubts, warnings and alarms stand.
struct Places {
  std::size_t warnings = 0, alarms = 0, pages = 0;
};

std::vector<Section> sections_of(const WatchState& state, const Truth* truth, std::size_t columns, double now_s) {
  std::vector<Section> sections;
  if (state.dwell()) {
    sections = dwell_sections(*state.dwell(), options_of(state, truth, columns, now_s));
    put_last(sections, state, columns, now_s);
    put_changes(sections, state, columns, now_s);
    put_legend(sections, *state.dwell(), columns);
  }
  if (Section list = alarms_section(state.alarms(), columns); !list.body.empty()) sections.push_back(std::move(list));
  return sections;
}

// What is so, in words. A recording at its end looks like a rig whose transducers have gone.
std::string said(const WatchState& state, double now_s) {
  if (state.played() == Played::to_its_end) return "recording ended";
  return (state.old(now_s) ? "last seen: " : "") + headline(*state.dwell());
}

// The first line after the title: what is so, and whether it may be relied on.
TextLine state_line(const WatchState& state, const Places& places, double now_s) {
  if (!state.dwell()) return {"waiting for the service's first word", Style::plain};
  const Dwell& dwell = state.dwell()->dwell;
  const std::string text = said(state, now_s) + verdict_of(state) +
                           count_of(dwell.doubts.size(), "doubt", 0, places.pages) +
                           count_of(warnings_in(*state.dwell()), "warning", places.warnings, places.pages);
  // That a recording has ended is so, whatever it was of.
  const bool told = state.played() == Played::to_its_end && state.trouble.empty();
  const Style style = told                                         ? Style::plain
                      : !dwell.doubts.empty() && !state.old(now_s) ? Style::alarm
                                                                   : style_of(state, now_s);
  return {text, style};
}

std::vector<TextLine> header_of(const WatchState& state, const Controls& controls, const Places& places,
                                std::size_t columns, double now_s, const std::string& clock) {
  std::vector<TextLine> header;
  header.push_back(
      {spread(printable(state.name), "age " + age_of(state, now_s) + " · " + clock, columns), Style::title});
  const TextLine line = state_line(state, places, now_s);
  add(header, line.text, columns, line.style);
  if (const std::string facts = state.dwell() ? facts_of(state, now_s) : ""; !facts.empty())
    add(header, facts, columns, style_of(state, now_s));
  for (TextLine& alarm : alarms(state, controls, where_of(places.alarms, places.pages), columns, now_s))
    header.push_back(std::move(alarm));
  return header;
}

}  // namespace

Page draw(const WatchState& state, const Controls& controls, const Truth* truth, Size size, double now_s,
          const std::string& clock) {
  const std::size_t columns = std::max<std::size_t>(size.columns, 8);
  const std::vector<Section> sections = sections_of(state, truth, columns, now_s);

  // The header tells the pages of doubts and warnings, and its height decides on which pages they are: the second time
  // round its height is known.
  Page page;
  std::vector<TextLine> header;
  std::vector<TextLine> keys = footer(controls, 0, 2, columns);
  std::vector<TextLine> body;
  std::size_t header_rows = 3;
  for (int round = 0; round < 2; ++round) {
    const std::size_t around = header_rows + 1 + keys.size();
    const std::size_t rows = size.rows > around ? size.rows - around : 1;
    std::vector<Section> set = sections;
    make_room(set, rows);
    Pager pager(rows);
    Places places;
    for (const Section& section : set) {
      const std::size_t first = pager.add(section);
      if (section.name == kWarnings) places.warnings = first;
      if (section.name == kAlarms) places.alarms = first;
    }
    places.pages = page.pages = pager.pages().size();
    page.page = std::min(controls.page, page.pages - 1);
    body = pager.pages()[page.page];
    keys = footer(controls, page.page, page.pages, columns);
    header = header_of(state, controls, places, columns, now_s, clock);
    header_rows = header.size();
  }

  const std::size_t rows = std::max<std::size_t>(size.rows, 1);
  page.lines = std::move(header);
  page.lines.push_back({});
  page.lines.insert(page.lines.end(), body.begin(), body.end());
  // The keys stand on the last rows, whatever is above.
  page.lines.resize(rows > keys.size() ? rows - keys.size() : 0);
  page.lines.insert(page.lines.end(), keys.begin(), keys.end());
  if (page.lines.size() > rows) page.lines.resize(rows);
  for (TextLine& line : page.lines) line.text = clipped(line.text, size.columns);
  return page;
}

std::string why_ended(const Dwell& dwell) {
  // The stop is told as the reason; that it ended the dwell at the end of the data says nothing more.
  if (dwell.settling_reason.empty()) return to_string(dwell.ended_by);
  if (dwell.ended_by == EndedBy::end) return dwell.settling_reason;
  return std::string(to_string(dwell.ended_by)) + "; " + dwell.settling_reason;
}

std::string last_words(const WatchState& state, const Truth* truth, double now_s) {
  if (!state.dwell()) return {};
  std::vector<Section> sections = dwell_sections(*state.dwell(), options_of(state, truth, kUnlimited, now_s));
  put_legend(sections, *state.dwell(), kUnlimited);
  Section head;
  if (!state.name.empty()) head.body.push_back({printable(state.name), Style::plain});
  head.body.push_back({said(state, now_s), Style::plain});
  if (const std::string facts = facts_of(state, now_s); !facts.empty())
    head.body.push_back({printable(facts), Style::plain});
  for (TextLine& line : alarms(state, {}, {}, kUnlimited, now_s)) head.body.push_back(std::move(line));
  sections.insert(sections.begin(), std::move(head));
  if (Section list = alarms_section(state.alarms(), kUnlimited); !list.body.empty())
    sections.push_back(std::move(list));
  return plain_text(sections);
}

}  // namespace dwell::ctl
