#pragma once
// A battery of a scene: watt hours, watts and percent. A plain value without threads and errors.

namespace musher::world {

struct BatterySpec {
  double capacity_wh = 150;
  double start_percent = 80;
  double off_w = 5;
  double lying_w = 20;
  double standing_w = 90;
  double moving_w = 220;
  double cable_w = 180;  // what charging puts in
  double pad_w = 90;
};

}  // namespace musher::world
