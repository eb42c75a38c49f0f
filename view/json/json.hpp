#pragma once
// JSON in the programs of view/; for sources only.

#include <nlohmann/json.hpp>
#include <string>

namespace musher::view {

// Read from others: its objects are sorted, so that many members cost no quadratic time.
using Json = nlohmann::json;
// Written for others: an object keeps the order in which its members were added.
using OrderedJson = nlohmann::ordered_json;

// In one line. Bytes that are not UTF-8 are replaced.
inline std::string Dumped(const OrderedJson& json) {
  return json.dump(-1, ' ', false, OrderedJson::error_handler_t::replace);
}

}  // namespace musher::view
