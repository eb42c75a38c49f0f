#pragma once
// Numbers and points in messages. Pure.

#include <Eigen/Core>
#include <cstdio>
#include <string>

namespace musher::world {

inline std::string NumberText(double number) {
  char text[32];
  std::snprintf(text, sizeof(text), "%g", number);
  return text;
}

// "1.23"
inline std::string MetresText(double metres) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", metres);
  return text;
}

// "(1.00 m, -2.50 m)"
inline std::string PointText(const Eigen::Vector2d& point_m) {
  return "(" + MetresText(point_m.x()) + " m, " + MetresText(point_m.y()) + " m)";
}

}  // namespace musher::world
