#pragma once
// A battery as a store of energy: discharged by the body's activity, charged by cable or pad.

#include "musher/modules/world/scene/scene.hpp"

namespace musher::world {

enum class Activity { kOff, kLying, kStanding, kMoving };

class Battery {
 public:
  explicit Battery(const BatterySpec& spec) : spec_(spec), percent_(spec.start_percent) {}

  // `percent` from 0 to 100.
  void Set(double percent) { percent_ = percent; }
  void Plug(bool in) { cable_ = in; }

  // `on_pad`: the pad charges, too; the cable is stronger.
  void Step(Duration dt, Activity activity, bool on_pad);

  double percent() const { return percent_; }
  bool empty() const { return percent_ <= 0; }
  bool cable() const { return cable_; }
  bool charging() const { return charge_w_ > 0; }
  double power_w() const { return power_w_; }  // into the battery; negative: out of it

 private:
  BatterySpec spec_;
  double percent_;
  bool cable_ = false;
  double charge_w_ = 0;
  double power_w_ = 0;
};

}  // namespace musher::world
