// A run file of a simulated rig, made as the service makes it: the stream through a Measurement, what it publishes with
// its position, all of it through a ChainWriter.
#pragma once

#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/model/chain.hpp"
#include "core/model/driven_chain.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::test {

// What a chain is and does, in SI, and how it is measured: a displacement of the table and of each mass, on a clamped
// chain the reaction.
struct SimulatedRig {
  Chain chain;
  double frequency_hz = 5.0;
  double rate_hz = 200.0;
  double noise = 1e-6;  // m; of the reaction, as much force as the last element takes for it

  // The rig file; mass_scale: of every mass stated there.
  [[nodiscard]] std::string rig_text(double mass_scale = 1.0) const;
  [[nodiscard]] static SimulatedRig random(std::mt19937_64& rng);
};

// Builds the ordered stream of a run, record by record, on a raw clock that begins somewhere.
class StreamBuilder {
 public:
  StreamBuilder(const SimulatedRig& rig, const Drive& drive, std::uint64_t seed);

  // Scans and ticks every 10 ms until t_s from the begin of the run.
  void run_to(double t_s);
  void set_drive(const Drive& drive) { motion_.set_drive(now_s_, drive); }
  void add(Kind kind, std::uint16_t channel, std::uint8_t flags, double value = 0.0);
  // The channel delivers nothing from now on, or again.
  void lose(std::uint16_t channel);
  void find(std::uint16_t channel);
  // The run ends.
  [[nodiscard]] std::vector<Record> end();
  // It is cut off.
  [[nodiscard]] std::vector<Record> cut_off() const { return records_; }

 private:
  [[nodiscard]] std::int64_t now_ns() const;
  void scan();

  const SimulatedRig& rig_;
  DrivenChain motion_;
  std::mt19937_64 rng_;
  std::int64_t scans_ = 0;
  double now_s_ = 0.0;
  std::vector<bool> lost_, gap_;
  std::vector<Record> records_;
};

// Two holds, the drive stopped between or changed, an operator's rearm, an interlock that opens, a channel lost for a
// while, records that no pipeline evaluates; which of it, where and how long, is drawn.
[[nodiscard]] std::vector<Record> eventful_stream(const SimulatedRig& rig, std::mt19937_64& rng);

// What may be done to a run file on its way to the disk.
struct Changes {
  std::function<void(record::RunHeader&)> header = {};
  std::function<bool(record::StoredResult&)> result = {};      // false: it is left out
  std::function<bool(record::StoredEvent&)> state_event = {};  // likewise, of a change of state
  // Likewise, of an estimate or a verification; none: neither is made.
  std::function<bool(record::StoredModel&)> model = {};
  bool without_end = false;
  double every_s = 0.25;  // between two results, on the stream
  bool commits = false;   // each block is committed and signed by itself, as the service does; else all at once
};

struct WrittenRun {
  record::RunHeader header;
  int results = 0, finals = 0;
  int settled = 0;                    // finals with coefficients
  std::vector<std::uint64_t> states;  // positions of the changes of state
  int estimates = 0, verifications = 0;
  int busy = 0;  // records at which a result was due and long work was going on
};
// Writes the run at `path`.
WrittenRun write_run(const std::string& path, const std::string& rig_text, const std::vector<Record>& stream,
                     const Changes& changes = {});

}  // namespace dwell::test
