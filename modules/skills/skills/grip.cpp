#include "musher/modules/skills/skills/grip.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {
namespace {

constexpr Duration kObjectsLag = std::chrono::seconds(1);
constexpr Duration kBeforeAttempt = std::chrono::milliseconds(500);

// "/World/grasp_joint_box_red" is the joint that holds box_red.
std::string ObjectOfJoint(const std::string& joint_path) {
  constexpr std::string_view kPrefix = "grasp_joint_";
  const std::string joint = NameOfPrim(joint_path);
  return joint.starts_with(kPrefix) ? joint.substr(kPrefix.size()) : joint;
}

}  // namespace

std::string Grip::Held() const {
  const bool lagging = changed_at_ && robot_.Now() - *changed_at_ < kObjectsLag;
  if (lagging || !robot_.HasObjects()) return held_;
  const std::vector<SeenObject> objects = robot_.objects();
  const auto held = std::ranges::find(objects, robot_.name(), &SeenObject::held_by);
  return held == objects.end() ? "" : held->name;
}

void Grip::Changed(const std::string& held) {
  held_ = held;
  changed_at_ = robot_.Now();
}

HandCall::Answer HandCall::Poll(Robot& robot, const HandRequest& request, bool begin) {
  if (begin || !reply_.valid()) reply_ = robot.UseHand(request);
  if (!reply_.done()) return {};
  const Result<HandReply> result = reply_.result();
  reply_.Drop();
  if (!result) return {Kind::kLost, "The hand has not replied: " + result.error().message};
  const HandReply& reply = result.value();
  if (reply.success) return {Kind::kDone, reply.message, reply.distance_m};
  // A hand also says so of its own reach, which is shorter than the threshold.
  if (reply.message.starts_with("Too far")) {
    return {Kind::kTooFar, reply.message, reply.distance_m};
  }
  if (request.distance_threshold_m > 0 && reply.distance_m > request.distance_threshold_m) {
    return {Kind::kTooFar, TooFarText(reply.distance_m, request.distance_threshold_m),
            reply.distance_m};
  }
  return {Kind::kRefused, reply.message.empty() ? "The hand has refused" : reply.message,
          reply.distance_m};
}

std::string TooFarText(double distance_m, double limit_m) {
  return fmt::format("Too far: {:.2f}m > {:.2f}m", distance_m, limit_m);
}

void DeclareGrasping(skill::Table& table) {
  table.CannotPause(kHandGoesOn);
  table.Takes("robot_hand_prim_path", "hand", "the hand; a robot has one");
  table.Needs("object_prim_path", skill::Kind::kText, "the name of the object");
  table.Takes("distance_threshold", 2.0, "m from hand to object");
  table.Takes("axis", skill::Numbers{0, 0, 1}, "of the joint; accepted, and not used");
  table.Takes("local_pos_hand", skill::Numbers{0, 0, 1}, "m; accepted, and not used");
  table.Takes("local_pos_object", skill::Numbers{0, 0, 0}, "m; accepted, and not used");
}

std::optional<std::string> NoHand(const Robot& robot) {
  if (robot.HasHand()) return std::nullopt;
  return robot.name() + " has no hand";
}

std::optional<std::string> GraspingFault(const Robot& robot, const skill::Values& parameters) {
  if (auto fault = NoHand(robot)) return fault;
  if (parameters.Text("robot_hand_prim_path").empty()) return "Hand path required";
  if (NameOfPrim(parameters.Text("object_prim_path")).empty()) return "Object path required";
  if (parameters.Number("distance_threshold") <= 0) {
    return "Invalid distance_threshold: it is not above 0 m";
  }
  for (const char* name : {"axis", "local_pos_hand", "local_pos_object"}) {
    if (parameters.Get<skill::Numbers>(name, {}).size() != 3) {
      return fmt::format("Invalid {}: expected three numbers", name);
    }
  }
  return std::nullopt;
}

HandRequest GraspingRequest(HandAction action, const skill::Values& parameters) {
  return {.action = action,
          .object = NameOfPrim(parameters.Text("object_prim_path")),
          .distance_threshold_m = parameters.Number("distance_threshold"),
          .target = {}};
}

std::string GivenObject(const skill::Values& parameters, const std::string& held) {
  std::string object = NameOfPrim(parameters.Text("object_prim_path"));
  if (!object.empty()) return object;
  std::string of_joint = ObjectOfJoint(parameters.Text("joint_path"));
  return of_joint.empty() ? held : of_joint;
}

std::optional<std::string> GivingFault(const Robot& robot, const std::string& object,
                                       const std::string& held) {
  if (auto fault = NoHand(robot)) return fault;
  if (held.empty()) return "Joint path not found: " + robot.name() + " holds nothing";
  if (object == held) return std::nullopt;
  return fmt::format("Joint path not found: {} holds {}, not {}", robot.name(), held, object);
}

std::string HandTimeout(const skill::Tick& tick) {
  return "Timeout: the hand has not replied after " + skill::SecondsText(tick.elapsed);
}

bool WaitsForAttempt(const skill::Tick& tick) {
  return tick.retries > 0 && tick.elapsed < kBeforeAttempt;
}

}  // namespace musher::skills
