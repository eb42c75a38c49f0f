#include "musher/modules/vp_engine/nodes.hpp"

#include <chrono>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace musher::vp_engine {
namespace {

constexpr double kLongestWaitS = 86'400;

// A node that ends with a call of the robot.
class CallNode : public tree::StatefulAction {
 protected:
  CallNode(tree::Setup& setup, Robot& robot)
      : error_(setup.Output<std::string>("error", "why the robot has not done it")),
        robot_(robot) {}

  virtual Robot::Call Begin(Robot& robot) = 0;

 private:
  tree::Status OnStart(const tree::Tick& tick) override {
    error_.Set("");
    call_ = Begin(robot_);
    return OnRunning(tick);
  }
  tree::Status OnRunning(const tree::Tick&) override {
    const auto end = robot_.EndOf(call_);
    if (!end) return tree::Status::kRunning;
    if (*end) return tree::Status::kSuccess;
    error_.Set(end->error().message);
    return tree::Status::kFailure;
  }
  void OnHalted(const tree::Tick&) override { robot_.Forget(call_); }

  tree::OutPort<std::string> error_;
  Robot& robot_;
  Robot::Call call_ = 0;
};

class Say : public CallNode {
 public:
  Say(tree::Setup& setup, Robot& robot)
      : CallNode(setup, robot), text_(setup.Input<std::string>("text", "to be spoken")) {}

 private:
  Robot::Call Begin(Robot& robot) override { return robot.Speak(text_.Get()); }

  tree::InPort<std::string> text_;
};

class MotionResult : public CallNode {
 public:
  MotionResult(tree::Setup& setup, Robot& robot)
      : CallNode(setup, robot),
        id_(setup.Input<std::int32_t>("motion_id", "of the motion table")),
        duration_ms_(setup.Input<std::int32_t>("duration_ms", 0, "0: its own")),
        forwards_mps_(setup.Input<float>("forwards_mps", 0.0F, "m/s")),
        left_mps_(setup.Input<float>("left_mps", 0.0F, "m/s")),
        turn_radps_(setup.Input<float>("turn_radps", 0.0F, "rad/s, left positive")) {}

 private:
  Robot::Call Begin(Robot& robot) override {
    return robot.Move(
        {id_.Get(), duration_ms_.Get(), forwards_mps_.Get(), left_mps_.Get(), turn_radps_.Get()});
  }

  tree::InPort<std::int32_t> id_;
  tree::InPort<std::int32_t> duration_ms_;
  tree::InPort<float> forwards_mps_;
  tree::InPort<float> left_mps_;
  tree::InPort<float> turn_radps_;
};

std::uint8_t TargetOf(const std::string& name) {
  if (name == "head") return 1;
  if (name == "tail") return 2;
  if (name == "mini") return 3;
  throw std::runtime_error("port 'target': expected head, tail or mini, found '" + name + "'");
}

class Led : public CallNode {
 public:
  Led(tree::Setup& setup, Robot& robot)
      : CallNode(setup, robot),
        target_(setup.Input<std::string>("target", "head, tail or mini")),
        effect_(setup.Input<std::uint8_t>("effect", std::uint8_t{1}, "1 on, 2 blinks, 4 breathes")),
        red_(setup.Input<std::uint8_t>("red", std::uint8_t{0}, "0 to 255")),
        green_(setup.Input<std::uint8_t>("green", std::uint8_t{0}, "0 to 255")),
        blue_(setup.Input<std::uint8_t>("blue", std::uint8_t{0}, "0 to 255")) {}

 private:
  Robot::Call Begin(Robot& robot) override {
    return robot.Light(
        {TargetOf(target_.Get()), effect_.Get(), red_.Get(), green_.Get(), blue_.Get(), true});
  }

  tree::InPort<std::string> target_;
  tree::InPort<std::uint8_t> effect_;
  tree::InPort<std::uint8_t> red_;
  tree::InPort<std::uint8_t> green_;
  tree::InPort<std::uint8_t> blue_;
};

class LedRelease : public CallNode {
 public:
  LedRelease(tree::Setup& setup, Robot& robot)
      : CallNode(setup, robot), target_(setup.Input<std::string>("target", "head, tail or mini")) {}

 private:
  Robot::Call Begin(Robot& robot) override {
    return robot.Light({.target = TargetOf(target_.Get()), .on = false});
  }

  tree::InPort<std::string> target_;
};

class WaitSeconds : public tree::StatefulAction {
 public:
  explicit WaitSeconds(tree::Setup& setup)
      : seconds_(setup.Input<double>("seconds", "of the robot's time")) {}

 private:
  tree::Status OnStart(const tree::Tick& tick) override {
    const double seconds = seconds_.Get();
    if (!(seconds >= 0) || seconds > kLongestWaitS) {
      throw std::runtime_error("port 'seconds': expected 0 to 86400, found " +
                               std::to_string(seconds));
    }
    until_ = tick.now + FromSeconds(seconds);
    return OnRunning(tick);
  }
  tree::Status OnRunning(const tree::Tick& tick) override {
    return tick.now < until_ ? tree::Status::kRunning : tree::Status::kSuccess;
  }

  tree::InPort<double> seconds_;
  Time until_{};
};

}  // namespace

Result<> AddNodes(tree::Factory& factory, Robot& robot) {
  for (const Result<>& added :
       {factory.Add<Say>("Say", robot), factory.Add<MotionResult>("MotionResult", robot),
        factory.Add<Led>("Led", robot), factory.Add<LedRelease>("LedRelease", robot),
        factory.Add<WaitSeconds>("WaitSeconds")}) {
    if (!added) return added;
  }
  return Ok();
}

}  // namespace musher::vp_engine
