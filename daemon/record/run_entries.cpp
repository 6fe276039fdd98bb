#include "daemon/record/run_entries.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>
#include <utility>

#include "daemon/record/digest.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/record/utf8.hpp"

namespace dwell::record {
namespace {

using Json = nlohmann::ordered_json;  // members stay in the order of the page

// A dwell nests six deep.
constexpr int kMaxNesting = 64;

// Thrown and caught in this file only.
struct Wrong {
  std::string what;
};

// fields(io, entry) lists the members of an object, once for both writing and reading. may(): a member that is left out
// if it is empty.
template <class Io, class T>
using Of = std::conditional_t<Io::kWrites, const T, T>;

template <class Io>
void fields(Io& io, Of<Io, Person>& person) {
  io.may("uid", person.uid);
  io.may("name", person.name);
}

template <class Io>
void fields(Io& io, Of<Io, KeptFile>& file) {
  io("path", file.path);
  io("sha256", file.sha256);
  io.bytes(file.text);
}

template <class Io>
void fields(Io& io, Of<Io, Plugin>& plugin) {
  io("driver", plugin.driver);
  io("version", plugin.version);
}

template <class Io>
void fields(Io& io, Of<Io, Origin>& origin) {
  io("version", origin.version);
  io("build", origin.build);
  io("cpu", origin.cpu);
  io("host", origin.host);
  io.may("time_zone", origin.time_zone);
  io("clock_synchronized", origin.clock_synchronized);
  io("clock_error_s", origin.clock_error_s);
}

template <class Io>
void fields(Io& io, Of<Io, RunHeader>& header) {
  io("run", header.run);
  io("id", header.id);
  io.may("label", header.label);
  io("begun_by", header.begun_by);
  io.may("person", header.person);
  io.may("comment", header.comment);
  io("start_utc", header.start_utc);
  io.may("previous_head", header.previous_head);
  io.may("parent_id", header.parent_id);
  io.may("parent_head", header.parent_head);
  io("vkey", header.vkey);
  io("rig", header.rig);
  io("files", header.files);
  io("plugins", header.plugins);
  io("channels", header.channels);
  io("origin", header.origin);
}

template <class Io>
void fields(Io& io, Of<Io, StoredEvent>& event) {
  io("position", event.position);
  io("utc", event.utc);
  io("what", event.what);
  io("text", event.text);
  io.may("person", event.person);
  io.may("before", event.before);
  io.may("after", event.after);
  io.may("comment", event.comment);
}

template <class Io>
void fields(Io& io, Of<Io, RunEnd>& end) {
  io("why", end.why);
  io("records", end.records);
  io("samples", end.samples);
  io("utc", end.utc);
  io.may("label", end.label);
}

template <class Io>
void fields(Io& io, Of<Io, PersonalSignature>& signature) {
  io("name", signature.name);
  io("meaning", signature.meaning);
  io.may("reason", signature.reason);
  io("utc", signature.utc);
  io("seq", signature.seq);
  io("head", signature.head);
  io.may("person", signature.person);
  io.may("vkey", signature.vkey);
  io.may("note", signature.note);
}

class Writer {
 public:
  static constexpr bool kWrites = true;

  template <class T>
  void operator()(const char* name, const T& value) {
    object_[name] = json(value);
  }
  void may(const char* name, const std::string& text) {
    if (!text.empty()) object_[name] = text;
  }
  template <class T>
  void may(const char* name, const std::optional<T>& value) {
    if (value) object_[name] = json(*value);
  }
  void bytes(const std::string& text) {
    if (is_utf8(text)) {
      object_["text"] = text;
    } else {
      object_["base64"] = base64(text);
    }
  }

  template <class T>
  [[nodiscard]] static Json json(const T& value) {
    if constexpr (std::is_same_v<T, double>) {
      return std::isfinite(value) ? Json(value) : Json(nullptr);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, std::string>) {
      return value;
    } else {
      Writer writer;
      fields(writer, value);
      return std::move(writer.object_);
    }
  }
  template <class T>
  [[nodiscard]] static Json json(const std::vector<T>& values) {
    Json array = Json::array();
    for (const T& value : values) array.push_back(json(value));
    return array;
  }

