#pragma once
// A JSON document as the one line that `--json` prints.

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace musher::cli {

using OrderedJson = nlohmann::ordered_json;  // keys in the order they are written

// What is not known, or is none: null for an empty text, and for a number that is 0 then (a pid,
// the number of a switch). Texts for people (`message`, `reason`) stay texts.
OrderedJson Known(const std::string& text);
OrderedJson Known(int number);
OrderedJson Known(std::uint32_t number);
OrderedJson Known(std::int64_t number);
OrderedJson Known(std::uint64_t number);

// Bytes that are not UTF-8 become U+FFFD.
std::string JsonLine(const OrderedJson& json);

}  // namespace musher::cli
