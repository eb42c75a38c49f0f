#pragma once
// The garden as an actuator of the robot.

#include <optional>

#include "garden.hpp"
#include "musher/application/tree_actuator.hpp"

class Gardener : public musher::TreeActuator {
 public:
  // A garden does not move: it may begin by itself, also after a restart of the process.
  Gardener()
      : TreeActuator("gardener",
                     {.rate_hz = 20, .begin = musher::Begin::kAtActive, .file = "garden.xml"}) {}

 private:
  musher::Result<> RegisterNodes(tree::Factory& factory) override {
    return AddNodes(factory, garden_);
  }
  void BeforeTick(musher::Time now) override {
    if (last_) garden_.Advance(now - *last_);
    last_ = now;
  }
  void OnPause() override { last_.reset(); }

  Garden garden_;
  std::optional<musher::Time> last_;
};
