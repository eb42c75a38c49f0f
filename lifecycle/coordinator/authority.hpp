#pragma once
// One controller leads: the one with the higher epoch. The other releases control at once and
// changes nothing more.

#include "musher/lifecycle/switch/tear_down.hpp"

namespace musher {

class Authority : StepPart {
 public:
  Authority(StepContext& step, Switching& switching, TearDown& tear_down)
      : StepPart(step), switching_(switching), tear_down_(tear_down) {}

  void On(const event::RivalSeen& rival);

 private:
  Switching& switching_;
  TearDown& tear_down_;
};

}  // namespace musher
