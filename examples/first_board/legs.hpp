#pragma once
// The robot's own interface. On a real robot these functions call its library; here there is no
// robot, and they compute what its body would do.

#include <cmath>

#include "musher/base/time.hpp"

struct Legs {
  double x_m = 0, y_m = 0, yaw_rad = 0;  // its odometry
  double height_m = 0;                   // 0: it lies
  double forwards_m_s = 0, left_m_s = 0, turn_rad_s = 0;
  double wanted_height_m = 0;
  bool powered = true;  // as a robot may be found

  void Power(bool on) { powered = on; }
  // The body rises or sinks to that height, which takes a second or two.
  void Stand(double height) { wanted_height_m = height; }
  void Walk(double forwards, double left, double turn) {
    forwards_m_s = forwards;
    left_m_s = left;
    turn_rad_s = turn;
  }
  bool Arrived() const { return std::abs(height_m - wanted_height_m) < 1e-3; }

  void Advance(musher::Duration time) {
    const double s = musher::ToSeconds(time);
    if (!powered) Walk(0, 0, 0);
    const double sinks = 0.2 * s;
    const double way = (powered ? wanted_height_m : 0) - height_m;
    height_m += std::fmin(std::fmax(way, -sinks), sinks);
    yaw_rad += turn_rad_s * s;
    x_m += (forwards_m_s * std::cos(yaw_rad) - left_m_s * std::sin(yaw_rad)) * s;
    y_m += (forwards_m_s * std::sin(yaw_rad) + left_m_s * std::cos(yaw_rad)) * s;
  }
};
