#include "musher/modules/skills/skills/assembly.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {
namespace {

using navigation::Point;

// The data of a run.
constexpr std::string_view kPart = "part";
constexpr std::string_view kPartTarget = "target";
constexpr std::string_view kReleasedAt = "released_at_s";

constexpr int kCheckPictures = 5;
constexpr double kCheckWithinS = 5;
constexpr Duration kSettlesWithin = std::chrono::seconds(1);  // also the lateness of a detector
constexpr double kBelowM = 0.05;                              // a part that is lower has fallen off
constexpr double kApproachMPerS = 0.15;

Point Turned(const Point& point, double yaw_rad) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * point.x_m - s * point.y_m, s * point.x_m + c * point.y_m, point.z_m};
}

Point OffsetOf(const skill::Values& parameters) {
  const auto offset = parameters.Get<skill::Numbers>("offset", {0, 0, 0});
  return {offset[0], offset[1], offset[2]};
}

std::string StationOf(const skill::Values& parameters) {
  return NameOfPrim(parameters.Text("station"));
}

}  // namespace

void Assembly::Describe(skill::Table& table) {
  table.Does(
      "Brings the held part to a station that its detectors see, and checks where it stands");
  table.Uses(kBase);
  table.Uses(kArm);
  table.CannotPause(kHandGoesOn);
  table.Needs("station", skill::Kind::kText, "a name or category that its detectors report");
  table.Takes("object_prim_path", "", "the name of the part; empty: the one that is held");
  table.Takes("offset", skill::Numbers{0, 0, 0},
              "m from the middle of the station to the underside of the part, axes of the map");
  table.Takes("distance", 0.8, "m from the robot's middle to the station, where the hand reaches");
  table.Takes("tolerance", 0.05, "m, level, of the part at its place");
  table.Takes("lost_limit", 2.0, "s at a stand without a sighting of the station, then it fails");
  static_cast<void>(table.SetLimit("PREPARING", std::chrono::seconds(60)));
  static_cast<void>(table.SetLimit("EXECUTING", std::chrono::seconds(12)));
  static_cast<void>(table.SetLimit("FINALIZING", std::chrono::seconds(3)));
}

std::optional<std::string> Assembly::WhyRefused(const skill::Values& parameters) const {
  if (robot_.flies()) return robot_.name() + " flies; assembly is for robots on the ground";
  if (auto fault = NoHand(robot_)) return fault;
  const std::string station = StationOf(parameters);
  if (station.empty()) return "station is empty; expected the name of what the detectors see";
  if (parameters.Get<skill::Numbers>("offset", {}).size() != 3) {
    return "Invalid offset: expected three numbers";
  }
  const double distance = parameters.Number("distance");
  if (distance <= robot_.radius_m() || distance > 5) {
    return fmt::format("distance is {:g} m; expected more than {:g} m and at most 5 m", distance,
                       robot_.radius_m());
  }
  if (parameters.Number("tolerance") <= 0) return "Invalid tolerance: it is not above 0 m";
  if (parameters.Number("lost_limit") < 0) return "Invalid lost_limit: it is negative";
  return std::nullopt;
}

HandRequest Assembly::Request(const skill::Tick& tick) const {
  const auto target = tick.data.Get<skill::Numbers>(kPartTarget, {0, 0, 0});
  return {.action = HandAction::kPlace,
          .object = tick.data.Text(kPart),
          .distance_threshold_m = 0,
          .target = {target[0], target[1], target[2]}};
}

Assembly::Outcome Assembly::Initialize(skill::Tick& tick) {
  if (const auto why = WhyRefused(tick.parameters)) return Outcome::Fail(*why);
  drive_.reset();
  looked_.reset();
  const std::string held = grip_->Held();
  // A lost reply: it may have been put there.
  if (tick.retries > 0 && held.empty() && tick.data.Find(kPartTarget) != nullptr) {
    tick.data.Set(kReleasedAt, ToSeconds(tick.now));
    BeginCheck();
    return Outcome::Done();
  }
  const std::string part = GivenObject(tick.parameters, held);
  if (const auto fault = GivingFault(robot_, part, held)) return Outcome::Fail(*fault);
  if (part == StationOf(tick.parameters)) return Outcome::Fail("station is the part itself");
  if (WaitsForAttempt(tick)) return Outcome::Continue();
  tick.data.Set(kPart, part);
  tick.data.Remove(kPartTarget);
  tick.Report(10, "Looking for " + StationOf(tick.parameters));
  return Outcome::Done();
}

Assembly::Outcome Assembly::Prepare(skill::Tick& tick) {
  if (tick.data.Find(kReleasedAt) != nullptr) return Outcome::Done();
  if (!drive_) {
    const ServoRules rules{.target = StationOf(tick.parameters),
                           .distance_m = tick.parameters.Number("distance"),
                           .speed_m_s = kApproachMPerS};
    drive_.emplace(robot_, rules, tick.parameters.Number("lost_limit"));
  }
  const ServoDriveStep step = drive_->Step(tick.step);
  tick.Report(30, step.text);
  if (step.target) tick.Detail("distance_m", LevelDistanceTo(*step.target));
  if (step.kind == ServoDriveStep::Kind::kFailed) return Outcome::Fail(step.text);
  if (step.kind == ServoDriveStep::Kind::kPending) return Outcome::Continue();
  const auto pose = robot_.pose();
  if (!pose || !step.target) return Outcome::Continue();
  const Point station = navigation::PlacedAt(*pose, navigation::Pose{*step.target, 0}).at;
  const Point offset = OffsetOf(tick.parameters);
  tick.data.Set(kPartTarget, skill::Numbers{station.x_m + offset.x_m, station.y_m + offset.y_m,
                                            station.z_m + offset.z_m});
  robot_.StopMotion();
  return Outcome::Done();
}

