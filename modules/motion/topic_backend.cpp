#include "musher/modules/motion/topic_backend.hpp"

#include <utility>

#include "musher/modules/motion/motion_wire.hpp"

namespace musher::motion {

Result<std::unique_ptr<TopicBackend>> TopicBackend::Make(transport::Node& node,
                                                         const std::string& name_space,
                                                         OnBody on_body) {
  std::unique_ptr<TopicBackend> backend(new TopicBackend(node, name_space));
  transport::Endpoints& endpoints = backend->endpoints_;
  backend->commands_ = endpoints.Advertise<msg::MotionCustomCommand>("world/body_command");
  endpoints.Subscribe<msg::BodyState>(
      "world/body_state",
      [on_body = std::move(on_body)](const msg::BodyState& state) { on_body(FromWire(state)); });
  if (!endpoints.opened()) return endpoints.opened().error();
  return backend;
}

void TopicBackend::Send(const BodyCommand& command) {
  // A command that cannot be published is repeated, or times out with a code.
  static_cast<void>(commands_->Publish(ToWire(command)));
}

}  // namespace musher::motion
