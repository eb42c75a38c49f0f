#pragma once
// The velocity commands of a robot: the last one is published 20 times a second until it is
// replaced or stopped. Stop() publishes 0 once and then nothing more; without commands the robot
// itself stops.
//
// Threads: the loop's.

#include <utility>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class VelocityOutput {
 public:
  static constexpr Duration kPeriod = Milliseconds(50);

  // Both must outlive it. Null: there is no publisher.
  VelocityOutput(transport::Publisher<msg::Twist>* publisher, transport::Clock& clock)
      : publisher_(publisher), clock_(clock) {}

  void Set(const navigation::Velocity& command) {
    const bool changed = !sending_ || !(command == command_);
    command_ = command;
    if (changed) Publish();
    if (!sending_) sending_ = clock_.Every(kPeriod, [this] { Publish(); });
  }
  void Stop() {
    sending_.reset();
    command_ = {};
    Publish();
  }

 private:
  // A command that is lost is followed by the next; after a lost 0 the robot stops by itself.
  void Publish() {
    if (publisher_ != nullptr) static_cast<void>(publisher_->Publish(ToMessage(command_)));
  }

  transport::Publisher<msg::Twist>* const publisher_;
  transport::Clock& clock_;
  navigation::Velocity command_;
  transport::LoopHandlePtr sending_;
};

}  // namespace musher::skills
