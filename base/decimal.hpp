#pragma once
// Numbers in a sentence. Pure; from any thread.

#include <iomanip>
#include <sstream>
#include <string>

namespace musher {

// "1.50" of 1.5 with 2 `digits` after the point.
inline std::string Decimal(double value, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return text.str();
}

}  // namespace musher
