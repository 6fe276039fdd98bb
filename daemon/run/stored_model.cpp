#include "daemon/run/stored_model.hpp"

#include <type_traits>
#include <utility>

#include "daemon/report/model_entry.hpp"

namespace dwell {

record::StoredModel stored_model(const record::ModelResult& result, const Rig& rig) {
  return std::visit(
      [&](const auto& of) {
        constexpr bool is_estimate = std::is_same_v<std::decay_t<decltype(*of)>, TransientEstimate>;
        ModelEntry entry = model_entry(*of, rig);
        return record::StoredModel{
            is_estimate ? "estimate" : "verification", 0, {}, std::move(entry.from), std::move(entry.result)};
      },
      result);
}

}  // namespace dwell
