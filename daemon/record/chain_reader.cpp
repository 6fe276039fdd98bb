#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/chain_tables.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {

struct ChainReader::Impl {
  Impl(Snapshot&& of, ChainSort sort) : snapshot(std::move(of)), rows(snapshot.database(), sort) {}

  Snapshot snapshot;
  ChainRows rows;
  bool at_end = false;
};

ChainReader::ChainReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ChainReader::ChainReader(ChainReader&&) noexcept = default;
ChainReader& ChainReader::operator=(ChainReader&&) noexcept = default;
ChainReader::~ChainReader() = default;

Result<ChainReader> ChainReader::open(const std::string& path, ChainSort sort) {
  Result<Snapshot> snapshot = Snapshot::open(path);
  if (!snapshot) return tl::unexpected(std::move(snapshot.error()));
  if (Result<void> tables = check_tables(snapshot->database(), sort); !tables)
    return fails(snapshot->unchanged() ? Failure(path + ": " + tables.error()) : read_again(path + ": "));
  return ChainReader(std::make_unique<Impl>(std::move(*snapshot), sort));
}

Result<std::optional<ChainReader::Row>> ChainReader::next() {
  if (impl_->at_end) return std::nullopt;
  Result<std::optional<Row>> row = impl_->rows.next();
  if (!impl_->snapshot.unchanged()) return fails(read_again(impl_->snapshot.path() + ": "));
  if (!row) return tl::unexpected(impl_->snapshot.path() + ": " + row.error());
  impl_->at_end = !row->has_value();
  return row;
}

const std::string& ChainReader::altered() const noexcept { return impl_->snapshot.altered(); }

void ChainReader::seek(std::int64_t seq, const std::string& kind) {
  impl_->rows.seek(seq, kind);
  impl_->at_end = false;
}

}  // namespace dwell::record
