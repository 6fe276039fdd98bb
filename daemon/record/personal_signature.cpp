#include "daemon/record/personal_signature.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "daemon/record/chain_file.hpp"

namespace dwell::record {
namespace {

tl::unexpected<std::string> fail(std::string why) { return tl::unexpected(std::move(why)); }

bool is_utf8(const std::string& text) {
  try {
    (void)nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

Result<void> check(const char* what, const std::string& text) {
  if (text.size() > kMaxWords)
    return fail(std::string("the ") + what + " has " + std::to_string(text.size()) + " bytes, expected at most " +
                std::to_string(kMaxWords));
  const auto control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (std::any_of(text.begin(), text.end(), control))
    return fail(std::string("the ") + what + " holds a line end or another control character, expected one line");
  if (!is_utf8(text)) return fail(std::string("the ") + what + " is not UTF-8");
  return {};
}

std::string bytes_of(const std::string& hexadecimal) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hexadecimal.size(); i += 2)
    bytes += static_cast<char>(digit(hexadecimal[i]) << 4 | digit(hexadecimal[i + 1]));
  return bytes;
}

// Of a run file, as far as a signature needs it.
struct Ended {
  RunHeader header;
  std::int64_t end_ns = 0;
  std::int64_t last = 0;  // entry
  Digest head{};          // of that
};

Result<Ended> read_ended(const std::string& path) {
  auto reader = ChainReader::open(path, ChainSort::run);
  if (!reader) return fail(reader.error());
  auto row = reader->next();
  if (!row) return fail(row.error());
  if (!*row || (*row)->entry.kind != "run") return fail("the first entry is no `run`");
  auto header = parse_run_header((*row)->entry.body);
  if (!header) return fail(header.error());
  Ended ended;
  ended.header = std::move(*header);
  reader->seek(2, "end");
  row = reader->next();
  if (!row) return fail(row.error());
  if (!*row) return fail("the run has not ended: it is being recorded, or was cut off");
  ended.end_ns = (*row)->entry.t_ns;
  reader->seek((*row)->entry.seq);
  while ((row = reader->next()) && *row) {
    ended.last = (*row)->entry.seq;
    ended.head = (*row)->head;
  }
  if (!row) return fail(row.error());
  return ended;
}

}  // namespace

Result<void> check_words(const PersonalSignature& signature) {
  if (signature.name.empty()) return fail("there is no name, expected that of the person who signs");
  if (signature.meaning.empty()) return fail("there is no meaning, expected for instance \"reviewed\"");
  return check("name", signature.name).and_then([&] { return check("meaning", signature.meaning); }).and_then([&] {
    return check("reason", signature.reason);
  });
}

std::string signed_lines(const std::string& run, const PersonalSignature& signature) {
  std::string text = "dwell/signature/" + run + "\n" + std::to_string(signature.seq) + "\n" +
                     base64(bytes_of(signature.head)) + "\nutc: " + signature.utc + "\nname: " + signature.name +
                     "\nmeaning: " + signature.meaning + "\n";
  if (!signature.reason.empty()) text += "reason: " + signature.reason + "\n";
  return text;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  (void)std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

Result<Signed> sign_run(const std::string& path, const PersonalSignature& words, const SigningKey& key) {
  if (const auto fit = check_words(words); !fit) return fail(fit.error());
  const auto ended = read_ended(path);
  if (!ended) return fail(ended.error());
  PersonalSignature signature = words;
  signature.utc = utc_now();
  signature.seq = ended->last;
  signature.head = hex(ended->head);
  signature.vkey = key.public_key().vkey();
  signature.note = signature.person ? "" : key.sign(signed_lines(ended->header.id, signature));
  auto writer = ChainWriter::open(path, ChainSort::run, "dwell/run/" + ended->header.id, key);
  if (!writer) return fail(writer.error());
  // Another signature may have come meanwhile.
  if (writer->committed() != ended->last || writer->committed_head() != ended->head)
    return fail("somebody else has just signed it; sign again");
  return writer->append("signature", ended->end_ns, to_json(signature))
      .and_then([&] { return writer->close(); })
      .map([&] {
        return Signed{ended->header.run, std::move(signature)};
      });
}

}  // namespace dwell::record
