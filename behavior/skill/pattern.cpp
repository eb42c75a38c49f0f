#include "musher/behavior/skill/pattern.hpp"

namespace musher::skill {

void PatternSkill::Declare(Table& table) {
  initializing_ = table.State("INITIALIZING");
  preparing_ = table.State("PREPARING");
  executing_ = table.State("EXECUTING");
  finalizing_ = table.State("FINALIZING");
  table.To(initializing_, preparing_, "success");
  table.To(preparing_, executing_, "success");
  table.To(executing_, finalizing_, "completed");
  table.To(finalizing_, kSucceeded, "success");
  for (const StateId state : {initializing_, preparing_, executing_, finalizing_}) {
    table.To(state, kFailed, "failed");
    if (state != finalizing_) table.To(state, initializing_, "retry");
  }
  table.To(executing_, preparing_, "need_replan");
  table.To(preparing_, finalizing_, "cancel");
  table.To(executing_, finalizing_, "cancel");
  Describe(table);
}

PatternSkill::Outcome PatternSkill::Initialize(Tick& /*tick*/) {
  return Outcome::Done();
}
PatternSkill::Outcome PatternSkill::Prepare(Tick& /*tick*/) {
  return Outcome::Done();
}
PatternSkill::Outcome PatternSkill::Finalize(Tick& /*tick*/) {
  return Outcome::Done();
}

PatternSkill::Outcome PatternSkill::Phase(Tick& tick) {
  if (tick.state == initializing_) return Initialize(tick);
  if (tick.state == preparing_) return Prepare(tick);
  return tick.state == executing_ ? Execute(tick) : Finalize(tick);
}

Next PatternSkill::Step(Tick& tick) {
  const Outcome outcome = Phase(tick);
  switch (outcome.kind()) {
    case Outcome::Kind::kFail:
      return Next::Fail(outcome.message());
    case Outcome::Kind::kRetry:
      return Next::Retry(initializing_, outcome.message());
    case Outcome::Kind::kReplan:
      return Next::Replan(preparing_, outcome.message());
    case Outcome::Kind::kDone:
      if (tick.state == initializing_) return Next::To(preparing_, outcome.message());
      if (tick.state == preparing_) return Next::To(executing_, outcome.message());
      if (tick.state == executing_) return Next::To(finalizing_, outcome.message());
      return Next::Succeed(outcome.message());
    case Outcome::Kind::kContinue:
      break;
  }
  return Next::Stay();
}

Next PatternSkill::Cancel(Tick& tick) {
  if (tick.state == initializing_) return Next::Cancelled();
  return tick.state == finalizing_ ? Step(tick) : Next::To(finalizing_);
}

}  // namespace musher::skill
