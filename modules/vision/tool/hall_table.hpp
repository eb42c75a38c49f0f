#pragma once
// Changes the table [hall] of a config of the vision module: the lines of keys that it has are
// replaced, others are added. All else of the file stays, comments included. Pure.
//
// Threads: any. Errors: what cannot be changed line by line is named, a key over several lines.

#include <string>
#include <vector>

#include "musher/base/result.hpp"

namespace musher::vision::tool {

// A key of [hall], dotted for one of a table in it, and its value: "red", "{ from = … }".
struct HallKey {
  std::string key;
  std::string value;
};

struct HallChange {
  std::string text;                 // of the file
  std::vector<std::string> before;  // the lines that were replaced
};
Result<HallChange> WithHallKeys(const std::string& text, const std::vector<HallKey>& keys);

}  // namespace musher::vision::tool
