#include "musher/modules/skills/skills/pick_up.hpp"

namespace musher::skills {

void PickUp::Declare(skill::Table& table) {
  table.Does("Takes an object within reach");
  table.Uses(kArm);
  DeclareGrasping(table);
  initializing_ = table.State("INITIALIZING");
  checking_ = table.State("CHECKING", std::chrono::seconds(3));
  attaching_ = table.State("ATTACHING", std::chrono::seconds(3));
  table.To(initializing_, checking_, "the hand is free");
  table.To(initializing_, skill::kSucceeded, "the robot holds the object already");
  table.To(checking_, attaching_, "within grasp distance");
  table.To(checking_, initializing_, "retry");
  table.To(attaching_, skill::kSucceeded, "attached");
  table.To(attaching_, initializing_, "retry");
}

skill::Next PickUp::Initialize(skill::Tick& tick) {
  if (const auto fault = GraspingFault(robot_, tick.parameters)) return skill::Next::Fail(*fault);
  const std::string object = GraspingRequest(HandAction::kAttach, tick.parameters).object;
  const std::string held = grip_->Held();
  if (held == object) return skill::Next::Succeed("Object picked up");
  if (!held.empty()) {
    return skill::Next::Fail(robot_.name() + " holds " + held + " already; put it down first");
  }
  if (WaitsForAttempt(tick)) return skill::Next::Stay();
  tick.Report(20, "Checking distance");
  return skill::Next::To(checking_);
}

skill::Next PickUp::CheckDistance(skill::Tick& tick) {
  const HandCall::Answer answer = call_.Poll(
      robot_, GraspingRequest(HandAction::kCheckDistance, tick.parameters), tick.entered);
  if (answer.distance_m >= 0) tick.Detail("distance_m", answer.distance_m);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      tick.Report(30, "Checking distance");
      return skill::Next::Stay();
    case HandCall::Kind::kDone:
      tick.Report(60, "Attaching object");
      return skill::Next::To(attaching_);
    case HandCall::Kind::kLost:
      return skill::Next::Retry(initializing_, answer.message);
    case HandCall::Kind::kTooFar:
    case HandCall::Kind::kRefused:
      break;
  }
  return skill::Next::Fail(answer.message);
}

skill::Next PickUp::Attach(skill::Tick& tick) {
  const HandRequest request = GraspingRequest(HandAction::kAttach, tick.parameters);
  // A restored run: it may have been attached.
  if (!call_.pending() && grip_->Held() == request.object) {
    return skill::Next::Succeed("Object picked up");
  }
  const HandCall::Answer answer = call_.Poll(robot_, request, tick.entered);
  if (answer.distance_m >= 0) tick.Detail("distance_m", answer.distance_m);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      tick.Report(70, "Attaching object");
      return skill::Next::Stay();
    case HandCall::Kind::kDone:
      grip_->Changed(request.object);
      if (tick.cancelling) {
        return skill::Next::Cancelled(robot_.name() + " holds " + request.object);
      }
      return skill::Next::Succeed("Object picked up");
    case HandCall::Kind::kTooFar:
    case HandCall::Kind::kLost:
      return skill::Next::Retry(initializing_, answer.message);
    case HandCall::Kind::kRefused:
      break;
  }
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(answer.message);
}

skill::Next PickUp::Step(skill::Tick& tick) {
  if (tick.state == initializing_) return Initialize(tick);
  return tick.state == checking_ ? CheckDistance(tick) : Attach(tick);
}

skill::Next PickUp::Cancel(skill::Tick& tick) {
  // Entered: the request is not sent yet.
  if (tick.state == attaching_ && !tick.entered) return Attach(tick);
  return skill::Next::Cancelled();
}

skill::Next PickUp::OnLimit(skill::Tick& tick) {
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(HandTimeout(tick));
}

void PickUp::OnEnd(const skill::Ended& /*ended*/) {
  call_.Drop();
}

}  // namespace musher::skills
