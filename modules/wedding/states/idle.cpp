#include "musher/modules/wedding/states/idle.hpp"

#include <cmath>
#include <numbers>

namespace musher::wedding {

void Idle::Declare(fsm::Ways& ways) {
  WeddingState::Declare(ways);
  tracking_ = ways.To(state::kTracking, "a face is seen");
}

void Idle::OnEnter(const fsm::Tick& /*tick*/) {
  data().motion.target_pose = pose::kNeutral;
}

void Idle::Run(const fsm::Tick& tick) {
  const double turns =
      static_cast<double>(tick.elapsed.count()) / static_cast<double>(rules_.sway_period.count());
  LookTo({0.5 + rules_.sway * std::sin(2 * std::numbers::pi * turns), 0.5}, tick);
}

fsm::Next Idle::Decide(const fsm::Tick& /*tick*/) {
  const PerceptionData& seen = data().perception;
  if (seen.face_detected && seen.face_seen_for >= rules_.confirm) return fsm::Next::To(tracking_);
  return fsm::Next::Stay();
}

}  // namespace musher::wedding
