#include "musher/modules/skills/skills/visual_servoing.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

#include "musher/modules/skills/skills/sight.hpp"

namespace musher::skills {
namespace {

using skill::Next;
using skill::Tick;

constexpr double kFastestServoMPerS = 0.5;
constexpr double kFarthestServoM = 10;
constexpr double kWidestRad = 1;  // a camera that looks ahead still shows the target
constexpr double kServoTurnRadPerS = 0.6;

ServoRules RulesOf(const skill::Values& parameters) {
  return {.target = NameOfPrim(parameters.Text("target")),
          .distance_m = parameters.Number("distance"),
          .bearing_rad = parameters.Number("bearing"),
          .tolerance_m = parameters.Number("tolerance"),
          .bearing_tolerance_rad = parameters.Number("bearing_tolerance"),
          .speed_m_s = parameters.Number("speed"),
          .turn_rad_s = kServoTurnRadPerS};
}

}  // namespace

void VisualServoing::Declare(skill::Table& table) {
  initializing_ = table.State("INITIALIZING", kServerWait);
  executing_ = table.State("EXECUTING", std::chrono::seconds(60));
  stopping_ = table.State("STOPPING");
  table.To(initializing_, executing_, "detectors, scan and odometry are there");
  table.To(executing_, stopping_, "the target is right, or cancel");
  table.To(initializing_, stopping_, "cancel");
  table.To(initializing_, skill::kFailed, "failed");
  table.To(executing_, skill::kFailed, "the target is lost, or failed");
  table.To(stopping_, skill::kSucceeded, "the robot stands before the target");
  table.To(stopping_, skill::kCancelled, "the robot stands");
  table.Does("Comes to stand at a distance and bearing of a target that its detectors see");
  table.Uses(kBase);
  table.Needs("target", skill::Kind::kText, "a name or category that its detectors report");
  table.Takes("distance", 1.0, "m, level, from the robot's middle to that of the target");
  table.Takes("bearing", 0.0, "rad to the left at which the target stands then, at most 1.0");
  table.Takes("tolerance", 0.05, "m");
  table.Takes("bearing_tolerance", 0.1, "rad");
  table.Takes("speed", 0.2, "m/s, at most 0.5");
  table.Takes("lost_limit", 2.0, "s at a stand without a sighting that counts, then it fails");
}

std::optional<std::string> VisualServoing::WhyRefused(const skill::Values& parameters) const {
  if (robot_.flies()) {
    return robot_.name() + " flies; visual_servoing is for robots on the ground";
  }
  if (NameOfPrim(parameters.Text("target")).empty()) {
    return "target is empty; expected the name of what the detectors see";
  }
  const double distance = parameters.Number("distance");
  if (distance <= robot_.radius_m() || distance > kFarthestServoM) {
    return fmt::format(
        "distance is {} m; expected more than the radius of the robot, {:g} m, and at most {:g} m",
        LengthText(distance), robot_.radius_m(), kFarthestServoM);
  }
  const double bearing = parameters.Number("bearing");
  if (std::abs(bearing) > kWidestRad) {
    return fmt::format("bearing is {:g} rad; expected -{:g} to {:g}", bearing, kWidestRad,
                       kWidestRad);
  }
  const double speed = parameters.Number("speed");
  if (speed <= 0 || speed > kFastestServoMPerS) {
    return fmt::format("speed is {:g} m/s; expected more than 0 and at most {:g} m/s", speed,
                       kFastestServoMPerS);
  }
  for (const char* name : {"tolerance", "bearing_tolerance"}) {
    const double number = parameters.Number(name);
    if (number <= 0) return fmt::format("{} is {:g}; expected more than 0", name, number);
  }
  const double limit_s = parameters.Number("lost_limit");
  if (limit_s < 0) return fmt::format("lost_limit is {:g}; expected 0 or more seconds", limit_s);
  return std::nullopt;
}

std::optional<std::string> VisualServoing::Missing(const skill::Values& parameters) {
  const bool looks = robot_.LookFor(NameOfPrim(parameters.Text("target"))).has_value();
  const auto pose = robot_.pose();
  if (!pose || !navigation::IsFinite(*pose)) return robot_.WhyNoPose();
  if (!robot_.HasScan()) return "No scan of " + robot_.name();
  if (!looks) return robot_.WhyNoLook();
  return std::nullopt;
}

Next VisualServoing::Step(Tick& tick) {
  if (tick.state == stopping_) return Stop(tick, "Reached " + RulesOf(tick.parameters).target);
  if (const auto why = WhyRefused(tick.parameters)) return Next::Fail(*why);
  if (tick.state == executing_) return Execute(tick);
  tick.Report(5, "Waiting for the detectors");
  drive_.reset();
  return Missing(tick.parameters) ? Next::Stay() : Next::To(executing_);
}

Next VisualServoing::Execute(Tick& tick) {
  const ServoRules rules = RulesOf(tick.parameters);
  if (!drive_) drive_.emplace(robot_, rules, tick.parameters.Number("lost_limit"));
  const ServoDriveStep step = drive_->Step(tick.step);
  double left_m = rules.distance_m;
  if (step.target) {
    left_m = std::abs(LevelDistanceTo(*step.target) - rules.distance_m);
    tick.Detail("target_distance", LevelDistanceTo(*step.target));
    tick.Detail("target_bearing", BearingOf(*step.target));
  }
  tick.Report(10 + 85 / (1 + left_m), step.text);
  if (step.kind == ServoDriveStep::Kind::kFailed) return Next::Fail(step.text);
  return step.kind == ServoDriveStep::Kind::kReached ? Complete(tick) : Next::Stay();
}

Next VisualServoing::OnLimit(Tick& tick) {
  if (tick.state == executing_ && drive_) return Next::Fail("Timeout: " + drive_->PlaceText());
  return Next::Fail(Missing(tick.parameters).value_or("No look of " + robot_.name()));
}

void VisualServoing::OnPause() {
  drive_.reset();
  TravelSkill::OnPause();
}

}  // namespace musher::skills
