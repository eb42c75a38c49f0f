#include "musher/modules/world/process/world_show.hpp"

#include <utility>

#include "musher/modules/world/process/world_messages.hpp"
#include "musher/modules/world/sensors/gesture_sight.hpp"

namespace musher::world {
namespace {

constexpr double kGestureHz = 10;

}  // namespace

WorldShow::WorldShow(transport::Endpoints& endpoints, World& world,
                     std::function<void(const std::string&)> log)
    : world_(world), log_(std::move(log)) {
  const Scene& scene = world_.scene();
  if (scene.humanoid) OpenHumanoid(endpoints, *scene.humanoid);
  if (!scene.guests.empty()) gestures_ = endpoints.Advertise<msg::String>(scene.gesture_topic);
}

void WorldShow::OpenHumanoid(transport::Endpoints& endpoints, const HumanoidSpec& spec) {
  joint_states_ = endpoints.Advertise<msg::JointState>(spec.joint_states_topic);
  joint_commands_ = endpoints.Advertise<msg::JointState>(spec.joint_commands_topic);
  endpoints.Subscribe<msg::String>(
      spec.pose_topic, [this](const msg::String& message) { Log(world_.SetPose(message.data)); });
  endpoints.Subscribe<msg::PointStamped>(spec.look_at_topic,
                                         [this](const msg::PointStamped& message) {
                                           Log(world_.LookAt({message.point.x, message.point.y}));
                                         });
}

void WorldShow::OnStep() {
  if (const std::optional<Humanoid>& humanoid = world_.humanoid()) {
    // The next ones follow soon.
    const Duration now = world_.now();
    static_cast<void>(joint_states_->Publish(ToJointState(humanoid->joints(), now)));
    static_cast<void>(joint_commands_->Publish(ToJointState(humanoid->commands(), now)));
  }
  if (gestures_ != nullptr && IsDue(world_.now(), kGestureHz)) PublishGesture();
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
