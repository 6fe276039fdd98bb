#include "daemon/handon/run_story.hpp"

#include <algorithm>
#include <optional>

#include "daemon/report/dwell_json.hpp"

namespace dwell::handon {
namespace {

Result<void> read_stream(Selection& selection, RunStory& story, const Progress& progress) {
  const std::vector<Channel>& channels = selection.rig().channels;
  const std::int64_t begin_ns = selection.reader().begin_ns();
  const double length_ns = std::max(1.0, static_cast<double>(selection.reader().end_ns() - begin_ns));
  story.traces.resize(channels.size());
  story.begin_s = selection.axis_s(begin_ns);
  story.end_s = selection.axis_s(selection.reader().end_ns());
  story.span_s = selection.reader().span_s().value_or(0.0);
  return selection.records(
      [&](const Record& record) {
        if (record.kind == Kind::sample) {
          story.traces[record.channel].take(static_cast<double>(record.t_ns - begin_ns) / length_ns,
                                            in_unit(channels[record.channel], record.value));
          ++story.samples;
        } else if (record.kind == Kind::loss) {
          story.lost[{record.channel, static_cast<Loss>(record.flags)}] += record.value;
        } else if (record.kind == Kind::fault) {
          story.faults[{record.channel, static_cast<Fault>(record.flags)}] += record.value;
        }
        return true;
      },
      progress);
}

// The dwells that ended; and of a run that was cut off, the last dwell in its last state.
Result<void> read_dwells(Selection& selection, RunStory& story, std::size_t& room) {
  std::optional<DwellView> unfinished;
  const auto take = [&story](DwellView view) {
    if (story.dwells.size() < RunStory::kDwells) {
      story.dwells.push_back(std::move(view));
    } else {
      ++story.dwells_left_out;
    }
  };
  auto done = selection.reader().results(false, [&](const record::StoredResult& result) {
    if (result.dwell.size() > room) {
      story.dwells_left_out += result.final ? 1 : 0;
      return true;
    }
    auto view = parse_dwell(result.dwell);
    if (!view || !view->dwell.index) return true;
    if (result.final) room -= result.dwell.size();
    unfinished.reset();
    if (result.final) {
      take(std::move(*view));
    } else {
      unfinished = std::move(*view);
    }
    return true;
  });
  if (done && unfinished) take(std::move(*unfinished));
  return done;
}

}  // namespace

RunStory tell_run(Selection& selection, const Progress& progress) {
  RunStory story;
  const auto note = [&story](const auto& read) {
    if (!read && std::find(story.unreadable.begin(), story.unreadable.end(), read.error()) == story.unreadable.end())
      story.unreadable.push_back(read.error());
  };
  note(read_stream(selection, story, progress));
  std::size_t room = RunStory::kStoredBytes;
  note(read_dwells(selection, story, room));
  note(selection.reader().events([&story](const record::StoredEvent& event) {
    if (story.events.size() < RunStory::kEvents) {
      story.events.push_back(event);
      record::shorten(story.events.back(), RunStory::kEventBytes);
    } else {
      ++story.events_left_out;
    }
    return true;
  }));
  note(selection.reader().models([&](const record::StoredModel& model) {
    const std::size_t size = model.from.size() + model.result.size();
    if (story.models.size() < RunStory::kModels && size <= room) {
      story.models.push_back(model);
      room -= size;
    } else {
      ++story.models_left_out;
    }
    return true;
  }));
  auto signatures = selection.reader().signatures();
  note(signatures);
  if (signatures) story.signatures = std::move(*signatures);
  return story;
}

}  // namespace dwell::handon
