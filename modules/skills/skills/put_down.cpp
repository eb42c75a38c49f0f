#include "musher/modules/skills/skills/put_down.hpp"

namespace musher::skills {
namespace {

constexpr std::string_view kReleasedObject = "object";

}  // namespace

void PutDown::Declare(skill::Table& table) {
  table.Does("Releases the held object");
  table.Uses(kArm);
  table.CannotPause(kHandGoesOn);
  table.Takes("object_prim_path", "", "the name of the object; empty: the one that is held");
  table.Takes("joint_path", "", "the joint that holds it; empty: the joint of the object");
  initializing_ = table.State("INITIALIZING");
  releasing_ = table.State("RELEASING", std::chrono::seconds(3));
  table.To(initializing_, releasing_, "the robot holds the object");
  table.To(initializing_, skill::kSucceeded, "an earlier attempt has released it");
  table.To(releasing_, skill::kSucceeded, "released");
  table.To(releasing_, initializing_, "retry");
}

skill::Next PutDown::Initialize(skill::Tick& tick) {
  const std::string held = grip_->Held();
  if (tick.retries > 0 && held.empty()) return skill::Next::Succeed("Object put down");
  const std::string object = GivenObject(tick.parameters, held);
  if (const auto fault = GivingFault(robot_, object, held)) return skill::Next::Fail(*fault);
  if (WaitsForAttempt(tick)) return skill::Next::Stay();
  tick.data.Set(kReleasedObject, object);
  tick.Report(50, "Releasing object");
  return skill::Next::To(releasing_);
}

skill::Next PutDown::Release(skill::Tick& tick) {
  // A restored run: it may have been released.
  const bool asks_again = !tick.entered && !call_.pending();
  if (asks_again && robot_.HasObjects() && grip_->Held().empty()) {
    return skill::Next::Succeed("Object put down");
  }
  const HandRequest request{.action = HandAction::kRelease,
                            .object = tick.data.Text(kReleasedObject),
                            .distance_threshold_m = 0,
                            .target = {}};
  const HandCall::Answer answer = call_.Poll(robot_, request, tick.entered);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      tick.Report(70, "Releasing object");
      return skill::Next::Stay();
    case HandCall::Kind::kDone:
      grip_->Changed("");
      if (tick.cancelling) return skill::Next::Cancelled("the object is put down");
      return skill::Next::Succeed("Object put down");
    case HandCall::Kind::kLost:
      return skill::Next::Retry(initializing_, answer.message);
    case HandCall::Kind::kTooFar:
    case HandCall::Kind::kRefused:
      break;
  }
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(answer.message);
}

skill::Next PutDown::Step(skill::Tick& tick) {
  return tick.state == initializing_ ? Initialize(tick) : Release(tick);
}

skill::Next PutDown::Cancel(skill::Tick& tick) {
  if (tick.state == releasing_ && !tick.entered) return Release(tick);
  return skill::Next::Cancelled();
}

skill::Next PutDown::OnLimit(skill::Tick& tick) {
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(HandTimeout(tick));
}

void PutDown::OnEnd(const skill::Ended& /*ended*/) {
  call_.Drop();
}

}  // namespace musher::skills
