#include "musher/cli/console/json_line.hpp"

#include <nlohmann/json.hpp>

namespace musher::cli {

Json Known(const std::string& text) {
  return text.empty() ? Json() : Json(text);
}

Json Known(int number) {
  return number == 0 ? Json() : Json(number);
}

Json Known(std::uint32_t number) {
  return number == 0 ? Json() : Json(number);
}

Json Known(std::int64_t number) {
  return number == 0 ? Json() : Json(number);
}

Json Known(std::uint64_t number) {
  return number == 0 ? Json() : Json(number);
}

std::string JsonLine(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace musher::cli
