#include "daemon/serve/operator_verbs.hpp"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/printable.hpp"
#include "daemon/record/utf8.hpp"
#include "daemon/record/words.hpp"

namespace dwell {
namespace {

using Verb = OperatorRequest::Verb;

// "channel:" or "device:" and a name of the rig file: a channel's has at most 64 bytes, a device's 4096.
constexpr std::size_t kAlarmBytes = 4200;
// Brackets in a request. Ours do not nest; this bounds the parser's recursion.
constexpr std::ptrdiff_t kMostBrackets = 64;

std::optional<Verb> verb_of(std::string_view name) {
  if (name == "start") return Verb::start;
  if (name == "stop") return Verb::stop;
  if (name == "label") return Verb::label;
  if (name == "rearm") return Verb::rearm;
  if (name == "acknowledge") return Verb::acknowledge;
  return std::nullopt;
}

tl::unexpected<NotDone> unusable(std::string reason) {
  return tl::unexpected(NotDone{NotDone::Kind::unusable, std::move(reason)});
}

// An optional text of the request; fails with what is wrong.
tl::expected<std::string, NotDone> text_of(const Json& request, const char* key, std::size_t most) {
  const auto given = request.find(key);
  if (given == request.end()) return {};
  const auto* text = given->get_ptr<const std::string*>();
  const std::string why = text == nullptr ? "expected text" : record::why_not_words(*text, most);
  if (!why.empty()) return unusable("\"" + std::string(key) + "\" cannot be taken: " + why);
  return *text;
}

bool takes_label(Verb verb) { return verb == Verb::start || verb == Verb::label; }

// The first member that this verb does not know: misspelt, a comment or a name would be lost without a word. The verb
// itself stands in a line of the control socket.
std::optional<std::string> unknown_member(Verb verb, const Json& request) {
  for (const auto& [key, value] : request.items())
    if (key != "verb" && key != "comment" && !(takes_label(verb) && key == "label") &&
        !(verb == Verb::acknowledge && key == "alarm"))
      return key;
  return std::nullopt;
}

const char* members_of(Verb verb) {
  switch (verb) {
    case Verb::start:
    case Verb::label:
      return "label and comment";
    case Verb::acknowledge:
      return "alarm and comment";
    default:
      return "comment";
  }
}

}  // namespace

tl::expected<Json, std::string> parse_request(std::string_view text) {
  if (std::string why = record::why_not_utf8(text); !why.empty()) return tl::unexpected(std::move(why));
  if (std::count(text.begin(), text.end(), '[') + std::count(text.begin(), text.end(), '{') > kMostBrackets)
    return tl::unexpected(std::string("it is too deeply nested"));
  // Where a name stands twice the parser keeps one member and drops the other in silence: it may be what was meant.
  std::vector<std::set<std::string>> members;  // of the objects that are open
  std::string twice;
  const auto see = [&](int, Json::parse_event_t event, const Json& parsed) {
    if (event == Json::parse_event_t::object_start) members.emplace_back();
    if (event == Json::parse_event_t::object_end && !members.empty()) members.pop_back();
    if (event == Json::parse_event_t::key && !members.back().insert(parsed.get<std::string>()).second)
      twice = parsed.get<std::string>();
    return true;
  };
  Json request = Json::parse(text, see, false);
  if (!twice.empty()) return tl::unexpected("\"" + twice + "\" is given twice, expected once");
  if (!request.is_object()) return tl::unexpected(std::string("not a JSON object"));
  return request;
}

bool is_operator_verb(std::string_view verb) { return verb_of(verb).has_value(); }

tl::expected<void, NotDone> perform(std::string_view name, const Json& request, const Operate& operate) {
  const auto verb = verb_of(name);
  if (!verb) return unusable("unknown verb \"" + std::string(name) + "\"");
  if (const auto key = unknown_member(*verb, request))
    return unusable("\"" + printable(std::string_view(*key).substr(0, 64)) +
                    "\" is not understood: " + std::string(name) + " takes " + members_of(*verb));
  const auto label = text_of(request, "label", record::kLabelBytes),
             comment = text_of(request, "comment", record::kCommentBytes);
  const auto alarm = text_of(request, "alarm", kAlarmBytes);
  if (!label) return tl::unexpected(label.error());
  if (!comment) return tl::unexpected(comment.error());
  if (!alarm) return tl::unexpected(alarm.error());
  if (takes_label(*verb) && label->empty()) return unusable("no label: expected \"label\": \"what is measured\"");
  if (*verb == Verb::acknowledge && alarm->empty())
    return unusable("no alarm: expected \"alarm\": \"the name of one\"");
  const auto done = operate({*verb, *label, *comment, *alarm});
  if (!done) return tl::unexpected(NotDone{NotDone::Kind::impossible_now, done.error()});
  return {};
}

tl::expected<std::string, std::string> start_answer(const StartOutcome& outcome) {
  switch (outcome.is) {
    case StartOutcome::Is::recorded:
      return R"({"done":true})";
    case StartOutcome::Is::not_recorded:
      return tl::unexpected("the run was asked for and is not recorded: " + outcome.why);
    case StartOutcome::Is::unknown:
      break;
  }
  return R"({"done":true,"recording":null})";
}

}  // namespace dwell
