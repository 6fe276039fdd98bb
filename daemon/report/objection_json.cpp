#include "daemon/report/objection_json.hpp"

#include "daemon/report/json_reader.hpp"

namespace dwell {

using namespace json_reader;

Json json_objection(const TransientEstimate& of) {
  if (!of.dwell || of.objection.empty()) return nullptr;
  return {{"dwell", *of.dwell}, {"what", of.objection}};
}

tl::expected<std::optional<StoredObjection>, std::string> objection_in(const Json& result) {
  if (!result.is_object()) return tl::unexpected<std::string>("result: expected an object");
  const auto found = result.find("objection");
  if (found == result.end() || found->is_null()) return std::nullopt;
  try {
    return StoredObjection{integer(member(*found, "dwell"), "dwell"), string_of(*found, "what")};
  } catch (const Mistake& mistake) {
    return tl::unexpected<std::string>(std::string("objection: ") + mistake.what());
  }
}

}  // namespace dwell
