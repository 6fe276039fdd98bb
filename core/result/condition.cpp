#include "core/result/condition.hpp"

namespace dwell {

const char* to_string(Condition condition) noexcept {
  switch (condition) {
    case Condition::unheard:
      return "unheard";
    case Condition::ok:
      return "ok";
    case Condition::gated:
      return "gated";
    case Condition::overrange:
      return "overrange";
    case Condition::held:
      return "held";
    case Condition::clipped:
      return "clipped";
    case Condition::stuck:
      return "stuck";
  }
  return "?";
}

}  // namespace dwell
