// Compares what a replay gives with what its run file holds, at the position of each stored result.
#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <string>
#include <vector>

#include "daemon/ctl/replay.hpp"
#include "daemon/ctl/result_comparison.hpp"
#include "daemon/ctl/stored_results.hpp"

namespace dwell::ctl {

// A difference, and the result that it is in.
struct Finding {
  std::uint64_t position = 0;
  bool final = false;
  std::string dwell;  // the index as stored, "none" while idle
  Difference difference;
};

struct ReplayFindings {
  static constexpr std::size_t kListed = 1000;  // findings kept at most

  std::uint64_t results = 0, finals = 0;  // compared
  std::uint64_t numbers = 0;              // in them
  std::uint64_t different = 0;            // of the numbers and other members
  std::uint64_t intolerable = 0;          // of these, beyond the tolerance for another build
  Finding largest;                        // the tolerable one with the largest `in_u`
  std::vector<Finding> listed;            // the first kListed: first those beyond the tolerance, then the others
  std::vector<std::string> notes;         // what could not be compared, and why that is no difference

  [[nodiscard]] bool identical() const noexcept { return different == 0; }
};

// Bound to one thread. The comparisons, half as much work as the replay, are done on another one meanwhile.
class ReplayCheck {
 public:
  // The JSON object of a dwell as the recording service wrote it. Called on that other thread.
  using ToJson = std::function<std::string(const Dwell&)>;

  // closed: the run has ended, so that nothing may be missing. In one that was cut off, results at its very end may be
  // stored without their records, and the other way round.
  ReplayCheck(StoredResults stored, ToJson to_json, bool closed)
      : stored_(std::move(stored)), to_json_(std::move(to_json)), closed_(closed) {}

  ReplayCheck(const ReplayCheck&) = delete;
  ReplayCheck& operator=(const ReplayCheck&) = delete;

  // After each record that the replay has taken.
  void follow(const Replay& replay) {
    const StoredResults::Entry* const next = stored_.now();
    if ((next != nullptr && next->position <= replay.position()) || !replay.ended().empty()) look(replay);
  }
  // After the last one. Fails where the results could not be read to their end.
  [[nodiscard]] record::Result<ReplayFindings> finish();

 private:
  static constexpr std::size_t kTogether = 32;  // comparisons handed over at once: bounds the dwells that wait

  // Does this after all that was put off before, on the other thread.
  void later(std::function<void()> work);
  void hand_over();
  void look(const Replay& replay);
  void compare(const StoredResults::Entry& stored, const std::string& replayed);
  // In a result as it is stored.
  void find(const StoredResults::Entry& stored, Difference difference);
  void find(Finding finding);

  StoredResults stored_;
  ToJson to_json_;
  bool closed_;
  std::vector<std::function<void()>> put_off_;
  // Of the other thread, until it is done.
  std::vector<Finding> tolerable_;
  ReplayFindings findings_;
  std::future<void> work_;  // last: waits for that thread before the rest goes
};

}  // namespace dwell::ctl
