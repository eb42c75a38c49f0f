#include "musher/modules/world/process/world_frames.hpp"

#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/process/world_messages.hpp"
#include "musher/modules/world/sensors/fleet_sensing.hpp"

namespace musher::world {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kFramesHz = 20;
constexpr const char* kTf = "/tf";
constexpr const char* kTfStatic = "/tf_static";
// As tf2 has it.
constexpr transport::Qos kTfQos{transport::Qos::Reliability::kReliable,
                                transport::Qos::Durability::kVolatile, 100};

Isometry3d PlacementOf(const msg::Pose& pose) {
  const auto& p = pose.position;
  const auto& q = pose.orientation;
  Isometry3d placement = Isometry3d::Identity();
  placement.translate(Vector3d(p.x, p.y, p.z));
  placement.rotate(Eigen::Quaterniond(q.w, q.x, q.y, q.z));
  return placement;
}

Angles AnglesOf(const Humanoid& humanoid) {
  Angles angles{};
  for (std::size_t i = 0; i < kJoints; ++i) angles[i] = humanoid.joints()[i].position_rad;
  return angles;
}

}  // namespace

WorldFrames::WorldFrames(transport::Endpoints& endpoints, const World& world, WorldRobots& robots)
    : world_(world), robots_(robots) {
  const Scene& scene = world_.scene();
  if (!scene.has_body && scene.robots.empty()) return;
  tf_ = endpoints.Advertise<msg::TfMessage>(kTf, kTfQos);
  auto* tf_static = endpoints.Advertise<msg::TfMessage>(kTfStatic, transport::kLatchedQos);
  msg::TfMessage fixed;
  for (const RobotSpec& robot : scene.robots) {
    fixed.transforms.push_back(
        TransformOf(kMapFrame, robot.name + "/odom", Isometry3d::Identity(), world_.now()));
    Describe(endpoints, robot.name + "/robot_description", ModelOf(robot), fixed);
  }
  if (scene.has_body) Describe(endpoints, "robot_description", ModelOfBody(scene), fixed);
  if (scene.has_body && scene.humanoid) {
    joint_states_ = endpoints.Advertise<msg::JointState>("joint_states");
  }
  // A latched sample that cannot be sent is the same fault as a topic that cannot be opened.
  if (endpoints.opened()) static_cast<void>(tf_static->Publish(fixed));
}

void WorldFrames::Describe(transport::Endpoints& endpoints, const std::string& topic,
                           const RobotModel& model, msg::TfMessage& fixed) {
  for (const ModelJoint& joint : model.joints) {
    if (joint.angle) {
      joints_.push_back(joint);
    } else {
      fixed.transforms.push_back(TransformOf(joint, {}, world_.now()));
    }
  }
  auto* description = endpoints.Advertise<msg::String>(topic, transport::kLatchedQos);
  if (description != nullptr) static_cast<void>(description->Publish({ToUrdf(model)}));
}

msg::TfMessage WorldFrames::Moving() const {
  const Scene& scene = world_.scene();
  const Duration now = world_.now();
  msg::TfMessage moving;
  for (std::size_t i = 0; i < scene.robots.size(); ++i) {
    const std::string& name = scene.robots[i].name;
    const Isometry3d placement = PlacementOf(robots_.OdometryOf(i).pose.pose);
    moving.transforms.push_back(TransformOf(name + "/odom", name + "/base_link", placement, now));
  }
  if (!scene.has_body) return moving;
  // By its own odometry, which drifts; a localisation says by how much.
  const Isometry3d body = BodyInPlace(world_.body().odometry(), world_.body().attitude());
  if (scene.localised) {
    const Isometry3d in_place = BodyInPlace(world_.body().pose(), world_.body().attitude());
    moving.transforms.push_back(TransformOf(kMapFrame, "odom", in_place * body.inverse(), now));
  }
  moving.transforms.push_back(TransformOf("odom", "base_link", body, now));
  if (!world_.humanoid()) return moving;
  const Angles angles = AnglesOf(*world_.humanoid());
  for (const ModelJoint& joint : joints_) {
    moving.transforms.push_back(TransformOf(joint, angles, now));
  }
  for (std::size_t i = 0; i < kCameras; ++i) {
    const CameraSpec& camera = scene.cameras.cameras[i];
    if (!camera.enabled || camera.on != CameraMount::kHead) continue;
    const double pitch_rad = world_.humanoid()->gaze().pitch_rad;
    moving.transforms.push_back(TransformOf("head_yaw", "camera_" + std::string(kCameraNames[i]),
                                            PlacementOnHead(scene, camera, pitch_rad), now));
  }
  return moving;
}

void WorldFrames::OnStep() {
  if (tf_ == nullptr || !IsDue(world_.now(), kFramesHz)) return;
  // The next ones follow soon.
  if (tf_->MatchedReaders() > 0) static_cast<void>(tf_->Publish(Moving()));
  if (joint_states_ != nullptr && joint_states_->MatchedReaders() > 0) {
    static_cast<void>(
        joint_states_->Publish(ToJointState(world_.humanoid()->joints(), world_.now())));
  }
}

}  // namespace musher::world
