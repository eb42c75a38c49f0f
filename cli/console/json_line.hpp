#pragma once
// A JSON document as the one line that `--json` prints.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace musher::cli {

using Json = nlohmann::ordered_json;  // keys in the order they are written

// Bytes that are not UTF-8 become U+FFFD.
std::string JsonLine(const Json& json);

}  // namespace musher::cli