Assembly::Outcome Assembly::Execute(skill::Tick& tick) {
  robot_.StopMotion();
  if (tick.data.Find(kReleasedAt) != nullptr) return Check(tick);
  tick.Report(60, "Placing " + tick.data.Text(kPart));
  // A restored run: it may have been released.
  const bool asks_again = !tick.entered && !call_.pending();
  if (asks_again && robot_.HasObjects() && grip_->Held().empty()) {
    tick.data.Set(kReleasedAt, ToSeconds(tick.now));
    BeginCheck();
    return Outcome::Continue();
  }
  const HandCall::Answer answer = call_.Poll(robot_, Request(tick), tick.entered);
  switch (answer.kind) {
    case HandCall::Kind::kPending:
      return Outcome::Continue();
    case HandCall::Kind::kDone:
      grip_->Changed("");
      tick.data.Set(kReleasedAt, ToSeconds(tick.now));
      BeginCheck();
      return Outcome::Continue();
    case HandCall::Kind::kLost:
      return Outcome::Retry(answer.message);
    case HandCall::Kind::kTooFar:
    case HandCall::Kind::kRefused:
      break;
  }
  return Outcome::Fail(answer.message);
}

// Earlier pictures show the part in the hand, by as much later as the detector takes, or falling.
void Assembly::BeginCheck() {
  pictures_ = 0;
  offsets_ = {};
  looked_ = robot_.Now() + kSettlesWithin;
}

Assembly::Outcome Assembly::Check(skill::Tick& tick) {
  const std::string part = tick.data.Text(kPart), station = StationOf(tick.parameters);
  if (!looked_) BeginCheck();  // of a restored run
  tick.Report(85, "Checking where " + part + " stands");
  const auto of_part = robot_.LookFor(part), of_station = robot_.LookFor(station);
  const auto pose = robot_.pose();
  const bool sees_both = of_part && of_station && pose && of_part->seen.size() == 1 &&
                         of_station->seen.size() == 1 && of_part->at == of_station->at;
  if (sees_both && of_part->at > *looked_) {
    looked_ = of_part->at;
    const Point& a = of_station->seen[0];
    const Point& b = of_part->seen[0];
    const Point from = Turned({b.x_m - a.x_m, b.y_m - a.y_m, b.z_m - a.z_m}, pose->yaw_rad);
    offsets_ = {offsets_.x_m + from.x_m, offsets_.y_m + from.y_m, offsets_.z_m + from.z_m};
    ++pictures_;
  }
  if (pictures_ < kCheckPictures) {
    if (ToSeconds(tick.now) - tick.data.Number(kReleasedAt) < kCheckWithinS) {
      return Outcome::Continue();
    }
    return Outcome::Fail(
        fmt::format("Not verified: {} and {} are not seen together; the part is "
                    "released",
                    part, station));
  }
  const Point wanted = OffsetOf(tick.parameters);
  const double off_m =
      std::hypot(offsets_.x_m / pictures_ - wanted.x_m, offsets_.y_m / pictures_ - wanted.y_m);
  const double below_m = wanted.z_m - offsets_.z_m / pictures_;
  tick.Detail("off_target_m", off_m);
  if (below_m > kBelowM) {
    return Outcome::Fail(
        fmt::format("{} has fallen: it is {:.2f} m below its place at {}", part, below_m, station));
  }
  if (off_m <= tick.parameters.Number("tolerance")) return Outcome::Done();
  return Outcome::Fail(
      fmt::format("{} stands {:.2f} m off its place at {}, the tolerance is {:g} m", part, off_m,
                  station, tick.parameters.Number("tolerance")));
}

Assembly::Outcome Assembly::Finalize(skill::Tick& tick) {
  robot_.StopMotion();
  if (tick.cancelling && call_.pending()) {
    const HandCall::Answer answer = call_.Poll(robot_, Request(tick), false);
    if (answer.kind == HandCall::Kind::kPending) return Outcome::Continue();
    if (answer.kind == HandCall::Kind::kDone) grip_->Changed("");
  }
  return Outcome::Done("Assembled: " + tick.data.Text(kPart) + " stands at " +
                       StationOf(tick.parameters));
}

skill::Next Assembly::OnLimit(skill::Tick& tick) {
  if (tick.cancelling) return skill::Next::Cancelled();
  if (drive_ && tick.data.Find(kPartTarget) == nullptr) {
    return skill::Next::Fail("Timeout: " + drive_->PlaceText());
  }
  return skill::Next::Fail(HandTimeout(tick));
}

void Assembly::OnEnd(const skill::Ended& /*ended*/) {
  robot_.StopMotion();
  drive_.reset();
  call_.Drop();
}

}  // namespace musher::skills
