#include "musher/modules/world/simulation/world.hpp"

#include <cmath>
#include <iterator>
#include <type_traits>
#include <utility>

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/scene/place.hpp"
#include "musher/modules/world/simulation/text.hpp"

namespace musher::world {
bool IsDue(Duration now, double rate_hz) {
  const auto period = FromSeconds(1 / rate_hz);
  return now / period != (now - kStep) / period;
}

World::World(Scene scene)
    : scene_(std::make_shared<const Scene>(std::move(scene))),
      random_(scene_->seed),
      body_(*scene_),
      battery_(scene_->battery),
      guests_(*scene_),
      fleet_(*scene_),
      referee_(*scene_, Seen()),
      hide_at_(scene_->balls.size()) {
  if (scene_->humanoid) humanoid_.emplace(*scene_->humanoid);
  if (scene_->field) field_.emplace(*scene_->field);
  Record();
}

StepOutputs World::Step() {
  StepOutputs outputs;
  now_ += kStep;
  while (next_event_ < scene_->events.size() && scene_->events[next_event_].at <= now_) {
    Apply(scene_->events[next_event_++], outputs);
  }
  if (scene_->has_body) StepBody(outputs);
  StepBalls(outputs);
  if (scene_->has_body) referee_.Step(*scene_, Seen(), now_);
  if (humanoid_) humanoid_->Step(kStep);
  const Robot robot{body_.pose().position_m, scene_->body.radius_m, CameraPose(0).translation()};
  guests_.Step(*scene_, robot, now_, kStep);
  std::vector<std::string> log = fleet_.Step(*scene_, BodySolid(), now_, kStep);
  std::move(log.begin(), log.end(), std::back_inserter(outputs.log));
  if (field_) {
    log = field_->Step(silent_, now_, kStep);
    std::move(log.begin(), log.end(), std::back_inserter(outputs.log));
  }
  if (track_.IsDue(now_)) Record();
  return outputs;
}

void World::StepBody(StepOutputs& outputs) {
  const bool was_empty = supply_.battery_empty;
  battery_.Step(kStep, body_.activity(), on_pad());
  supply_.battery_empty = battery_.empty();
  if (supply_.battery_empty && !was_empty) outputs.log.emplace_back("the battery is empty");

  body_.Step(*scene_, supply_, now_, kStep, random_);
  if (body_.bumped() && !touching_) {
    track_.AddBump({now_, body_.pose().position_m});
    referee_.Collide();
    outputs.log.push_back("the body bumped into something at " +
                          PointText(body_.pose().position_m));
  }
  touching_ = body_.bumped();
}

std::vector<Solid> World::BodySolid() const {
  if (!scene_->has_body) return {};
  const BodySpec& body = scene_->body;
  return {{"the body of the world",
           Circle{"", body_.pose().position_m, body.radius_m, body.stand_height_m, 0, {}}}};
}

std::optional<std::size_t> World::FindRobot(const std::string& name) const {
  for (std::size_t i = 0; i < scene_->robots.size(); ++i) {
    if (scene_->robots[i].name == name) return i;
  }
  return std::nullopt;
}

std::optional<std::string> World::Command(const BoardCommand& command) {
  return body_.Take(*scene_, command, now_);
}

std::optional<std::string> World::SetBattery(double percent) {
  if (!(percent >= 0 && percent <= 100)) {
    return "a battery of " + NumberText(percent) + " % is refused: expected 0 to 100";
  }
  Record();
  battery_.Set(percent);
  Record();
  return std::nullopt;
}

void World::Plug(bool in) {
  battery_.Plug(in);
  Record();
}

std::optional<std::string> World::PutDown(const Pose2& at) {
  if (field_) return field_->PutDown(at.position_m, at.yaw_rad, now_);
  if (!at.position_m.allFinite() || !std::isfinite(at.yaw_rad)) {
    return "a place that is not a number is refused";
  }
  if (!IsFree(*scene_, at.position_m)) {
    return "the body cannot be at " + PointText(at.position_m) +
           ": an obstacle is in the way, or it is outside";
  }
  Record();
  body_.PutDown({at.position_m, std::remainder(at.yaw_rad, 2 * M_PI)});
  referee_.Carry(*scene_, Seen(), now_);
  Record();
  return std::nullopt;
}

void World::SetFault(const FaultKind& fault, std::size_t motor) {
  if (&fault == &Faults().front()) silent_.clear();
  body_.SetFault(fault, motor);
}

std::optional<std::string> World::SetPose(const std::string& name) {
  return humanoid_ ? humanoid_->SetPose(name) : std::nullopt;
}

std::optional<std::string> World::LookAt(const Eigen::Vector2d& point) {
  return humanoid_ ? humanoid_->LookAt(point) : std::nullopt;
}

void World::SetLight(int target, const Light& light) {
  track_.SetLight(target, light);
}

Eigen::Isometry3d World::CameraPose(std::size_t index) const {
  return CameraInPlace(scene_->cameras.cameras.at(index), body_.pose(), body_.attitude(), gaze());
}

bool World::on_pad() const {
  return IsOnPad(*scene_, body_.pose().position_m);
}

void World::Apply(const SceneEvent& event, StepOutputs& outputs) {
  const auto objection = std::visit(
      [&](const auto& what) -> std::optional<std::string> {
        using What = std::decay_t<decltype(what)>;
        if constexpr (std::is_same_v<What, ChargeTo>) {
          return SetBattery(what.percent);
        } else if constexpr (std::is_same_v<What, Cable>) {
          Plug(what.in);
        } else if constexpr (std::is_same_v<What, Touch>) {
          outputs.touches.push_back(what.state);
        } else if constexpr (std::is_same_v<What, FaultOn>) {
          if (const FaultKind* fault = FindFault(what.name)) {
            SetFault(*fault, static_cast<std::size_t>(what.motor));
          } else {
            Silence(what.name);
          }
        } else if constexpr (std::is_same_v<What, Carry>) {
          return PutDown(what.at);
        } else if constexpr (std::is_same_v<What, Show>) {
          return SetShown(what.name, what.shown);
        } else {
          outputs.speed = what.factor;
        }
        return std::nullopt;
      },
      event.what);
  if (objection) outputs.log.push_back(*objection);
}

// A ball with show_within_m appears at the robot's first approach, and only then.
void World::StepBalls(StepOutputs& outputs) {
  for (std::size_t i = 0; i < hide_at_.size(); ++i) {
    const Ball& ball = scene_->balls[i];
    const double far_m = (ball.center_m.head<2>() - body_.pose().position_m).norm();
    if (!hide_at_[i] && far_m < ball.show_within_m) {
      hide_at_[i] = now_ + ball.show_for;
      outputs.log.push_back(ball.name + " appears");
      SetShown(i, true);
    } else if (ball.shown && hide_at_[i] && now_ >= *hide_at_[i]) {
      outputs.log.push_back(ball.name + " disappears");
      SetShown(i, false);
    }
  }
}

std::optional<std::string> World::SetShown(const std::string& ball, bool shown) {
  for (std::size_t i = 0; i < scene_->balls.size(); ++i) {
    if (ball.empty() || scene_->balls[i].name != ball) continue;
    SetShown(i, shown);
    return std::nullopt;
  }
  return "there is no ball with the name \"" + ball.substr(0, 60) + "\"";
}

// Copies share the scene: it is replaced, never changed.
void World::SetShown(std::size_t ball, bool shown) {
  if (scene_->balls[ball].shown == shown) return;
  auto changed = std::make_shared<Scene>(*scene_);
  changed->balls[ball].shown = shown;
  scene_ = std::move(changed);
}

RobotSeen World::Seen() const {
  constexpr double kNearlyM = 0.02;
  const Activity activity = body_.activity();
  const bool down = body_.attitude().height_m < scene_->body.lie_height_m + kNearlyM;
  return {body_.pose(), down && (activity == Activity::kLying || activity == Activity::kOff),
          body_.in_the_air()};
}

void World::Record() {
  Sample sample;
  sample.at = now_;
  sample.pose = body_.pose();
  sample.battery_percent = battery_.percent();
  sample.charging = battery_.charging();
  // A board that could walk and does not walk stands.
  const Motion* motion = FindMotion(body_.mode(), body_.gait());
  const bool idle = motion->kind == Kind::kWalk && body_.activity() == Activity::kStanding;
  track_.Add(sample, machine_state_, idle ? "stand" : NameOf(body_.mode(), body_.gait()));
}

}  // namespace musher::world
