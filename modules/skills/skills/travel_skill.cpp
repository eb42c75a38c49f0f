#include "musher/modules/skills/skills/travel_skill.hpp"

namespace musher::skills {
namespace {

constexpr std::string_view kComplete = "complete";  // data: the task is done

}  // namespace

skill::Next TravelSkill::Cancel(skill::Tick& tick) {
  travel_.GiveUp();
  tick.Report(0, "Stopping");
  return tick.state == stopping_ ? skill::Next::Stay() : skill::Next::To(stopping_);
}

skill::Next TravelSkill::Complete(skill::Tick& tick) {
  tick.data.Set(kComplete, true);
  travel_.GiveUp();
  return skill::Next::To(stopping_);
}

skill::Next TravelSkill::Stop(skill::Tick& tick, const std::string& success) {
  if (!travel_.Stop(tick.step)) return skill::Next::Stay();
  if (tick.cancelling || !tick.data.Get(kComplete, false)) return skill::Next::Cancelled();
  return skill::Next::Succeed(success);
}

void TravelSkill::OnEnd(const skill::Ended& /*ended*/) {
  travel_.End();
}

void TravelSkill::OnPause() {
  travel_.GiveUp();
  robot_.StopMotion();
}

}  // namespace musher::skills
