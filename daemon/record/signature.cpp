#include "daemon/record/signature.hpp"

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <optional>
#include <thread>
#include <tuple>
#include <utility>

#include "daemon/record/snapshot.hpp"
#include "daemon/record/utf8.hpp"
#include "daemon/record/words.hpp"

namespace dwell::record {
namespace {

// The header of a run that has ended, and its clock's last instant.
struct EndedRun {
  RunHeader header;
  PublicKey key;
  std::int64_t t_ns = 0;
  std::string origin() const { return "dwell/run/" + header.id; }
};

// nullopt: the run has not ended.
Result<std::optional<EndedRun>> read_ended(const std::string& path) {
  Result<ChainReader> reader = ChainReader::open(path, ChainSort::run);
  if (!reader) return fails(std::move(reader.error()));
  const auto first = reader->next();
  if (!first) return fails(first.error());
  if (!*first) return fails(path + ": is empty");
  Result<RunHeader> header = parse_run_header((*first)->entry.body);
  if (!header) return fails(path + ": " + header.error());
  Result<PublicKey> key = PublicKey::parse(header->vkey);
  if (!key) return fails(path + ": its key: " + key.error());
  reader->seek(1, "end");
  const auto end = reader->next();
  if (!end) return fails(end.error());
  if (!*end) return std::nullopt;
  return EndedRun{std::move(*header), std::move(*key), (*end)->entry.t_ns};
}

Result<PersonalSignature> append(ChainWriter& file, const EndedRun& run, const PersonalSignature& signature) {
  Result<void> done = file.append("signature", run.t_ns, to_json(signature));
  if (done) done = file.close();
  if (!done) return fails(std::move(done.error()));
  return signature;
}

constexpr std::chrono::milliseconds kBetweenTries{50};
// Tries until the run's end is in the file: 3 s. It is written with the block after it, a second later, and the disk
// may be slow. Doubled, a request to sign a run that still goes on is answered later.
constexpr int kMostForEnd = 60;
// Tries until the service has closed the file: 10 s. Closing takes three waits for the disk; a longer one is a fault.
constexpr int kMostTries = 200;

Result<EndedRun> wait_for_end(const std::string& path, const WhileBusy& busy) {
  for (int tries = 0;; ++tries) {
    Result<std::optional<EndedRun>> run = read_ended(path);
    // The service is closing the file.
    if (!run && run.error().cause() == Cause::read_again && busy && busy(tries)) continue;
    if (!run) return fails(std::move(run.error()));
    if (*run) return std::move(**run);
    if (!busy || tries == kMostForEnd || !busy(tries))
      return fails(path +
                   ": the run has no end: it is still recorded or was cut off; only a run with an end can be signed");
  }
}

// Opens the file; again if the service closed it meanwhile, as long as `busy` returns true.
template <class Open>
Result<ChainWriter> open_again(const Open& open, const WhileBusy& busy) {
  for (int tries = 0;; ++tries) {
    Result<ChainWriter> file = open();
    if (file || file.error().cause() != Cause::read_again || !busy || !busy(tries)) return file;
  }
}

// What the person says, a line each. Fails if a run file could not hold it.
Result<std::string> lines_of(const PersonalSignature& signature) {
  std::string text;
  const std::initializer_list<std::pair<const char*, const std::string*>> parts = {{"name", &signature.name},
                                                                                   {"meaning", &signature.meaning},
                                                                                   {"reason", &signature.reason},
                                                                                   {"utc", &signature.utc}};
  for (const auto& [what, part] : parts) {
    // The entry is JSON. It would hold other bytes than were signed.
    if (const std::string why = why_not_utf8(*part); !why.empty()) return fails(std::string(what) + ": " + why);
    if (std::any_of(part->begin(), part->end(), [](char c) { return (c >= 0 && c < ' ') || c == '\x7f'; }))
      return fails("name, meaning and reason are one line each, without control characters");
    text += *part + "\n";
  }
  return text;
}

// A new signature must pass this. Files that were signed before may hold other words and are still read.
Result<void> may_be_signed(const PersonalSignature& signature) {
  for (const auto& [what, words, most] :
       {std::tuple("name", &signature.name, kLabelBytes), std::tuple("meaning", &signature.meaning, kLabelBytes),
        std::tuple("reason", &signature.reason, kCommentBytes)})
    if (const std::string why = why_not_words(*words, most); !why.empty()) return fails(std::string(what) + ": " + why);
  return {};
}

}  // namespace

Result<std::string> signature_text(const std::string& run_id, const PersonalSignature& signature) {
  const std::optional<Digest> head = from_hex(signature.head);
  if (!head) return fails("the head of a signature is 64 hexadecimal digits");
  const std::string text = "dwell/signature/" + run_id + "\n" + std::to_string(signature.seq) + "\n" +
                           base64({reinterpret_cast<const char*>(head->data()), head->size()}) + "\n";
  const Result<std::string> words = lines_of(signature);
  if (!words) return words;
  return text + *words;
}

bool wait_for_service(int tries) {
  if (tries >= kMostTries) return false;
  std::this_thread::sleep_for(kBetweenTries);
  return true;
}

Result<PersonalSignature> sign_by_service(const std::string& path, PersonalSignature signature,
                                          const SigningKey& service, const WhileBusy& busy) {
  if (!signature.person) return fails("the service signs only for a user of this computer");
  // Checked first: opening the file for writing alters it.
  if (auto may = may_be_signed(signature); !may) return fails(std::move(may.error()));
  const Result<EndedRun> run = wait_for_end(path, busy);
  if (!run) return fails(run.error());
  if (!(run->key == service.public_key()))
    return fails(path + ": was recorded with the key " + run->key.fingerprint() + ", and the service signs with " +
                 service.public_key().fingerprint() + " now; sign with a key of your own");
  Result<ChainWriter> file = open_again(
      [&] { return ChainWriter::open(path, ChainSort::run, run->origin(), service, service.public_key(), busy); },
      busy);
  if (!file) return fails(std::move(file.error()));
  signature.seq = file->committed();
  signature.head = hex(file->committed_head());
  signature.vkey.clear();
  signature.note.clear();
  if (const Result<std::string> text = signature_text(run->header.id, signature); !text) return fails(text.error());
  return append(*file, *run, signature);
}

Result<PersonalSignature> sign_by_own_key(const std::string& path, PersonalSignature signature, const SigningKey& own,
                                          const WhileBusy& busy) {
  if (auto may = may_be_signed(signature); !may) return fails(std::move(may.error()));
  const Result<EndedRun> run = wait_for_end(path, busy);
  if (!run) return fails(run.error());
  Result<ChainWriter> file = open_again(
      [&] { return ChainWriter::open_without_key(path, ChainSort::run, run->origin(), run->key, busy); }, busy);
  if (!file) return fails(std::move(file.error()));
  signature.seq = file->committed();
  signature.head = hex(file->committed_head());
  signature.person.reset();
  const Result<std::string> text = signature_text(run->header.id, signature);
  if (!text) return fails(text.error());
  signature.vkey = own.public_key().vkey();
  signature.note = own.sign(*text);
  return append(*file, *run, signature);
}

}  // namespace dwell::record
