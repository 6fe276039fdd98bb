// The entries `estimate` and `verification` of a run file: docs/run-file.md. Thread-safe; allocates.
#pragma once

#include "core/rig/rig.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/stream_sink.hpp"

namespace dwell {

// Kind, stretch and result; the recorder fills in position and instant.
[[nodiscard]] record::StoredModel stored_model(const record::ModelResult& result, const Rig& rig);

}  // namespace dwell
