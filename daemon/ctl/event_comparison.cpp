#include "daemon/ctl/event_comparison.hpp"

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <map>
#include <string>
#include <utility>

namespace dwell::ctl {
namespace {

using record::StoredEvent;

Difference difference(const char* what, std::string stored, std::string replayed) {
  return {what, std::move(stored), std::move(replayed), kNaN, false};
}

std::string in_words(const StoredEvent& event) { return event.what + ": " + event.text; }

// Of two events that are not the same.
std::vector<Difference> differences(const StoredEvent& stored, const StoredEvent& replayed) {
  std::vector<Difference> found;
  for (const auto& [name, member] : std::initializer_list<std::pair<const char*, std::string StoredEvent::*>>{
           {"event.utc", &StoredEvent::utc},
           {"event.what", &StoredEvent::what},
           {"event.text", &StoredEvent::text},
           {"event.before", &StoredEvent::before},
           {"event.after", &StoredEvent::after},
           {"event.comment", &StoredEvent::comment}})
    if (stored.*member != replayed.*member) found.push_back(difference(name, stored.*member, replayed.*member));
  const auto person = [](const StoredEvent& event) {
    return event.person ? record::who(*event.person) : std::string();
  };
  if (person(stored) != person(replayed)) found.push_back(difference("event.person", person(stored), person(replayed)));
  return found;
}

// Hands over each stored event that is compared, in the file's order, until the function returns false.
using StoredEvents = std::function<record::Result<void>(const std::function<bool(const StoredEvent&)>&)>;

record::Result<void> compare(const std::vector<StoredEvent>& replayed, const StoredEvents& stored_events,
                             ReplayFindings& to) {
  struct Here {
    std::vector<const StoredEvent*> replayed;  // what the file lacks of it
    std::vector<StoredEvent> stored;           // not among the replayed ones
  };
  std::map<std::uint64_t, Here> at;
  for (const StoredEvent& event : replayed) at[event.position].replayed.push_back(&event);
  std::size_t others = 0;
  const auto read = stored_events([&](const StoredEvent& stored) {
    ++to.events;
    const auto found = at.find(stored.position);
    if (found == at.end() || others == replayed.size()) {
      to.add({stored.position, false, {}, difference("event", in_words(stored), {})});
      return true;
    }
    std::vector<const StoredEvent*>& left = found->second.replayed;
    const auto same = std::find_if(left.begin(), left.end(),
                                   [&](const StoredEvent* one) { return differences(stored, *one).empty(); });
    if (same != left.end()) {
      left.erase(same);
    } else {
      found->second.stored.push_back(stored);
      ++others;
    }
    return true;
  });
  if (!read) return read;
  for (const auto& [position, here] : at) {
    for (std::size_t i = 0; i < std::max(here.stored.size(), here.replayed.size()); ++i) {
      if (i >= here.stored.size()) {
        to.add({position, false, {}, difference("event", {}, in_words(*here.replayed[i]))});
      } else if (i >= here.replayed.size()) {
        to.add({position, false, {}, difference("event", in_words(here.stored[i]), {})});
      } else {
        for (Difference& found : differences(here.stored[i], *here.replayed[i]))
          to.add({position, false, {}, std::move(found)});
      }
    }
  }
  return {};
}

}  // namespace

record::Result<void> compare_events(const std::vector<StoredEvent>& replayed, record::RunReader& child,
                                    ReplayFindings& to) {
  return compare(
      replayed, [&](const auto& take) { return child.events(take); }, to);
}

record::Result<void> compare_states(std::vector<StoredEvent> replayed, std::uint64_t begins_at, record::RunReader& run,
                                    ReplayFindings& to) {
  std::vector<StoredEvent> stored;
  const auto read = run.events([&](const StoredEvent& event) {
    if (event.what != "state") return true;
    StoredEvent& change = stored.emplace_back();
    change.position = event.position;
    change.what = event.what;
    change.text = event.text;
    return true;
  });
  if (!read) return read;
  const std::uint64_t end = run.end() ? run.end()->records : stored.empty() ? 0 : stored.back().position + 1;
  const auto not_compared = [&](const StoredEvent& event) {
    return event.position <= begins_at || event.position >= end;
  };
  std::erase_if(stored, not_compared);
  std::erase_if(replayed, not_compared);
  return compare(
      replayed,
      [&](const auto& take) -> record::Result<void> {
        for (const StoredEvent& event : stored)
          if (!take(event)) break;
        return {};
      },
      to);
}

}  // namespace dwell::ctl
