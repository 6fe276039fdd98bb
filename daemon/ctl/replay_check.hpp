// Compares the results of a replay with those stored in the run file, each at its position.
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
  std::string dwell;  // the index as stored, "none" while idle; empty: it is no result of a dwell but what `what` names
  Difference difference;
};

struct ReplayFindings {
  static constexpr std::size_t kListed = 1000;  // findings kept at most

  std::uint64_t results = 0, finals = 0;           // compared
  std::uint64_t numbers = 0;                       // in them
  std::uint64_t events = 0;                        // compared; child file: all, run: changes of state only
  std::uint64_t estimates = 0, verifications = 0;  // compared
  std::uint64_t different = 0;                     // of the numbers and other members
  std::uint64_t intolerable = 0;                   // of these, beyond the tolerance for another build
  Finding largest;                                 // the tolerable one with the largest `in_u`
  std::vector<std::string> notes;                  // what could not be compared, and why that is no difference

  [[nodiscard]] bool identical() const noexcept { return different == 0; }
  void add(Finding finding);
  // What was added, those beyond the tolerance first. kListed at most.
  [[nodiscard]] std::vector<Finding> listed() const;

 private:
  std::vector<Finding> beyond_, tolerable_;  // the first kListed of each
};

// Bound to one thread. Computes the coefficients of each result and compares on a second thread, since that takes half
// as long as the replay. The replay must outlive it.
class ReplayCheck {
 public:
  // The JSON object of a dwell as the recording service wrote it. Called on the second thread.
  using ToJson = std::function<std::string(const Dwell&)>;

  // closed: the run has ended, so nothing may be missing. At the very end of a run that was cut off, results may be
  // stored without their records, or records without their results.
  ReplayCheck(StoredResults stored, ToJson to_json, bool closed)
      : stored_(std::move(stored)), to_json_(std::move(to_json)), closed_(closed) {}

  ReplayCheck(const ReplayCheck&) = delete;
  ReplayCheck& operator=(const ReplayCheck&) = delete;

  // How many records the replay may take before follow() must be called.
  [[nodiscard]] std::uint64_t free_until(const Replay& replay) const noexcept {
    const StoredResults::Entry* const next = stored_.now();
    if (next == nullptr) return UINT64_MAX;
    return next->position > replay.position() ? next->position - replay.position() - 1 : 0;
  }
  // Call after each record that the replay has taken, except for so many samples and ticks as free_until() says.
  void follow(const Replay& replay) {
    const StoredResults::Entry* const next = stored_.now();
    if ((next != nullptr && next->position <= replay.position()) || !replay.ended().empty()) look(replay);
  }
  // Call after the last record. Fails if the results could not be read to their end.
  [[nodiscard]] record::Result<ReplayFindings> finish();

 private:
  static constexpr std::size_t kTogether = 32;  // comparisons handed over at once: bounds how many dwells wait

  // Does `work` on the second thread, after everything put off before.
  void later(std::function<void()> work);
  void hand_over();
  void look(const Replay& replay);
  void compare(const StoredResults::Entry& stored, const std::string& replayed);
  // Adds a difference in a stored result.
  void find(const StoredResults::Entry& stored, Difference difference);

  StoredResults stored_;
  ToJson to_json_;
  bool closed_;
  std::uint64_t results_ = 0, finals_ = 0;  // looked at
  std::vector<std::function<void()>> put_off_;
  ReplayFindings findings_;  // the second thread's until it is done
  std::future<void> work_;   // last: waits for that thread before the rest goes
};

}  // namespace dwell::ctl
