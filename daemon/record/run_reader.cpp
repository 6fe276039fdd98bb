#include "daemon/record/run_reader.hpp"

#include <limits>
#include <mutex>
#include <string_view>
#include <utility>

#include "daemon/record/ahead.hpp"
#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/instants.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

using Row = ChainReader::Row;

// Most signatures. People sign a run a few times; this bounds what a hostile file can make a reader allocate.
constexpr std::size_t kMostSignatures = 1000;

// Decoded blocks that wait or are being decoded, beside the one in use; each may take 34 MB, as may one that was used.
constexpr std::size_t kBlocksAhead = 1;

// Of a result in the form that dwelld writes, without parsing it: most results are not final. false: it must be parsed.
bool is_written_as_not_final(std::string_view body) {
  return body.substr(0, body.find("\"dwell\"")).find("\"final\":false") != std::string_view::npos;
}

}  // namespace

struct RunReader::Impl {
  std::string path;
  ChainReader chain;
  RunHeader header = {};
  std::optional<RunEnd> end = std::nullopt;
  std::int64_t begin_ns = 0, end_ns = 0;
  std::int64_t header_ns = 0;                           // t_ns of the `run` entry
  std::optional<std::int64_t> ended_ns = std::nullopt;  // t_ns of the `end` entry
  std::int64_t first_block = 0, last_block = 0;         // seq; 0: there is none

  // Errors of `chain` already name the file.
  [[nodiscard]] tl::unexpected<std::string> fails(const Entry& entry, const std::string& what) const {
    return tl::unexpected(path + ": entry " + std::to_string(entry.seq) + ": " + what);
  }

  // The first entry of this kind from `seq` on.
  [[nodiscard]] Result<std::optional<Row>> find(std::int64_t seq, const char* kind) {
    chain.seek(seq, kind);
    return chain.next();
  }

  // Hands every entry of this kind from `seq` on to take(entry), which returns whether to go on.
  template <class Take>
  [[nodiscard]] Result<void> each(std::int64_t seq, const char* kind, const Take& take) {
    chain.seek(seq, kind);
    for (;;) {
      const auto row = chain.next();
      if (!row) return tl::unexpected(row.error());
      if (!row->has_value()) return {};
      const Result<bool> more = take((*row)->entry);
      if (!more) return fails((*row)->entry, more.error());
      if (!*more) return {};
    }
  }

  [[nodiscard]] Result<void> read_header() {
    const auto row = find(1, "");
    if (!row) return tl::unexpected(row.error());
    if (!row->has_value()) return tl::unexpected(path + ": holds no entry; expected the \"run\" entry first");
    const Entry& entry = (*row)->entry;
    // Its kind may be any text, line breaks included, so the message does not repeat it.
    if (entry.kind != "run") return fails(entry, "is not of the kind \"run\"; expected the \"run\" entry first");
    auto parsed = parse_run_header(entry.body);
    if (!parsed) return fails(entry, parsed.error());
    header = std::move(*parsed);
    header_ns = entry.t_ns;
    return {};
  }

  // Finds the last entry of the stream in ever larger and then ever smaller steps: a walk would read the whole file.
  [[nodiscard]] Result<void> find_last_block() {
    constexpr std::int64_t kMostStep = std::int64_t{1} << 61U;
    std::int64_t step = 1;
    bool grows = true;
    while (step > 0) {
      const bool beyond = last_block > std::numeric_limits<std::int64_t>::max() - step;
      const auto row = beyond ? std::nullopt : find(last_block + step, "stream");
      if (!row) return tl::unexpected(row.error());
      if (row->has_value()) {
        last_block = (*row)->entry.seq;
        end_ns = (*row)->entry.t_ns;
      }
      grows = grows && row->has_value() && step < kMostStep;
      step = grows ? step * 2 : step / 2;
    }
    return {};
  }

  [[nodiscard]] Result<void> decode(const Entry& entry, std::vector<Record>& records) const {
    if (const auto decoded = decode_block(entry.body, records); !decoded) return fails(entry, decoded.error());
    const auto off = std::find_if(records.begin(), records.end(), [](const Record& r) { return !is_on_clock(r.t_ns); });
    if (off == records.end()) return {};
    return fails(entry,
                 "record " + std::to_string(off - records.begin() + 1) + " of its block: " + clock_fault(off->t_ns));
  }

