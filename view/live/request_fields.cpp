#include "musher/view/live/request_fields.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/base/suggest.hpp"
#include "musher/view/json/json.hpp"

namespace musher::view {
namespace {

// What the requests have in common. The time is checked with the age of a request.
const std::vector<std::string> kCommonFields = {"machine", "machine_id", "seen_uptime_ms"};

// Of a path that is checked; empty: it is not.
std::vector<std::string> FieldsOf(std::string_view path) {
  if (path == "/api/plan" || path == "/api/set") return {"target", "actuator"};
  if (path == "/api/restart") return {"actuator"};
  if (path == "/api/release") return {"stop_ids"};
  if (path == "/api/skill") return {"action", "actuator", "skill", "parameters"};
  return {};
}

// What the value of the field has to be; null: it is.
const char* WhyWrong(std::string_view field, const Json& value) {
  if (field == "seen_uptime_ms") return nullptr;
  if (field == "parameters") return value.is_object() ? nullptr : "an object";
  if (field != "stop_ids") return value.is_string() ? nullptr : "a text";
  const bool texts =
      value.is_array() &&
      std::all_of(value.begin(), value.end(), [](const Json& one) { return one.is_string(); });
  return texts ? nullptr : "a list of texts";
}

}  // namespace

Result<> CheckFields(std::string_view path, const nlohmann::json& body) {
  std::vector<std::string> fields = FieldsOf(path);
  if (fields.empty()) return Ok();
  fields.insert(fields.end(), kCommonFields.begin(), kCommonFields.end());
  for (const auto& [name, value] : body.items()) {
    if (std::ranges::count(fields, name) == 0) {
      return Error{kCodeParametersInvalid, NoSuch("field", name, fields) + ". Nothing was done"};
    }
    if (const char* const wanted = WhyWrong(name, value)) {
      return Error{kCodeParametersInvalid,
                   "the field '" + name + "' has to be " + wanted + ". Nothing was done"};
    }
  }
  return Ok();
}

}  // namespace musher::view
