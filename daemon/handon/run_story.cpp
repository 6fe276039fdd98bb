#include "daemon/handon/run_story.hpp"

#include <algorithm>
#include <utility>

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

void note(RunStory& story, std::string why) {
  if (why.size() > RunStory::kEventBytes) why = why.substr(0, RunStory::kEventBytes) + " …";
  if (std::find(story.unreadable.begin(), story.unreadable.end(), why) != story.unreadable.end()) return;
  if (story.unreadable.size() < RunStory::kUnreadable) {
    story.unreadable.push_back(std::move(why));
  } else {
    ++story.unreadable_left_out;
  }
}

// The dwells that ended; and of a run that was cut off, the last dwell in its last state.
Result<void> read_dwells(Selection& selection, RunStory& story, std::size_t& room) {
  return selection.reader().dwells([&](const record::StoredResult& result) {
    if (result.dwell.size() > room || story.dwells.size() == RunStory::kDwells) {
      story.dwells_left_out += result.final ? 1 : 0;
      return true;
    }
    auto view = parse_dwell(result.dwell);
    if (!view) {
      note(story,
           selection.path() + ": the result at position " + std::to_string(result.position) + ": " + view.error());
    } else if (view->dwell.index) {
      room -= result.dwell.size();
      story.dwells.push_back(std::move(*view));
    }
    return true;
  });
}

}  // namespace

RunStory tell_run(Selection& selection, const Progress& progress) {
  RunStory story;
  for (const std::string& why : selection.unreadable()) note(story, why);
  const auto note_end = [&story](const auto& read) {
    if (!read) note(story, read.error());
  };
  note_end(read_stream(selection, story, progress));
  std::size_t room = RunStory::kStoredBytes;
  note_end(read_dwells(selection, story, room));
  note_end(selection.reader().events([&story](const record::StoredEvent& event) {
    if (story.events.size() < RunStory::kEvents) {
      story.events.push_back(event);
      record::shorten(story.events.back(), RunStory::kEventBytes);
    } else {
      ++story.events_left_out;
    }
    return true;
  }));
  record::sort_by_place(story.events);
  note_end(selection.reader().models([&](const record::StoredModel& model) {
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
  note_end(signatures);
  if (signatures) story.signatures = std::move(*signatures);
  return story;
}

}  // namespace dwell::handon