  [[nodiscard]] Result<void> read_bounds() {
    const auto row = find(1, "stream");
    if (!row) return tl::unexpected(row.error());
    if (row->has_value()) {
      const Entry& entry = (*row)->entry;
      std::vector<Record> records;
      if (auto decoded = decode(entry, records); !decoded) return decoded;
      begin_ns = records.empty() ? entry.t_ns : records.front().t_ns;
      first_block = last_block = entry.seq;
      end_ns = entry.t_ns;
      if (auto found = find_last_block(); !found) return found;
    }
    return each(last_block, "end", [&](const Entry& entry) -> Result<bool> {
      auto parsed = parse_run_end(entry.body);
      if (!parsed) return tl::unexpected(parsed.error());
      end = std::move(*parsed);
      ended_ns = entry.t_ns;
      return false;
    });
  }

  // The label that the run was given last. Without an end entry only the events tell.
  [[nodiscard]] Result<void> read_label() {
    if (end) {
      if (!end->label.empty()) header.label = end->label;
      return {};
    }
    return each(1, "event", [&](const Entry& entry) -> Result<bool> {
      auto event = parse_event(entry.body);
      if (event && event->what == "label") header.label = std::move(event->after);
      return true;  // events() tells of one that is damaged
    });
  }

  using Records = std::vector<Record>;

  // The next block, in the memory of `records`; nullopt: there is none left.
  [[nodiscard]] std::optional<Result<Records>> next_block(Records records) {
    const auto row = chain.next();
    if (!row) return tl::unexpected(row.error());
    if (!row->has_value()) return std::nullopt;
    if (auto decoded = decode((*row)->entry, records); !decoded) return tl::unexpected(std::move(decoded.error()));
    return records;
  }

  // Memory of blocks that were used: getting it from the system and giving it back would take longer than decoding.
  class Used {
   public:
    void put(Records&& records) {
      const std::lock_guard lock(mutex_);
      records_ = std::move(records);
    }
    [[nodiscard]] Records take() {
      const std::lock_guard lock(mutex_);
      return std::exchange(records_, {});
    }

   private:
    std::mutex mutex_;
    Records records_;
  };

  // Reading and decoding take a fifth of the time that a pipeline does: they go on beside `take`.
  [[nodiscard]] Result<void> blocks(std::int64_t seq, const TakeBlock& take) {
    chain.seek(seq, "stream");
    Used used;
    const auto make = [this, &used, failed = false]() mutable -> std::optional<Result<Records>> {
      if (failed) return std::nullopt;
      auto block = next_block(used.take());
      failed = block && !*block;
      return block;
    };
    Ahead<Result<Records>> ahead(make, kBlocksAhead);
    while (auto block = ahead.next()) {
      if (!*block) return tl::unexpected(block->error());
      if (!take(**block)) return {};
      used.put(std::move(**block));
    }
    return {};
  }

  // The seq of the first block that reaches t_ns; t_ns is at most end_ns.
  [[nodiscard]] Result<std::int64_t> block_of(std::int64_t t_ns) {
    std::int64_t low = first_block, high = last_block;
    while (low < high) {
      const std::int64_t middle = low + (high - low) / 2;
      const auto row = find(middle, "stream");
      if (!row) return tl::unexpected(row.error());
      if (!row->has_value() || (*row)->entry.t_ns >= t_ns || (*row)->entry.seq >= high) {
        high = middle;
      } else {
        low = (*row)->entry.seq + 1;
      }
    }
    return low;
  }
};

RunReader::RunReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
RunReader::RunReader(RunReader&&) noexcept = default;
RunReader& RunReader::operator=(RunReader&&) noexcept = default;
RunReader::~RunReader() = default;

Result<RunReader> RunReader::open(const std::string& path) {
  auto chain = ChainReader::open(path, ChainSort::run);
  if (!chain) return tl::unexpected(chain.error());
  std::unique_ptr<Impl> impl(new Impl{.path = path, .chain = std::move(*chain)});
  if (const auto read = impl->read_header(); !read) return tl::unexpected(read.error());
  if (const auto read = impl->read_bounds(); !read) return tl::unexpected(read.error());
  if (const auto read = impl->read_label(); !read) return tl::unexpected(read.error());
  return RunReader(std::move(impl));
}

