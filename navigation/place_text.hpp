#pragma once
// Places and distances as messages to people have them, also those that no map has: "(1.00, 2.50)",
// "(1e+308, 0.00)".

#include <string>

#include "musher/navigation/pose.hpp"

namespace musher::navigation {

std::string MetresText(double metres);

// `flat`: without the height.
std::string PlaceText(const Point& place, bool flat);

}  // namespace musher::navigation