 private:
  Json object_ = Json::object();
};

class Reader {
 public:
  static constexpr bool kWrites = false;
  // path: of the object in the entry, for messages.
  Reader(const Json& object, std::string path) : object_(object), path_(std::move(path)) {
    if (!object.is_object()) throw Wrong{(path_.empty() ? "it" : quoted(path_)) + " is no object"};
  }

  template <class T>
  void operator()(const char* name, T& value) const {
    const auto found = object_.find(name);
    if (found == object_.end()) throw Wrong{quoted(path_to(name)) + " is missing"};
    read(*found, path_to(name), value);
  }
  void may(const char* name, std::string& text) const {
    text.clear();
    if (has(name)) (*this)(name, text);
  }
  template <class T>
  void may(const char* name, std::optional<T>& value) const {
    value.reset();
    if (has(name)) (*this)(name, value.emplace());
  }
  void bytes(std::string& text) const {
    if (!has("base64")) return (*this)("text", text);
    std::string written;
    (*this)("base64", written);
    auto decoded = from_base64(written);
    if (!decoded) throw Wrong{quoted(path_to("base64")) + " is not base64"};
    text = std::move(*decoded);
  }

 private:
  [[nodiscard]] static std::string quoted(const std::string& path) { return "\"" + path + "\""; }
  [[nodiscard]] std::string path_to(const char* name) const { return path_.empty() ? name : path_ + "." + name; }
  [[nodiscard]] bool has(const char* name) const {
    const auto found = object_.find(name);
    return found != object_.end() && !found->is_null();
  }

  template <class T>
  static void read(const Json& json, const std::string& path, T& value) {
    if constexpr (std::is_same_v<T, std::string>) {
      if (!json.is_string()) throw Wrong{quoted(path) + " is no text"};
      value = json.get<std::string>();
    } else if constexpr (std::is_same_v<T, bool>) {
      if (!json.is_boolean()) throw Wrong{quoted(path) + " is neither true nor false"};
      value = json.get<bool>();
    } else if constexpr (std::is_same_v<T, double>) {
      if (!json.is_number() && !json.is_null()) throw Wrong{quoted(path) + " is no number"};
      value = json.is_null() ? std::numeric_limits<double>::quiet_NaN() : json.get<double>();
    } else if constexpr (std::is_integral_v<T>) {
      // All our integers are 0 or above.
      if (!json.is_number_unsigned() || json.get<std::uint64_t>() > std::uint64_t{std::numeric_limits<T>::max()})
        throw Wrong{quoted(path) + " is no whole number from 0 to " + std::to_string(std::numeric_limits<T>::max())};
      value = static_cast<T>(json.get<std::uint64_t>());
    } else {
      const Reader reader(json, path);
      fields(reader, value);
    }
  }
  template <class T>
  static void read(const Json& json, const std::string& path, std::vector<T>& values) {
    if (!json.is_array()) throw Wrong{quoted(path) + " is no array"};
    values.clear();
    for (const Json& element : json) {
      const std::string place = path + "[" + std::to_string(values.size()) + "]";
      read(element, place, values.emplace_back());
    }
  }

