// The alarms of the service: troubles that last, and whether an operator knows of them. States and transitions are
// those of ISA-18.2 (EEMUA 191):
//
//   normal ──lasts──> unacknowledged ──acknowledge──> acknowledged ──gone──> normal
//                        │      ^
//                       gone  lasts
//                        v      │
//                  returned, unacknowledged ──acknowledge──> normal
//
// A trouble that comes and goes adds up (kLasts_ns, kFade, kGone_ns) and is one alarm with a count. Pure: the caller
// gives the instants. judge_health() alone decides what is wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/health.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell {

enum class AlarmState : std::uint8_t { normal, unacknowledged, acknowledged, returned };
[[nodiscard]] const char* to_string(AlarmState state) noexcept;  // returned: "returned-unacknowledged"

enum class AlarmInput : std::uint8_t { lasts, gone, acknowledge };
// The state after an input; the same state where the input changes nothing.
[[nodiscard]] AlarmState next(AlarmState state, AlarmInput input) noexcept;

struct Alarm {
  std::string name;  // the trouble's
  std::string text;  // the trouble's newest
  AlarmState state = AlarmState::normal;
  std::int64_t since_utc_ns = 0;    // when it was raised first; ns since 1970
  std::int64_t changed_utc_ns = 0;  // when it entered its state
  std::uint64_t count = 0;          // times it was raised since since_utc_ns
  std::string acknowledged_by;      // who acknowledged it last, "anna (uid 1000)"; empty: nobody
  std::string comment;              // with that acknowledgement; empty: none
};

struct AlarmChange {
  AlarmState before = AlarmState::normal;
  Alarm alarm;  // after the change; normal: it has left the list
};

// Bound to one thread.
class AlarmList {
 public:
  // A trouble must last so long to be an alarm. The channels of a dead device fail one after the other, within its
  // timeout. Shorter: each of them would be an alarm as well. Longer: operators learn of it later.
  static constexpr std::int64_t kLasts_ns = 1'000'000'000;
  // While a trouble is absent, the time that it has lasted fades so many times slower than it grew. So a trouble that
  // comes and goes is an alarm where it is present for more than 1/(1 + kFade) of the time, a fifth. Larger: the
  // channels of a device that flaps, stale for a tenth of the time, would be alarms as well. Smaller: a device that is
  // dead for much of the time would never be one.
  static constexpr std::int64_t kFade = 4;
  // An alarm returns once its trouble was absent for so long. Shorter: one that flaps is told over and over. Longer: it
  // stays after its trouble is over.
  static constexpr std::int64_t kGone_ns = kLasts_ns;
  // Alarms at a time; nobody reads more. Further ones are counted, and enter once there is room.
  static constexpr std::size_t kMost = 200;

  // troubles: all that is wrong now. unknown: what nobody can judge now; its time stands still, and its active alarm
  // stays, with this text. Returns the changes that are to be told. An alarm that flaps, and that nobody acknowledges,
  // is told when it is first raised and when it first returns.
  std::vector<AlarmChange> follow(const std::vector<Trouble>& troubles, const std::vector<Trouble>& unknown,
                                  const record::ClockPair& now);
  // by: who, for people to read; comment: empty: none. Fails with the reason why there is nothing to acknowledge.
  tl::expected<AlarmChange, std::string> acknowledge(const std::string& name, const std::string& by,
                                                     const std::string& comment, const record::ClockPair& now);

  // All that are not normal: unacknowledged, then returned, then acknowledged ones; of each the newest first.
  [[nodiscard]] std::vector<Alarm> alarms() const;
  [[nodiscard]] std::size_t count(AlarmState state) const noexcept;
  // Those that wait for somebody: unacknowledged or returned.
  [[nodiscard]] std::size_t unacknowledged() const noexcept;
  // Troubles that last and found no room.
  [[nodiscard]] std::size_t left_out() const noexcept { return left_out_; }

 private:
  // What is remembered of a trouble. Instants on CLOCK_MONOTONIC_RAW.
  struct Lasting {
    std::int64_t lasted_ns = 0;  // how long it has lasted, less what has faded; at most kLasts_ns
    std::int64_t seen_ns = 0;    // the last follow() that found it, plus the time since then when it was unknown
    bool present = false;        // that follow() was the last one
  };
  std::optional<AlarmChange> raise(const Trouble& trouble, const record::ClockPair& now);
  // Brings lasting_ up to date.
  void weigh(const std::vector<Trouble>& troubles, const std::vector<Trouble>& unknown, std::int64_t raw_ns);

  std::map<std::string, Alarm> alarms_;     // by name; none is normal
  std::map<std::string, Lasting> lasting_;  // by name; forgotten once wholly faded and absent for kGone_ns
  std::int64_t looked_ns_ = 0;              // the last follow()
  std::size_t left_out_ = 0;
};

}  // namespace dwell
