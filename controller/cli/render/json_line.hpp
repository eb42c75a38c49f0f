#pragma once
// A JSON document as the one line that `--json` prints.

#include <nlohmann/json.hpp>
#include <string>

namespace musher::cli {

using Json = nlohmann::ordered_json;  // keys in the order they are written

// Bytes that are not UTF-8 become U+FFFD.
inline std::string JsonLine(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace musher::cli
