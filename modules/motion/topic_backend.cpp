#include "musher/modules/motion/topic_backend.hpp"

#include <utility>

#include "musher/modules/motion/motion_core.hpp"
#include "musher/modules/motion/motion_wire.hpp"

namespace musher::motion {

Result<std::unique_ptr<TopicBackend>> TopicBackend::Make(transport::Node& node,
                                                         const std::string& name_space,
                                                         OnBody on_body, OnFault on_fault) {
  std::unique_ptr<TopicBackend> backend(
      new TopicBackend(node, name_space, std::move(on_body), std::move(on_fault)));
  transport::Endpoints& endpoints = backend->endpoints_;
  backend->commands_ = endpoints.Advertise<msg::MotionCustomCommand>("world/body_command");
  endpoints.Subscribe<msg::BodyState>(
      "world/body_state",
      [made = backend.get()](const msg::BodyState& state) { made->OnReport(state); });
  if (!endpoints.opened()) return endpoints.opened().error();
  return backend;
}

void TopicBackend::OnReport(const msg::BodyState& state) {
  if (IsFinite(state)) return on_body_(FromWire(state));
  const Time now = loop_.Now();
  if (dropped_logged_ && now - *dropped_logged_ < kLogPause) return;
  dropped_logged_ = now;
  on_fault_(MotionCode(KeyCode::kParametersInvalid),
            "a report on " + source_ + " is dropped: a number is NaN or infinite");
}

void TopicBackend::Send(const BodyCommand& command) {
  // A command that cannot be published is repeated, or times out with a code.
  static_cast<void>(commands_->Publish(ToWire(command)));
}

}  // namespace musher::motion
