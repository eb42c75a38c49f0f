#include "musher/behavior/skill/skill.hpp"

namespace musher::skill {

Next Skill::Cancel(Tick& /*tick*/) {
  return Next::Cancelled();
}
Next Skill::OnLimit(Tick& tick) {
  return Next::Fail("not done after " + SecondsText(tick.elapsed));
}
void Skill::OnEnd(const Ended& /*ended*/) {}
void Skill::OnPause() {}
void Skill::OnResume() {}
void Skill::Persist(fsm::Archive& /*archive*/) {}
std::vector<Run*> Skill::inside() {
  return {};
}
void Skill::Draw(fsm::Chart& /*chart*/) const {}

}  // namespace musher::skill
