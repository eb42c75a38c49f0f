#include "musher/test/modules/skills/fake_robot.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "musher/behavior/skill/snapshot.hpp"
#include "musher/modules/skills/skills/body_skills.hpp"

namespace musher::skills::testing {
namespace {

constexpr Duration kStep = std::chrono::milliseconds(100);

double Approached(double value, double target, double share) {
  return value + (target - value) * share;
}

}  // namespace

void FakeRobot::Advance(Duration step) {
  now_ += step;
  constexpr int kParts = 10;
  const double part_s = ToSeconds(step) / kParts;
  for (int i = 0; i < kParts; ++i) Move(part_s);
  const auto due = std::exchange(due_, {});
  for (const auto& work : due) work();
}

void FakeRobot::Move(double step_s) {
  const double c = std::cos(body.yaw_rad);
  const double s = std::sin(body.yaw_rad);
  const double share = 1 - std::exp(-step_s / lag_s);
  motion.x_m_s = Approached(motion.x_m_s, c * command.x_m_s - s * command.y_m_s, share);
  motion.y_m_s = Approached(motion.y_m_s, s * command.x_m_s + c * command.y_m_s, share);
  motion.z_m_s = Approached(motion.z_m_s, command.z_m_s, share);
  motion.yaw_rad_s = Approached(motion.yaw_rad_s, command.yaw_rad_s, share);
  const bool flies = body.at.z_m > ground_m;
  body.at.x_m += (motion.x_m_s + (flies ? wind.x_m_s : 0)) * step_s;
  body.at.y_m += (motion.y_m_s + (flies ? wind.y_m_s : 0)) * step_s;
  body.at.z_m += (motion.z_m_s + (flies ? wind.z_m_s : 0)) * step_s;
  body.yaw_rad = navigation::Wrapped(body.yaw_rad + motion.yaw_rad_s * step_s);
  const double lowest_m = std::max(ground_m, stopped_above_m);
  if (body.at.z_m > lowest_m) return;
  body.at.z_m = lowest_m;
  motion.z_m_s = std::max(motion.z_m_s, 0.0);
}

SeenObject& FakeRobot::Object(const std::string& name) {
  return *std::ranges::find(seen, name, &SeenObject::name);
}

std::string FakeRobot::Held() const {
  const auto held = std::ranges::find(seen, name_, &SeenObject::held_by);
  return held == seen.end() ? "" : held->name;
}

std::optional<Look> FakeRobot::LookFor(const std::string& target) {
  if (!has_detector) return std::nullopt;
  Look look{now_, {}};
  const double c = std::cos(body.yaw_rad), s = std::sin(body.yaw_rad);
  for (const SeenObject& object : seen) {
    if (object.name != target && object.category != target) continue;
    const double x = object.pose.at.x_m - body.at.x_m, y = object.pose.at.y_m - body.at.y_m;
    look.seen.push_back({c * x + s * y, c * y - s * x, object.pose.at.z_m - body.at.z_m});
  }
  return look;
}

template <class T>
skill::Future<T> FakeRobot::Later(Reply reply, std::function<T()> work) {
  auto source = std::make_shared<skill::Source<T>>();
  skill::Future<T> future = source->future();
  if (reply == Reply::kNever) {
    unanswered_.push_back(source);
  } else if (reply != Reply::kAbandoned) {
    due_.push_back([reply, source, work = std::move(work)] {
      if (reply == Reply::kFails) return source->Fail("the device has failed");
      source->Finish(work());
    });
  }
  return future;
}

bool FakeRobot::HasCamera(const std::string& camera) const {
  return std::ranges::find(camera_names, camera) != camera_names.end();
}

skill::Future<Picture> FakeRobot::TakePicture(const std::string& camera) {
  EXPECT_TRUE(HasCamera(camera)) << camera;
  ++pictures_taken;
  return Later<Picture>(camera_replies, [this] { return picture; });
}

skill::Future<std::string> FakeRobot::SavePng(const Picture& saved, const std::string& path) {
  return Later<std::string>(file_replies, [this, saved, path] {
    files[path] = saved;
    return path;
  });
}

skill::Future<HandReply> FakeRobot::UseHand(const HandRequest& request) {
  hand_requests.push_back(request);
  return Later<HandReply>(hand_replies(request), [this, request] { return Use(request); });
}

HandReply FakeRobot::Use(const HandRequest& request) {
  const auto object = std::ranges::find(seen, request.object, &SeenObject::name);
  if (object == seen.end()) return {false, "there is no object '" + request.object + "'"};
  const double distance_m = navigation::Distance(object->pose.at, body.at);
  switch (request.action) {
    case HandAction::kCheckDistance:
    case HandAction::kAttach:
      if (distance_m > reach_m) return {false, "Too far: the hand does not reach it", distance_m};
      if (distance_m > request.distance_threshold_m) return {false, "no", distance_m};
      if (request.action == HandAction::kCheckDistance) {
        return {true, "Within grasp distance", distance_m};
      }
      if (!object->held_by.empty()) return {false, "held by " + object->held_by};
      if (!slips) object->held_by = name_;
      return {true, "Object attached", distance_m};
    case HandAction::kRelease:
      if (object->held_by != name_) return {false, "Joint not found: " + request.object};
      object->held_by.clear();
      object->pose.at = body.at;
      return {true, "Object released"};
    case HandAction::kPlace:
      break;
  }
  if (object->held_by != name_) return {false, name_ + " does not hold " + request.object};
  if (navigation::Distance(request.target, body.at) > reach_m) {
    return {false, "Too far: the hand does not reach the target",
            navigation::Distance(request.target, body.at)};
  }
  object->held_by.clear();
  object->pose.at = request.target;
  if (slips) object->pose.at.x_m += 0.5;
  return {true, "Object placed"};
}

Bench::Bench(const std::string& name, const std::string& kind) : robot(name, kind) {
  const Result<> registered = RegisterBodySkills(registry_, robot);
  EXPECT_TRUE(registered.ok()) << registered.error().message;
  manager_ = std::make_unique<skill::Manager>(registry_.All());
}

void Bench::Start(const std::string& skill, const skill::Values& parameters) {
  messages.clear();
  skill_ = skill;
  const Result<> started = manager_->Start(skill, parameters);
  ASSERT_TRUE(started.ok()) << started.error().message;
}

void Bench::Step() {
  now_ += kStep;
  robot.Advance(kStep);
  manager_->RunOnce(now_);
  if (skill_.empty() || manager_->Find(skill_) == nullptr) return;
  std::string message = std::to_string(feedback().progress) + " " + feedback().message;
  if (messages.empty() || messages.back() != message) messages.push_back(std::move(message));
}

void Bench::StepFor(double seconds) {
  const auto steps = std::lround(seconds * 10);
  for (long i = 0; i < steps; ++i) Step();
}

void Bench::Restore() {
  const auto saved = manager_->Save();
  ASSERT_TRUE(saved.ok()) << saved.error().message;
  manager_.reset();
  registry_ = {};
  ASSERT_TRUE(RegisterBodySkills(registry_, robot).ok());
  manager_ = std::make_unique<skill::Manager>(registry_.All());
  ASSERT_TRUE(manager_->Restore(saved.value()).empty());
}

const skill::Feedback& Bench::RunOut() {
  constexpr int kMostSteps = 3000;
  for (int i = 0; i < kMostSteps && run().running(); ++i) Step();
  EXPECT_TRUE(run().ended());
  return feedback();
}

const skill::Feedback& Bench::Execute(const std::string& skill, const skill::Values& parameters) {
  Start(skill, parameters);
  return RunOut();
}

}  // namespace musher::skills::testing
