#include "musher/modules/motion/topic_backend.hpp"

#include <utility>

#include "musher/modules/motion/motion_wire.hpp"

namespace musher::motion {

Result<std::unique_ptr<TopicBackend>> TopicBackend::Make(transport::Node& node,
                                                         const std::string& name_space,
                                                         OnBody on_body) {
  std::unique_ptr<TopicBackend> backend(new TopicBackend());
  auto commands = transport::MakePublisher<msg::MotionCustomCommand>(
      node, transport::ResolveName(name_space, "world/body_command"));
  if (!commands) return commands.error();
  backend->commands_ = std::move(commands).value();
  auto states = transport::MakeSubscription<msg::BodyState>(
      node, transport::ResolveName(name_space, "world/body_state"),
      [on_body = std::move(on_body)](const msg::BodyState& state, const transport::SampleInfo&) {
        on_body(FromWire(state));
      });
  if (!states) return states.error();
  backend->states_ = std::move(states).value();
  return backend;
}

void TopicBackend::Send(const BodyCommand& command) {
  // A command that cannot be published is repeated, or times out with a code.
  static_cast<void>(commands_->Publish(ToWire(command)));
}

}  // namespace musher::motion
