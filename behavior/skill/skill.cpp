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
Result<> Skill::MayResume() {
  return Ok();
}
void Skill::Persist(fsm::Archive& /*archive*/) {}
std::vector<Run*> Skill::inside() {
  return {};
}
void Skill::Draw(fsm::Chart& /*chart*/) const {}

void StepFunction::Declare(Table& table) {
  if (!pause_) table.CannotPause("it is a step function without a function for pauses");
  declare_(table);
}
void StepFunction::OnPause() {
  if (pause_) pause_();
}

}  // namespace musher::skill