  const Json& object_;
  std::string path_;
};

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

template <class T>
std::string written(const T& entry) {
  return text_of(Writer::json(entry));
}

int nesting(const std::string& body) {
  int depth = 0, deepest = 0;
  bool quoted = false;
  for (std::size_t i = 0; i < body.size(); ++i) {
    const char c = body[i];
    if (quoted) {
      if (c == '\\') ++i;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '{' || c == '[') {
      deepest = std::max(deepest, ++depth);
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return deepest;
}

Json parse(const std::string& body) {
  if (body.size() > kMaxJson)
    throw Wrong{"it holds " + std::to_string(body.size()) + " bytes: at most " + std::to_string(kMaxJson) +
                " are allowed"};
  if (nesting(body) > kMaxNesting) throw Wrong{"it nests deeper than " + std::to_string(kMaxNesting)};
  try {
    return Json::parse(body);
  } catch (const Json::parse_error& error) {
    throw Wrong{"it is not JSON at byte " + std::to_string(error.byte)};
  } catch (const Json::exception&) {  // a number beyond those of a double
    throw Wrong{"it is not JSON"};
  }
}

template <class T>
Result<T> parsed(const std::string& body, const char* entry) {
  try {
    T value;
    const Json json = parse(body);
    const Reader reader(json, "");
    fields(reader, value);
    return value;
  } catch (const Wrong& wrong) {
    return tl::unexpected(std::string(entry) + ": " + wrong.what);
  }
}

}  // namespace

std::string who(const Person& person) {
  if (!person.uid) return person.name.empty() ? "somebody" : person.name;
  const std::string uid = "uid " + std::to_string(*person.uid);
  return person.name.empty() ? uid : person.name + " (" + uid + ")";
}

std::string to_json(const RunHeader& header) { return written(header); }
std::string to_json(const StoredEvent& event) { return written(event); }
std::string to_json(const RunEnd& end) { return written(end); }
std::string to_json(const PersonalSignature& signature) { return written(signature); }

// The dwell is JSON text already and is inserted as it is: the recorder has no time to parse it.
std::string to_json(const StoredResult& result) {
  return R"({"position":)" + std::to_string(result.position) + R"(,"final":)" + (result.final ? "true" : "false") +
         R"(,"dwell":)" + result.dwell + "}";
}

Result<StoredResult> parse_result(const std::string& body) {
  try {
    StoredResult result;
    const Json json = parse(body);
    const Reader reader(json, "");
    reader("position", result.position);
    reader("final", result.final);
    const auto dwell = json.find("dwell");
    if (dwell == json.end() || !dwell->is_object()) throw Wrong{"\"dwell\" is no object"};
    result.dwell = text_of(*dwell);
    return result;
  } catch (const Wrong& wrong) {
    return tl::unexpected("result entry: " + wrong.what);
  }
}

std::string to_json(const StoredModel& model) {
  return R"({"position":)" + std::to_string(model.position) + R"(,"utc":)" + text_of(Json(model.utc)) + R"(,"from":)" +
         model.from + R"(,"result":)" + model.result + "}";
}

Result<StoredModel> parse_model(const std::string& kind, const std::string& body) {
  try {
    StoredModel model;
    const Json json = parse(body);
    const Reader reader(json, "");
    model.kind = kind;
    reader("position", model.position);
    reader("utc", model.utc);
    for (const auto& [name, text] : {std::pair{"from", &model.from}, std::pair{"result", &model.result}}) {
      const auto part = json.find(name);
      if (part == json.end() || !part->is_object()) throw Wrong{"\"" + std::string(name) + "\" is no object"};
      *text = text_of(*part);
    }
    return model;
  } catch (const Wrong& wrong) {
    return tl::unexpected(kind + " entry: " + wrong.what);
  }
}

Result<RunHeader> parse_run_header(const std::string& body) {
  Result<RunHeader> header = parsed<RunHeader>(body, "run entry");
  if (header && !header->start_utc.empty())
    if (const auto utc_ns = parse_utc(header->start_utc); !utc_ns)
      return tl::unexpected("run entry: start_utc: " + utc_ns.error());
  return header;
}
Result<StoredEvent> parse_event(const std::string& body) { return parsed<StoredEvent>(body, "event entry"); }
Result<RunEnd> parse_run_end(const std::string& body) { return parsed<RunEnd>(body, "end entry"); }
Result<PersonalSignature> parse_personal_signature(const std::string& body) {
  Result<PersonalSignature> signature = parsed<PersonalSignature>(body, "signature entry");
  // Else whoever has any key could pass as a user for whom the service vouches.
  if (signature && signature->person && !signature->vkey.empty())
    return tl::unexpected<std::string>("signature entry: both a \"person\" of the service and a \"vkey\" of their own");
  return signature;
}

bool KeptFile::holds_text() const {
  static constexpr const char* kOfNothing = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
  return !text.empty() || sha256 == kOfNothing;
}

void sort_by_place(std::vector<StoredEvent>& events) {
  std::stable_sort(events.begin(), events.end(),
                   [](const StoredEvent& a, const StoredEvent& b) { return a.position < b.position; });
}

void shorten(StoredEvent& event, std::size_t most) {
  std::string nobody;
  for (std::string* text : {&event.utc, &event.what, &event.text, event.person ? &event.person->name : &nobody,
                            &event.before, &event.after, &event.comment}) {
    if (text->size() <= most) continue;
    std::size_t kept = most;
    while (kept > 0 && (static_cast<unsigned char>((*text)[kept]) & 0xC0U) == 0x80U) --kept;  // within a character
    *text = text->substr(0, kept) + " … (cut: " + std::to_string(text->size() - kept) +
            " bytes more, which are in the run file)";
  }
}

}  // namespace dwell::record
