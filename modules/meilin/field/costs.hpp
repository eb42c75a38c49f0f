#pragma once
// How long a robot needs for the steps of a plan, in seconds: estimates of the competition's teams,
// by which plans are compared. Pure values.

#include "musher/modules/meilin/field/grid.hpp"

namespace musher::meilin {

struct StepCosts {
  double flat_s = 1.0;    // to a cell of the same height, or to the same cell
  double up_200_s = 2.5;  // a step of up to 300 mm
  double up_400_s = 4.0;
  double down_200_s = 3.5;
  double down_400_s = 5.0;
  double fetch_s = 4.0;       // without a turn
  double fetch_turn_s = 5.0;  // the robot turns first

  // Of a move between platforms of these heights.
  double Move(int from_mm, int to_mm) const;
  double Fetch(bool turns) const { return turns ? fetch_turn_s : fetch_s; }
};

}  // namespace musher::meilin
