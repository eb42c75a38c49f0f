#pragma once
// A body behind two topics: world/body_command and world/body_state, in the robot's namespace. The
// simulated body of modules/world is one; a bridge to a motion board would be another.

#include <memory>
#include <string>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::motion {

class TopicBackend : public MotionBackend {
 public:
  static Result<std::unique_ptr<TopicBackend>> Make(transport::Node& node,
                                                    const std::string& name_space, OnBody on_body);

  void Send(const BodyCommand& command) override;
  std::string Source() const override { return source_; }

 private:
  TopicBackend(transport::Node& node, const std::string& name_space)
      : source_(transport::ResolveName(name_space, "world/body_state")),
        endpoints_(node, name_space) {}

  const std::string source_;
  transport::Endpoints endpoints_;
  transport::Publisher<msg::MotionCustomCommand>* commands_ = nullptr;
};

}  // namespace musher::motion
