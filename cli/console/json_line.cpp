#include "musher/cli/console/json_line.hpp"

#include <nlohmann/json.hpp>

namespace musher::cli {

std::string JsonLine(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace musher::cli
