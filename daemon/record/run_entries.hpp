// The JSON entries of a run file as plain data. docs/run-file.md, "Kinds of entries". Readers ignore members that they
// do not know, so newer files stay readable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::record {

// Largest JSON body. Parsing takes up to 32 times its size, so this bounds what a hostile file can make a reader
// allocate. A writer must not exceed it: what it wrote could not be read back.
inline constexpr std::size_t kMaxJson = 8 << 20;

// Who gave an order: a user of the computer, by the peer credentials of the control socket; or whoever showed the
// service's token.
struct Person {
  std::optional<std::uint32_t> uid;  // none: no user of the computer; the name says how the order came
  std::string name;                  // of a user, empty: unknown to the system
};
// "anna (uid 1000)", "uid 1000", or the name alone.
[[nodiscard]] std::string who(const Person& person);

// A file that the run was recorded with. Of a large one the run file holds no text.
struct KeptFile {
  std::string path;    // as the rig file names it
  std::string sha256;  // hexadecimal; empty: so large that it was not read at all
  std::string text;

  // Whether `text` is what the file held. An empty file is known by its hash.
  [[nodiscard]] bool holds_text() const;
};

struct Plugin {
  std::string driver;   // "modbus"
  std::string version;  // as the plugin states it
};

// Where and with what a run was recorded. A replay gives the same bits if `build` and `cpu` are the same.
struct Origin {
  std::string version;    // of the program
  std::string build;      // SHA-256 of the sources (its beginning), compiler and its version, flags, Eigen, libm
  std::string cpu;        // features that libm chooses by, sorted: "avx avx2 fma sse4_2"
  std::string host;       // name
  std::string time_zone;  // "Europe/Berlin", or "" where unknown
  bool clock_synchronized = false;
  double clock_error_s = 0.0;  // upper limit by the kernel's own estimate; NaN: not available
};
// The origin of what this process records now. Reads the environment, which no thread may alter meanwhile.
[[nodiscard]] Origin this_origin();
// Whether the kernel holds the computer's clock for synchronized now (adjtimex). Thread-safe.
[[nodiscard]] bool clock_synchronized() noexcept;

// The body of the `run` entry.
struct RunHeader {
  std::int64_t run = 0;  // the ledger's number, from 1 on; 0: a child file, which no ledger knows
  std::string id;        // 32 hexadecimal digits, random
  std::string label;     // as the operator gave it when the run began; empty: none
  std::string begun_by;  // "drive", "operator", "service" (which goes on after an interruption), "replay"
  std::optional<Person> person;
  std::string comment;
  std::string start_utc;               // ISO 8601, of the first record
  std::string previous_head;           // hexadecimal, of the run before on this ledger; empty: there was none
  std::string parent_id, parent_head;  // of a child: the run it was computed from, and its final head
  std::string vkey;                    // of the key that signs this file
  KeptFile rig;
  std::vector<KeptFile> files;  // that the rig file names
  std::vector<Plugin> plugins;
  std::vector<std::string> channels;  // names, by Record::channel
  Origin origin;

  // A child file: computed from the stream of another run, its parent, with another rig file. It holds no stream.
  [[nodiscard]] bool is_child() const noexcept { return !parent_id.empty(); }
};

// A published dwell. `dwell` is the JSON object of the public interface, as text; to_json() puts it in as it is.
struct StoredResult {
  std::uint64_t position = 0;  // records of the stream before it
  bool final = false;          // the dwell has ended
  std::string dwell;
};

// An estimate by any motion or a verification, as published. Both JSON texts are objects; to_json() puts them in
// as they are.
struct StoredModel {
  std::string kind;            // of the entry: "estimate" of coefficients by any motion, or "verification"
  std::uint64_t position = 0;  // records of the stream before it was published
  std::string utc;
  std::string from;    // the stretch of the stream that it was computed from
  std::string result;  // of the public interface
};

// What happened. `what`: "state", "fault", "loss", "action", "label", "recording", "clock", "alarm"; `text`: one line
// for people.
struct StoredEvent {
  std::uint64_t position = 0;
  std::string utc;
  std::string what;
  std::string text;
  std::optional<Person> person;  // of an action or a label
  std::string before, after, comment;
};

// Cuts each text of the event after `most` bytes, between two characters. A note behind the cut says how many bytes are
// missing, so a cut text is a little longer than `most`.
void shorten(StoredEvent& event, std::size_t most);
// As they happened: by their positions in the stream, those of one position as they are. A file tells the faults of a
// second after what came within it.
void sort_by_place(std::vector<StoredEvent>& events);

struct RunEnd {
  std::string why;  // "drive stopped", "operator", "service stopped", "disk full", …
  std::uint64_t records = 0, samples = 0;
  std::string utc;
  std::string label{};  // the last that somebody gave the run while it went on; empty: the header's holds
};

// A person's signature over the head of entry `seq`.
struct PersonalSignature {
  std::string name;     // as the person gives it
  std::string meaning;  // "reviewed"
  std::string reason;
  std::string utc;
  std::int64_t seq = 0;
  std::string head;  // hexadecimal
  // Who vouches. Either the service, for the user of the control socket: then `person` is set. Or a key of the person's
  // own: then `vkey` is set, and `note` holds these lines signed by it.
  std::optional<Person> person;
  std::string vkey, note;
};

[[nodiscard]] std::string to_json(const RunHeader& header);
[[nodiscard]] std::string to_json(const StoredResult& result);
[[nodiscard]] std::string to_json(const StoredModel& model);
[[nodiscard]] std::string to_json(const StoredEvent& event);
[[nodiscard]] std::string to_json(const RunEnd& end);
[[nodiscard]] std::string to_json(const PersonalSignature& signature);

// Each fails with what is missing or wrong, also if the body holds more than 8 MiB or nests deeper than 64. The bytes
// may be anything.
[[nodiscard]] Result<RunHeader> parse_run_header(const std::string& body);
[[nodiscard]] Result<StoredResult> parse_result(const std::string& body);
[[nodiscard]] Result<StoredModel> parse_model(const std::string& kind, const std::string& body);
[[nodiscard]] Result<StoredEvent> parse_event(const std::string& body);
[[nodiscard]] Result<RunEnd> parse_run_end(const std::string& body);
[[nodiscard]] Result<PersonalSignature> parse_personal_signature(const std::string& body);

}  // namespace dwell::record
