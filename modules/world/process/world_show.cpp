#include "musher/modules/world/process/world_show.hpp"

#include <utility>

#include "musher/modules/world/process/world_messages.hpp"
#include "musher/modules/world/sensors/gesture_sight.hpp"

namespace musher::world {
namespace {

constexpr double kGestureHz = 10;

}  // namespace

Result<std::unique_ptr<WorldShow>> WorldShow::Make(transport::Node& node, World& world,
                                                   const std::string& name_space,
                                                   std::function<void(const std::string&)> log) {
  std::unique_ptr<WorldShow> show(new WorldShow(world, std::move(log)));
  if (auto connected = show->Connect(node, name_space); !connected) return connected.error();
  return show;
}

Result<> WorldShow::Connect(transport::Node& node, const std::string& name_space) {
  const Scene& scene = world_.scene();
  if (scene.humanoid) {
    if (auto connected = ConnectHumanoid(node, name_space); !connected) return connected;
  }
  if (scene.guests.empty()) return Ok();
  auto gestures = transport::MakePublisher<msg::String>(
      node, transport::ResolveName(name_space, scene.gesture_topic));
  if (!gestures) return gestures.error();
  gestures_ = std::move(gestures).value();
  return Ok();
}

Result<> WorldShow::ConnectHumanoid(transport::Node& node, const std::string& name_space) {
  const HumanoidSpec& spec = *world_.scene().humanoid;
  const auto publish = [&](PublisherPtr<msg::JointState>& publisher, const std::string& topic) {
    auto made =
        transport::MakePublisher<msg::JointState>(node, transport::ResolveName(name_space, topic));
    if (!made) return Result<>(made.error());
    publisher = std::move(made).value();
    return Ok();
  };
  if (auto made = publish(joint_states_, spec.joint_states_topic); !made) return made;
  if (auto made = publish(joint_commands_, spec.joint_commands_topic); !made) return made;
  auto poses = transport::MakeSubscription<msg::String>(
      node, transport::ResolveName(name_space, spec.pose_topic),
      [this](const msg::String& message, const transport::SampleInfo&) {
        Log(world_.SetPose(message.data));
      });
  if (!poses) return poses.error();
  poses_ = std::move(poses).value();
  auto looks = transport::MakeSubscription<msg::PointStamped>(
      node, transport::ResolveName(name_space, spec.look_at_topic),
      [this](const msg::PointStamped& message, const transport::SampleInfo&) {
        Log(world_.LookAt({message.point.x, message.point.y}));
      });
  if (!looks) return looks.error();
  looks_ = std::move(looks).value();
  return Ok();
}

void WorldShow::OnStep() {
  if (const std::optional<Humanoid>& humanoid = world_.humanoid()) {
    // The next ones follow soon.
    const Duration now = world_.now();
    static_cast<void>(joint_states_->Publish(ToJointState(humanoid->joints(), now)));
    static_cast<void>(joint_commands_->Publish(ToJointState(humanoid->commands(), now)));
  }
  if (gestures_ && IsDue(world_.now(), kGestureHz)) PublishGesture();
}

// Publishes nothing while there is no gesture, so that other publishers may report gestures, too.
void WorldShow::PublishGesture() {
  const Gesture seen = SeenGesture(world_);
  if (seen == Gesture::kNone && gesture_ == Gesture::kNone) return;
  gesture_ = seen;
  const auto word = kGestureNames[static_cast<std::size_t>(seen)];
  static_cast<void>(gestures_->Publish({std::string(word)}));  // the next one follows soon
}

void WorldShow::Log(const std::optional<std::string>& line) const {
  if (line) log_(*line);
}

}  // namespace musher::world
