#pragma once
// A body behind two topics: world/body_command and world/body_state, in the robot's namespace. The
// simulated body of modules/world is one; a bridge to a motion board would be another.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/modules/motion/motion_backend.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::motion {

class TopicBackend : public MotionBackend {
 public:
  // Gets the code and the sentence of a fault of the board, the same one at most every 3 minutes.
  using OnFault = std::function<void(std::int32_t code, const std::string& text)>;

  static Result<std::unique_ptr<TopicBackend>> Make(transport::Node& node,
                                                    const std::string& name_space, OnBody on_body,
                                                    OnFault on_fault);

  void Send(const BodyCommand& command) override;
  std::string Source() const override { return source_; }

 private:
  TopicBackend(transport::Node& node, const std::string& name_space, OnBody on_body,
               OnFault on_fault)
      : loop_(node.loop()),
        source_(transport::ResolveName(name_space, "world/body_state")),
        on_body_(std::move(on_body)),
        on_fault_(std::move(on_fault)),
        endpoints_(node, name_space) {}

  void OnReport(const msg::BodyState& state);

  transport::EventLoop& loop_;
  const std::string source_;
  const OnBody on_body_;
  const OnFault on_fault_;
  std::optional<Time> dropped_logged_;
  transport::Publisher<msg::MotionCustomCommand>* commands_ = nullptr;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::motion
