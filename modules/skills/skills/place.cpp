#include "musher/modules/skills/skills/place.hpp"

#include <algorithm>
#include <cmath>

#include "musher/modules/skills/skills/nudge.hpp"

namespace musher::skills {
namespace {

constexpr std::string_view kPlacedObject = "object";
constexpr std::string_view kPlaceStart = "start";
constexpr std::string_view kNear = "near_m";  // the target has to be so near, for the hand
constexpr std::string_view kReason = "too_far";
constexpr std::string_view kPlacedAt = "placed_at_s";
constexpr double kCloserM = 0.1;
constexpr double kAtTargetM = 0.1;
constexpr double kShownAfterS = 1.2;

double LevelDistance(const navigation::Point& a, const navigation::Point& b) {
  return std::hypot(a.x_m - b.x_m, a.y_m - b.y_m);
}

}  // namespace

void Place::Describe(skill::Table& table) {
  table.Does("Comes close to a target and puts the held object there");
  table.Uses(kBase);
  table.Uses(kArm);
  table.CannotPause(kHandGoesOn);
  table.Needs("target_location", skill::Kind::kNumbers, "[x, y, z] in m, in the map");
  table.Takes("object_prim_path", "", "the name of the object; empty: the one that is held");
  table.Takes("joint_path", "", "the joint that holds it; empty: the joint of the object");
  table.Takes("distance_threshold", 2.0, "m from the robot to the target, level");
  table.Takes("approach", 0.5, "m that the robot drives at most towards the target");
  static_cast<void>(table.SetLimit("PREPARING", std::chrono::seconds(20)));
  static_cast<void>(table.SetLimit("EXECUTING", std::chrono::seconds(6)));
  static_cast<void>(table.SetLimit("FINALIZING", std::chrono::seconds(3)));
}

HandRequest Place::Request(const skill::Tick& tick) const {
  const auto target = tick.parameters.Get<skill::Numbers>("target_location", {0, 0, 0});
  return {.action = HandAction::kPlace,
          .object = tick.data.Text(kPlacedObject),
          .distance_threshold_m = tick.parameters.Number("distance_threshold"),
          .target = {target[0], target[1], target[2]}};
}

Place::Outcome Place::Initialize(skill::Tick& tick) {
  const std::string held = grip_->Held();
  if (tick.retries > 0 && held.empty()) return Outcome::Done();
  const std::string object = GivenObject(tick.parameters, held);
  if (const auto fault = GivingFault(robot_, object, held)) return Outcome::Fail(*fault);
  if (tick.parameters.Get<skill::Numbers>("target_location", {}).size() != 3) {
    return Outcome::Fail("Invalid target_location: expected three numbers");
  }
  for (const char* name : {"distance_threshold", "approach"}) {
    if (tick.parameters.Number(name) < 0) {
      return Outcome::Fail(std::string("Invalid ") + name + ": it is negative");
    }
  }
  if (WaitsForAttempt(tick)) return Outcome::Continue();
  tick.data.Set(kPlacedObject, object);
  if (tick.data.Find(kNear) == nullptr) {
    tick.data.Set(kNear, tick.parameters.Number("distance_threshold"));
  }
  if (const auto now = robot_.pose(); now && tick.data.Find(kPlaceStart) == nullptr) {
    tick.data.Set(kPlaceStart, skill::Numbers{now->at.x_m, now->at.y_m, now->at.z_m});
  }
  tick.Report(20, "Carrying object");
  return Outcome::Done();
}

Place::Outcome Place::Prepare(skill::Tick& tick) {
  const HandRequest request = Request(tick);
  const auto now = robot_.pose();
  if (!now || !navigation::IsFinite(*now)) {
    robot_.StopMotion();
    tick.Report(30, "Waiting for odometry");
    return Outcome::Continue();
  }
  const double distance_m = LevelDistance(now->at, request.target);
  const double near_m = tick.data.Number(kNear);
  tick.Detail("distance_m", distance_m);
  if (distance_m <= near_m) {
    robot_.StopMotion();
    tick.Report(60, "Placing object");
    return Outcome::Done();
  }
  const std::string reason = tick.data.Text(kReason);
  const std::string too_far = reason.empty() ? TooFarText(distance_m, near_m) : reason;
  const double most_m = tick.parameters.Number("approach");
  const auto start = tick.data.Get<skill::Numbers>(kPlaceStart, {});
  if (distance_m - near_m > most_m || start.size() != 3) return Outcome::Fail(too_far);
  const Result<> moved =
      NudgeTowards(robot_, request.target, {start[0], start[1], start[2]}, most_m);
  if (!moved) return Outcome::Fail(too_far + "; " + moved.error().message);
  tick.Report(40, "Approaching");
  return Outcome::Continue();
}

Place::Outcome Place::Execute(skill::Tick& tick) {
  if (tick.data.Find(kPlacedAt) != nullptr) return Verify(tick);
  // The last reply was lost, or the run is restored: it may have been placed.
  const bool asks_again = tick.entered ? tick.retries > 0 : !call_.pending();
  if (asks_again && robot_.HasObjects() && grip_->Held().empty()) {
    tick.data.Set(kPlacedAt, ToSeconds(tick.now));
    return Verify(tick);
  }
  const HandRequest request = Request(tick);
  const HandCall::Answer answer = call_.Poll(robot_, request, tick.entered);
  const auto now = robot_.pose();
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      tick.Report(70, "Placing object");
      return Outcome::Continue();
    case HandCall::Kind::kDone:
      grip_->Changed("");
      tick.data.Set(kPlacedAt, ToSeconds(tick.now));
      return Verify(tick);
    case HandCall::Kind::kLost:
      return Outcome::Retry(answer.message);
    case HandCall::Kind::kTooFar:
      if (!now) return Outcome::Retry(answer.message);
      tick.data.Set(kReason, answer.message);
      tick.data.Set(kNear, LevelDistance(now->at, request.target) - kCloserM);
      return Outcome::Replan(answer.message);
    case HandCall::Kind::kRefused:
      break;
  }
  return Outcome::Fail(answer.message);
}

Place::Outcome Place::Verify(skill::Tick& tick) {
  tick.Report(90, "Checking the object");
  const HandRequest request = Request(tick);
  const std::vector<SeenObject> objects = robot_.objects();
  const auto object = std::ranges::find(objects, request.object, &SeenObject::name);
  if (!robot_.HasObjects() || object == objects.end()) return Outcome::Done("Object placed");
  const double off_m = LevelDistance(object->pose.at, request.target);
  tick.Detail("off_target_m", off_m);
  if (object->held_by.empty() && off_m <= kAtTargetM) return Outcome::Done("Object placed");
  if (ToSeconds(tick.now) - tick.data.Number(kPlacedAt) < kShownAfterS) {
    return Outcome::Continue();
  }
  return Outcome::Fail(request.object + " does not stand at the target");
}

Place::Outcome Place::Finalize(skill::Tick& tick) {
  robot_.StopMotion();
  if (tick.cancelling && call_.pending()) {
    const HandCall::Answer answer = call_.Poll(robot_, Request(tick), false);
    if (answer.kind == HandCall::Kind::kPending) return Outcome::Continue();
    if (answer.kind == HandCall::Kind::kDone) grip_->Changed("");
  }
  return Outcome::Done("Object placed");
}

skill::Next Place::OnLimit(skill::Tick& tick) {
  return tick.cancelling ? skill::Next::Cancelled() : skill::Next::Fail(HandTimeout(tick));
}

void Place::OnEnd(const skill::Ended& /*ended*/) {
  robot_.StopMotion();
  call_.Drop();
}

}  // namespace musher::skills