const RunHeader& RunReader::header() const noexcept { return impl_->header; }
const std::optional<RunEnd>& RunReader::end() const noexcept { return impl_->end; }
std::int64_t RunReader::begin_ns() const noexcept { return impl_->begin_ns; }
std::int64_t RunReader::end_ns() const noexcept { return impl_->end_ns; }

std::optional<double> RunReader::span_s() const noexcept {
  const bool child = impl_->header.is_child();
  const std::int64_t from_ns = child ? impl_->header_ns : impl_->begin_ns;
  const std::int64_t to_ns = child ? impl_->ended_ns.value_or(from_ns) : impl_->end_ns;
  if (to_ns <= from_ns) return std::nullopt;
  return 1e-9 * (static_cast<double>(to_ns) - static_cast<double>(from_ns));
}

std::string RunReader::ended_utc() const {
  const auto began_ns = parse_utc(header().start_utc);
  if (!began_ns) return {};
  return iso_utc(*began_ns + static_cast<std::int64_t>(1e9 * span_s().value_or(0.0)));
}

Result<void> RunReader::blocks(const TakeBlock& take) { return impl_->blocks(1, take); }

Result<void> RunReader::blocks_from(std::int64_t t_ns, const TakeBlock& take) {
  if (t_ns > impl_->end_ns) return {};
  const auto seq = impl_->block_of(t_ns);
  if (!seq) return tl::unexpected(seq.error());
  return impl_->blocks(*seq, take);
}

Result<void> RunReader::results(bool finals, const std::function<bool(const StoredResult&)>& take) {
  return impl_->each(1, "result", [&](const Entry& entry) -> Result<bool> {
    if (finals && is_written_as_not_final(entry.body)) return true;
    const auto result = parse_result(entry.body);
    if (!result) return tl::unexpected(result.error());
    return (finals && !result->final) || take(*result);
  });
}

Result<void> RunReader::dwells(const std::function<bool(const StoredResult&)>& take) {
  std::string newest;  // the body of a result that is not final, after the last final one
  bool more = true;
  const auto read = impl_->each(1, "result", [&](const Entry& entry) -> Result<bool> {
    newest = entry.body;
    if (is_written_as_not_final(entry.body)) return true;
    const auto result = parse_result(entry.body);
    if (!result) return tl::unexpected(result.error());
    if (!result->final) return true;
    newest.clear();
    return more = take(*result);
  });
  if (!read || !more || newest.empty()) return read;
  const auto result = parse_result(newest);
  if (!result) return tl::unexpected(result.error());
  (void)take(*result);
  return {};
}

Result<void> RunReader::events(const std::function<bool(const StoredEvent&)>& take) {
  return impl_->each(1, "event", [&](const Entry& entry) -> Result<bool> {
    const auto event = parse_event(entry.body);
    if (!event) return tl::unexpected(event.error());
    return take(*event);
  });
}

Result<void> RunReader::models(const std::function<bool(const StoredModel&)>& take) {
  bool more = true;
  for (const char* const kind : {"estimate", "verification"}) {
    const auto read = impl_->each(1, kind, [&](const Entry& entry) -> Result<bool> {
      const auto model = parse_model(kind, entry.body);
      if (!model) return tl::unexpected(model.error());
      return more = take(*model);
    });
    if (!read || !more) return read;
  }
  return {};
}

Result<std::vector<PersonalSignature>> RunReader::signatures() {
  std::vector<PersonalSignature> signatures;
  const auto read = impl_->each(impl_->last_block, "signature", [&](const Entry& entry) -> Result<bool> {
    auto signature = parse_personal_signature(entry.body);
    if (!signature) return tl::unexpected(signature.error());
    if (signatures.size() == kMostSignatures)
      return tl::unexpected("signature " + std::to_string(kMostSignatures + 1) + ": at most " +
                            std::to_string(kMostSignatures) + " are read");
    signatures.push_back(std::move(*signature));
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  return signatures;
}

}  // namespace dwell::record
