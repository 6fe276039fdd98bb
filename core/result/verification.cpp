#include "core/result/verification.hpp"

namespace dwell {

const char* to_string(Verdict verdict) noexcept {
  switch (verdict) {
    case Verdict::adequate:
      return "adequate";
    case Verdict::not_adequate:
      return "not adequate";
    case Verdict::not_verified:
      return "not verified yet";
  }
  return "";
}

ModelVerdict in_short(const Verification& v) noexcept { return {v.verdict, v.consistent, v.accuracy, v.seen, v.U, {}}; }

}  // namespace dwell
