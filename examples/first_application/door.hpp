#pragma once
// The door as an actuator of the robot.

#include <functional>

#include "door_states.hpp"
#include "musher/application/fsm_actuator.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/transport/endpoints.hpp"

class Door : public musher::FsmActuator {
 public:
  Door() : FsmActuator("door", {.rate_hz = 50}) {}

  using FsmActuator::ticking;  // for its test

 private:
  musher::Result<> BuildMachine(fsm::Machine& machine) override {
    return BuildDoor(machine, door_);
  }
  void OpenTopics(musher::transport::Endpoints& topics) override {
    topics.Subscribe<musher::msg::String>("door/command", [this](const musher::msg::String& word) {
      if (const musher::Result<> sent = Send(word.data); !sent) Log(sent.error().message);
    });
    topics.Subscribe<musher::msg::Bool>("door/obstacle", [this](const musher::msg::Bool& obstacle) {
      door_.obstacle = obstacle.data;
    });
    publish_opening_ = topics.PublishFunction<musher::msg::Float32>("door/opening");
  }
  void AfterTick(musher::Time) override { publish_opening_({static_cast<float>(door_.opening)}); }

  DoorData door_;
  std::function<void(const musher::msg::Float32&)> publish_opening_;
};
