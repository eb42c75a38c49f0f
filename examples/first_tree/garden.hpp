#pragma once
// A garden bed with a pump, and the nodes of its tree, independent of topics, threads and clocks.

#include <algorithm>
#include <chrono>

#include "musher/behavior/tree/factory.hpp"

// On a real robot drivers read the sensors and switch the pump. This one has physics instead.
struct Garden {
  double soil_percent = 20;
  double tank_l = 1;
  bool pump = false;
  bool tap = false;  // fills the tank
  bool has_tap_water = true;

  void Advance(musher::Duration time) {
    const double seconds = musher::ToSeconds(time);
    if (tap && has_tap_water) tank_l = std::min(tank_l + seconds, 2.0);
    if (!pump) return;
    const double poured_l = std::min(0.25 * seconds, tank_l);
    tank_l -= poured_l;
    soil_percent = std::min(soil_percent + 20 * poured_l, 100.0);
  }
};

namespace tree = musher::tree;

class SoilIsWet : public tree::Condition {
 public:
  SoilIsWet(tree::Setup& setup, Garden& garden)
      : percent_(setup.Input<double>("percent", "of water, 0 to 100")), garden_(garden) {}

 private:
  tree::Status Evaluate(const tree::Tick&) override {
    const bool wet = garden_.soil_percent >= percent_.Get();
    return wet ? tree::Status::kSuccess : tree::Status::kFailure;
  }

  tree::InPort<double> percent_;
  Garden& garden_;
};

class Pour : public tree::StatefulAction {
 public:
  Pour(tree::Setup& setup, Garden& garden)
      : litres_(setup.Input<double>("litres", 0.5, "fails where the tank has less")),
        garden_(garden) {}

 private:
  tree::Status OnStart(const tree::Tick&) override {
    left_in_tank_l_ = garden_.tank_l - litres_.Get();
    if (left_in_tank_l_ < 0) return tree::Status::kFailure;
    garden_.pump = true;
    return tree::Status::kRunning;
  }
  tree::Status OnRunning(const tree::Tick&) override {
    if (garden_.tank_l > left_in_tank_l_) return tree::Status::kRunning;
    garden_.pump = false;
    return tree::Status::kSuccess;
  }
  void OnHalted(const tree::Tick&) override { garden_.pump = false; }

  tree::InPort<double> litres_;
  Garden& garden_;
  double left_in_tank_l_ = 0;
};

class Refill : public tree::StatefulAction {
 public:
  explicit Refill(Garden& garden) : garden_(garden) {}

 private:
  tree::Status OnStart(const tree::Tick&) override {
    garden_.tap = true;
    return tree::Status::kRunning;
  }
  tree::Status OnRunning(const tree::Tick&) override {
    if (garden_.tank_l < 2) return tree::Status::kRunning;
    garden_.tap = false;
    return tree::Status::kSuccess;
  }
  void OnHalted(const tree::Tick&) override { garden_.tap = false; }

  Garden& garden_;
};

inline musher::Result<> AddNodes(tree::Factory& factory, Garden& garden) {
  auto added = factory.Add<SoilIsWet>("SoilIsWet", garden);
  if (added) added = factory.Add<Pour>("Pour", garden);
  if (added) added = factory.Add<Refill>("Refill", garden);
  return added;
}
