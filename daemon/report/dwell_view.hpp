// A dwell together with what its numbers need to be read: the channels' names, every unit, the run it belongs to.
//
// It is made either from the pipeline's Dwell and its Rig, or from the JSON object of the public interface; the tables
// for people and the JSON are both made from it, so they cannot disagree.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/units.hpp"
#include "core/result/dwell.hpp"
#include "core/result/moved.hpp"
#include "core/result/verification.hpp"
#include "core/rig/limit.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// What all dwells of a run have in common. An empty string: not known.
struct RunInfo {
  std::string rig_sha256;  // of the rig file, hexadecimal
  std::string version;     // of the program that computed
  std::string start_utc;   // ISO 8601, of t = 0 on the run's axis
};

struct ChannelLabel {
  std::string name;
  std::string unit;  // SI, as in the JSON: "m/s2", "N*m"; of an auxiliary channel as in the rig file
};

struct MotionView;  // daemon/report/motion_report.hpp

// How old a live dwell was when the service told it.
struct LiveAge {
  double s = kNaN;     // since the estimation published it, s; not finite: it has published nothing
  bool stale = false;  // the service's judgement: nothing of the dwell is known to be true now
};

// The change of a live dwell's coefficients since the settled dwell before it.
struct SinceBefore {
  int index = 0;          // of the dwell before …
  std::string start_utc;  // … its run's t = 0, ISO 8601 …
  double end_s = kNaN;    // … and its end on that run's axis
  std::vector<ElementMove> elements = {};
};

struct DwellView {
  Motion motion = Motion::translation;
  std::vector<ChannelLabel> channels;  // one per Dwell::phasors
  RunInfo run;
  Dwell dwell;
  // Of a live dwell: its coefficients by any motion, whose `reason` says why there are none; null: nothing is
  // known of it.
  std::shared_ptr<const MotionView> transient = nullptr;
  // Of a live dwell that has settled and is not stale; of a finished one, as far as its service knows.
  std::optional<ModelVerdict> model = std::nullopt;
  std::vector<JudgedLimit> limits = {};       // the rig's, by this dwell's coefficients
  std::optional<LiveAge> age = std::nullopt;  // of a live dwell
  // Of a live dwell that is measured; nullopt: no settled dwell before it is known.
  std::optional<SinceBefore> since = std::nullopt;
};

// Units as the JSON writes them (ASCII).
using config::damping_unit;
using config::stiffness_unit;

// Labels of all channels of a rig, in its order.
[[nodiscard]] std::vector<ChannelLabel> channel_labels(const Rig& rig);

// limits: the rig's, judged. Without: by judge_limits(). Thread-safe; allocates.
[[nodiscard]] DwellView make_view(const Dwell& dwell, const Rig& rig, const RunInfo& run,
                                  std::vector<JudgedLimit> limits);
[[nodiscard]] DwellView make_view(const Dwell& dwell, const Rig& rig, const RunInfo& run);

}  // namespace dwell
