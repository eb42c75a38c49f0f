#include "musher/modules/skills/skills/grasp.hpp"

#include <algorithm>

#include "musher/modules/skills/skills/nudge.hpp"

namespace musher::skills {
namespace {

constexpr std::string_view kGraspStart = "start";
constexpr std::string_view kApproaching = "approaching";
constexpr std::string_view kTooFar = "too_far";
constexpr std::string_view kAttaching = "attaching";
constexpr std::string_view kAttachedAt = "attached_at_s";
constexpr double kShownWithinS = 1.2;  // longer than Grip trusts itself

// Whether fresh objects say that this one is held by this robot.
bool ShownHeld(const Robot& robot, const std::string& object) {
  return std::ranges::any_of(robot.objects(), [&](const SeenObject& seen) {
    return seen.name == object && seen.held_by == robot.name();
  });
}

}  // namespace

void Grasp::Describe(skill::Table& table) {
  table.Does("Comes close to an object and takes it");
  table.Uses(kBase);
  table.Uses(kArm);
  DeclareGrasping(table);
  table.Takes("approach", 0.5, "m that the robot drives at most towards the object");
  static_cast<void>(table.SetLimit("PREPARING", std::chrono::seconds(20)));
  static_cast<void>(table.SetLimit("EXECUTING", std::chrono::seconds(6)));
  static_cast<void>(table.SetLimit("FINALIZING", std::chrono::seconds(3)));
}

Grasp::Outcome Grasp::Initialize(skill::Tick& tick) {
  if (const auto fault = GraspingFault(robot_, tick.parameters)) return Outcome::Fail(*fault);
  if (tick.parameters.Number("approach") < 0) {
    return Outcome::Fail("Invalid approach: it is negative");
  }
  const std::string object = GraspingRequest(HandAction::kAttach, tick.parameters).object;
  const std::string held = grip_->Held();
  if (!held.empty() && held != object) {
    return Outcome::Fail(robot_.name() + " holds " + held + " already; put it down first");
  }
  if (WaitsForAttempt(tick)) return Outcome::Continue();
  tick.data.Remove(kApproaching);
  tick.data.Remove(kAttaching);
  tick.data.Remove(kAttachedAt);
  if (const auto now = robot_.pose(); now && tick.data.Find(kGraspStart) == nullptr) {
    tick.data.Set(kGraspStart, skill::Numbers{now->at.x_m, now->at.y_m, now->at.z_m});
  }
  tick.Report(20, "Checking distance");
  return Outcome::Done();
}

Grasp::Outcome Grasp::Prepare(skill::Tick& tick) {
  const HandRequest request = GraspingRequest(HandAction::kCheckDistance, tick.parameters);
  if (grip_->Held() == request.object) return Outcome::Done();
  const HandCall::Answer answer = call_.Poll(robot_, request, tick.entered);
  if (answer.distance_m >= 0) tick.Detail("distance_m", answer.distance_m);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      if (tick.data.Get(kApproaching, false)) return ComeCloser(request, tick);
      tick.Report(30, "Checking distance");
      return Outcome::Continue();
    case HandCall::Kind::kTooFar:
      if (answer.distance_m - request.distance_threshold_m > tick.parameters.Number("approach")) {
        return Outcome::Fail(answer.message);
      }
      tick.data.Set(kApproaching, true);
      tick.data.Set(kTooFar, answer.message);
      return ComeCloser(request, tick);
    case HandCall::Kind::kDone:
      robot_.StopMotion();
      tick.Report(60, "Attaching object");
      return Outcome::Done();
    case HandCall::Kind::kLost:
      robot_.StopMotion();
      return Outcome::Retry(answer.message);
    case HandCall::Kind::kRefused:
      break;
  }
  return Outcome::Fail(answer.message);
}

// A step of the drive; the distance is asked in each.
Grasp::Outcome Grasp::ComeCloser(const HandRequest& request, skill::Tick& tick) {
  const std::string too_far = tick.data.Text(kTooFar);
  const auto start = tick.data.Get<skill::Numbers>(kGraspStart, {});
  const std::vector<SeenObject> objects = robot_.objects();
  const auto object = std::ranges::find(objects, request.object, &SeenObject::name);
  if (start.size() != 3 || object == objects.end()) {
    robot_.StopMotion();
    return Outcome::Fail(too_far);
  }
  const Result<> moved = NudgeTowards(robot_, object->pose.at, {start[0], start[1], start[2]},
                                      tick.parameters.Number("approach"));
  if (!moved) return Outcome::Fail(too_far + "; " + moved.error().message);
  tick.Report(40, "Approaching");
  return Outcome::Continue();
}

Grasp::Outcome Grasp::Execute(skill::Tick& tick) {
  const HandRequest request = GraspingRequest(HandAction::kAttach, tick.parameters);
  if (tick.data.Find(kAttachedAt) != nullptr) return Verify(request.object, tick);
  if (!call_.pending() && grip_->Held() == request.object) return Outcome::Done("Object attached");
  tick.data.Set(kAttaching, true);
  const HandCall::Answer answer = call_.Poll(robot_, request, tick.entered);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      tick.Report(70, "Attaching object");
      return Outcome::Continue();
    case HandCall::Kind::kDone:
      grip_->Changed(request.object);
      tick.data.Remove(kAttaching);
      tick.data.Set(kAttachedAt, ToSeconds(tick.now));
      return Verify(request.object, tick);
    case HandCall::Kind::kTooFar:
    case HandCall::Kind::kLost:
      return Outcome::Retry(answer.message);
    case HandCall::Kind::kRefused:
      break;
  }
  return Outcome::Fail(answer.message);
}

Grasp::Outcome Grasp::Verify(const std::string& object, skill::Tick& tick) {
  tick.Report(90, "Checking the object");
  if (!robot_.HasObjects() || ShownHeld(robot_, object)) return Outcome::Done("Object attached");
  if (ToSeconds(tick.now) - tick.data.Number(kAttachedAt) < kShownWithinS) {
    return Outcome::Continue();
  }
  return Outcome::Retry(object + " is not in the hand");
}

Grasp::Outcome Grasp::Finalize(skill::Tick& tick) {
  robot_.StopMotion();
  const HandRequest request = GraspingRequest(HandAction::kAttach, tick.parameters);
  if (tick.cancelling && tick.data.Get(kAttaching, false) && call_.pending()) {
    const HandCall::Answer answer = call_.Poll(robot_, request, false);
    if (answer.kind == HandCall::Kind::kPending) return Outcome::Continue();
    if (answer.kind == HandCall::Kind::kDone) grip_->Changed(request.object);
  }
  if (grip_->Held() == request.object) tick.Detail("holds", request.object);
  return Outcome::Done("Object attached");
}

skill::Next Grasp::OnLimit(skill::Tick& tick) {
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(HandTimeout(tick));
}

void Grasp::OnEnd(const skill::Ended& /*ended*/) {
  robot_.StopMotion();
  call_.Drop();
}

}  // namespace musher::skills
