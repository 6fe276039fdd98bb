// The alarms of the service: what is wrong and lasts, and whether an operator knows of it. States and transitions are
// those of ISA-18.2 (EEMUA 191):
//
//   normal ──lasts──> unacknowledged ──acknowledge──> acknowledged ──gone──> normal
//                        │      ^
//                       gone  lasts
//                        v      │
//                  returned, unacknowledged ──acknowledge──> normal
//
// What comes and goes adds up (kLasts_ns, kFade, kGone_ns) and is one alarm with a count. Pure: instants are given by
// the caller. What is wrong is not decided here but by judge_health().
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
// Where an input changes nothing: the state itself.
[[nodiscard]] AlarmState next(AlarmState state, AlarmInput input) noexcept;

// One that is not normal.
struct Alarm {
  std::string name;  // as the trouble's
  std::string text;  // of the trouble as it is now, or as it was last
  AlarmState state = AlarmState::normal;
  std::int64_t since_utc_ns = 0;    // raised first
  std::int64_t changed_utc_ns = 0;  // when it came to its state
  std::uint64_t count = 0;          // times raised since then
  std::string acknowledged_by;      // "anna (uid 1000)"
  std::string comment;              // of that; empty: none
};

struct AlarmChange {
  AlarmState before = AlarmState::normal;
  Alarm alarm;  // as it is now; normal: no longer in the list
};

// Bound to one thread.
class AlarmList {
 public:
  // A trouble must last so long before it is an alarm. The channels of one device fail and come back within its timeout
  // of each other: shorter, a dead device would be an alarm for each of them as well. Longer: operators learn later.
  static constexpr std::int64_t kLasts_ns = 1'000'000'000;
  // What has lasted is not forgotten at once: while the trouble is absent, it fades so many times slower than it grew.
  // A trouble that comes and goes is thus an alarm where it is there for more than 1/(1 + kFade) of the time, here a
  // fifth. Larger: the channels of a device that flaps, stale for a tenth of the time, would be alarms as well.
  static constexpr std::int64_t kFade = 4;
  // An alarm returns once its trouble was absent for so long. Shorter: one that flaps is told over and over.
  static constexpr std::int64_t kGone_ns = kLasts_ns;
  // Alarms at a time; nobody reads more. Further ones are counted, and enter where there is room again.
  static constexpr std::size_t kMost = 200;

  // What is wrong now. Returns the changes to be told: of an alarm that flaps without anybody having acknowledged it
  // only that it was raised and that it first returned.
  std::vector<AlarmChange> follow(const std::vector<Trouble>& troubles, const record::ClockPair& now);
  // Fails with the reason why there is nothing to acknowledge.
  tl::expected<AlarmChange, std::string> acknowledge(const std::string& name, const std::string& by,
                                                     const std::string& comment, const record::ClockPair& now);

  // Unacknowledged, then returned, then acknowledged ones; of each the newest first.
  [[nodiscard]] std::vector<Alarm> alarms() const;
  [[nodiscard]] std::size_t count(AlarmState state) const noexcept;
  // Those that wait for somebody: unacknowledged and returned.
  [[nodiscard]] std::size_t unacknowledged() const noexcept;
  // Troubles that last and found no room.
  [[nodiscard]] std::size_t left_out() const noexcept { return left_out_; }

 private:
  std::optional<AlarmChange> raise(const Trouble& trouble, const record::ClockPair& now);

  std::map<std::string, Alarm> alarms_;  // by name; none is normal
  // How long a trouble has lasted, less what has faded since; at most kLasts_ns.
  struct Lasting {
    std::int64_t lasted_ns = 0;
    std::int64_t seen_ns = 0;  // the last look that found it, raw clock
    bool present = false;      // now
  };
  void weigh(const std::vector<Trouble>& troubles, std::int64_t raw_ns);

  std::map<std::string, Lasting> lasting_;  // by name; what has faded wholly and is absent is not held
  std::int64_t looked_ns_ = 0;              // the last look, raw clock
  std::size_t left_out_ = 0;
};

}  // namespace dwell
