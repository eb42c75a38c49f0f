#pragma once
// NewApp as an actuator of the robot: its machine runs in Active, and pauses in the other states.

#include <functional>

#include "musher/application/fsm_actuator.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/transport/endpoints.hpp"
#include "new_app_states.hpp"

class NewApp : public musher::FsmActuator {
 public:
  NewApp() : FsmActuator("new_app", {.rate_hz = 50}) {}

  using FsmActuator::ticking;  // for its test

 private:
  musher::Result<> BuildMachine(fsm::Machine& machine) override {
    return BuildNewApp(machine, data_);
  }
  void OpenTopics(musher::transport::Endpoints& topics) override {
    topics.Subscribe<musher::msg::Bool>(
        "new_app/obstacle",
        [this](const musher::msg::Bool& obstacle) { data_.obstacle = obstacle.data; });
    publish_progress_ = topics.PublishFunction<musher::msg::Float32>("new_app/progress");
  }
  void AfterTick(musher::Time) override { publish_progress_({static_cast<float>(data_.progress)}); }

  NewAppData data_;
  std::function<void(const musher::msg::Float32&)> publish_progress_;
};
