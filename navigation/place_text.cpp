#include "musher/navigation/place_text.hpp"

#include <fmt/format.h>

#include <cmath>

namespace musher::navigation {

std::string MetresText(double metres) {
  return std::abs(metres) < 1e6 ? fmt::format("{:.2f}", metres) : fmt::format("{:.3g}", metres);
}

std::string PlaceText(const Point& place, bool flat) {
  std::string text = "(" + MetresText(place.x_m) + ", " + MetresText(place.y_m);
  if (!flat) text += ", " + MetresText(place.z_m);
  return text + ")";
}

}  // namespace musher::navigation
