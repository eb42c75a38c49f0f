#include "musher/modules/world/process/robot_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/world/body/camera_model.hpp"
#include "musher/modules/world/body/humanoid_kinematics.hpp"
#include "musher/modules/world/sensors/sensing.hpp"

namespace musher::world {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr Color kTrunkColor{230, 236, 246};
constexpr Color kLimbColor{150, 155, 163};
constexpr Color kSensorColor{52, 56, 64};
constexpr double kHeadM = 0.6;          // over the middle of the trunk
constexpr double kMotorSpeedRadS = 10;  // in the URDF, which wants a limit
constexpr double kMotorEffortNm = 50;

Isometry3d At(const Vector3d& position_m, const Matrix3d& turned = Matrix3d::Identity()) {
  Isometry3d placement = Isometry3d::Identity();
  placement.linear() = turned;
  placement.translation() = position_m;
  return placement;
}

Isometry3d PlacementOf(const Mount& mount) {
  return At(mount.position_m, Turned(mount.yaw_rad, mount.pitch_rad, 0));
}

// Of the optical frame: z ahead, x to the right, y down.
Isometry3d PlacementOf(const CameraSpec& camera) {
  Matrix3d optical;
  optical << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return At(camera.position_m, Turned(camera.yaw_rad, camera.pitch_rad, camera.roll_rad) * optical);
}

LinkShape Cylinder(double diameter_m, double length_m, double middle_m, const Color& color) {
  return {LinkShape::Kind::kCylinder, {diameter_m, diameter_m, length_m}, {0, 0, middle_m}, color};
}

LinkShape Sphere(double diameter_m, const Color& color) {
  return {LinkShape::Kind::kSphere, Vector3d::Constant(diameter_m), {0, 0, 0}, color};
}

class Builder {
 public:
  Builder(std::string name, std::string prefix) : prefix_(std::move(prefix)) {
    model_.name = std::move(name);
  }

  void AddRoot(std::optional<LinkShape> shape) {
    model_.links.push_back({prefix_ + "base_link", std::move(shape)});
  }
  void AddFixed(const std::string& parent, const std::string& child, const Isometry3d& origin,
                std::optional<LinkShape> shape = std::nullopt) {
    Add({prefix_ + child + "_joint", parent, prefix_ + child, origin, std::nullopt,
         Vector3d::Zero()},
        std::move(shape));
  }
  // A child of the whole name `child`.
  void AddAlias(const std::string& parent, const std::string& child) {
    Add({child + "_joint", parent, child, Isometry3d::Identity(), std::nullopt, Vector3d::Zero()},
        std::nullopt);
  }
  // Returns the name of the child: that of the joint without its number.
  std::string AddTurning(const std::string& parent, std::size_t joint, const Vector3d& origin_m,
                         const Vector3d& axis, std::optional<LinkShape> shape = std::nullopt) {
    const std::string name(JointTable().at(joint).name);
    std::string child = prefix_ + name.substr(name.find('_') + 1);
    Add({name, parent, child, At(origin_m), joint, axis}, std::move(shape));
    return child;
  }

  std::string root() const { return model_.links.front().name; }
  RobotModel Take() { return std::move(model_); }

 private:
  void Add(ModelJoint joint, std::optional<LinkShape> shape) {
    model_.links.push_back({joint.child, std::move(shape)});
    model_.joints.push_back(std::move(joint));
  }

  const std::string prefix_;
  RobotModel model_;
};

// The links of a humanoid whose lengths are `scale` times those of its kinematics.
void AddLimbs(Builder& model, double scale) {
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
  const auto limb = [scale](double length_m, double diameter_m) {
    return Cylinder(diameter_m * scale, length_m * scale, -length_m * scale / 2, kLimbColor);
  };
  const auto down = [scale](double length_m) { return Vector3d(0, 0, -length_m * scale); };
  const std::string torso =
      model.AddTurning(model.root(), kWaistYaw, {0, 0, 0}, z,
                       LinkShape{LinkShape::Kind::kBox, Vector3d(0.2, 0.32, 0.5) * scale,
                                 Vector3d(0, 0, 0.2) * scale, kTrunkColor});
  model.AddTurning(torso, kHeadYaw, Vector3d(0, 0, kHeadM) * scale, z,
                   Sphere(0.24 * scale, kTrunkColor));
  for (std::size_t side = 0; side < kSides; ++side) {
    const double left = side == 0 ? 1 : -1;
    std::size_t joint = side * 6;
    const double hip_up_m = kThighM + kShankM + kAnkleM - kTrunkM;
    std::string link =
        model.AddTurning(model.root(), joint++, Vector3d(0, left * 0.09, hip_up_m) * scale, y);
    link = model.AddTurning(link, joint++, {0, 0, 0}, x);
    link = model.AddTurning(link, joint++, {0, 0, 0}, z, limb(kThighM, 0.15));
    link = model.AddTurning(link, joint++, down(kThighM), y, limb(kShankM, 0.12));
    link = model.AddTurning(link, joint++, down(kShankM), y);
    model.AddTurning(link, joint, {0, 0, 0}, x,
                     LinkShape{LinkShape::Kind::kBox, Vector3d(0.25, 0.11, 0.06) * scale,
                               Vector3d(0.04, 0, -0.03) * scale, kLimbColor});
    joint = 13 + side * 5;
    link = model.AddTurning(torso, joint++, Vector3d(0, left * 0.21, 0.4) * scale, y);
    link = model.AddTurning(link, joint++, {0, 0, 0}, x);
    link = model.AddTurning(link, joint++, {0, 0, 0}, z, limb(kUpperArmM, 0.1));
    link = model.AddTurning(link, joint++, down(kUpperArmM), y);
    link = model.AddTurning(link, joint, {0, 0, 0}, z, limb(kForearmM, 0.09));
    model.AddFixed(link, side == 0 ? "hand_l" : "hand_r", At(down(kForearmM)),
                   Sphere(0.09 * scale, kSensorColor));
  }
}

void AddSensors(Builder& model, const Scene& scene) {
  const SensorSpecs& sensors = scene.sensors;
  if (sensors.lidar.enabled) {
    model.AddFixed(model.root(), "laser_frame", PlacementOf(sensors.lidar.mount),
                   Cylinder(0.06, 0.04, 0, kSensorColor));
  }
  if (sensors.ultrasonic.enabled) {
    model.AddFixed(model.root(), "ultrasonic_frame", PlacementOf(sensors.ultrasonic.mount));
  }
  for (std::size_t i = 0; i < kCameras; ++i) {
    const CameraSpec& camera = scene.cameras.cameras[i];
    if (!camera.enabled || camera.on != CameraMount::kBody) continue;
    model.AddFixed(model.root(), "camera_" + std::string(kCameraNames[i]), PlacementOf(camera));
  }
}

// "1 0 -0.25", without a negative zero.
std::string Text(const Vector3d& numbers) {
  constexpr double kLeast = 1e-9;
  std::string text;
  for (const double number : {numbers.x(), numbers.y(), numbers.z()}) {
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), "%.9g", std::abs(number) < kLeast ? 0 : number);
    text += (text.empty() ? "" : " ") + std::string(digits.data());
  }
  return text;
}

std::string Text(double number) {
  const std::string three = Text(Vector3d(number, 0, 0));
  return three.substr(0, three.find(' '));
}

// Roll, pitch and yaw.
Vector3d AnglesOf(const Matrix3d& turned) {
  return {std::atan2(turned(2, 1), turned(2, 2)), std::asin(std::clamp(-turned(2, 0), -1.0, 1.0)),
          std::atan2(turned(1, 0), turned(0, 0))};
}

std::string UrdfOf(const ModelLink& link) {
  if (!link.shape) return "  <link name=\"" + link.name + "\"/>\n";
  const LinkShape& shape = *link.shape;
  std::string geometry;
  switch (shape.kind) {
    case LinkShape::Kind::kBox:
      geometry = "<box size=\"" + Text(shape.size_m) + "\"/>";
      break;
    case LinkShape::Kind::kCylinder:
      geometry = "<cylinder radius=\"" + Text(shape.size_m.x() / 2) + "\" length=\"" +
                 Text(shape.size_m.z()) + "\"/>";
      break;
    case LinkShape::Kind::kSphere:
      geometry = "<sphere radius=\"" + Text(shape.size_m.x() / 2) + "\"/>";
      break;
  }
  const Vector3d color(shape.color.red / 255.0, shape.color.green / 255.0,
                       shape.color.blue / 255.0);
  return "  <link name=\"" + link.name + "\">\n    <visual>\n      <origin xyz=\"" +
         Text(shape.middle_m) + "\" rpy=\"0 0 0\"/>\n      <geometry>" + geometry +
         "</geometry>\n      <material name=\"" + link.name + "_color\"><color rgba=\"" +
         Text(color) + " 1\"/></material>\n    </visual>\n  </link>\n";
}

std::string UrdfOf(const ModelJoint& joint) {
  std::string text = "  <joint name=\"" + joint.name + "\" type=\"" +
                     (joint.angle ? "revolute" : "fixed") + "\">\n    <parent link=\"" +
                     joint.parent + "\"/>\n    <child link=\"" + joint.child +
                     "\"/>\n    <origin xyz=\"" + Text(joint.origin.translation()) + "\" rpy=\"" +
                     Text(AnglesOf(joint.origin.linear())) + "\"/>\n";
  if (joint.angle) {
    const Joint& limits = JointTable().at(*joint.angle);
    text += "    <axis xyz=\"" + Text(joint.axis) + "\"/>\n    <limit lower=\"" +
            Text(limits.least_rad) + "\" upper=\"" + Text(limits.most_rad) + "\" velocity=\"" +
            Text(kMotorSpeedRadS) + "\" effort=\"" + Text(kMotorEffortNm) + "\"/>\n";
  }
  return text + "  </joint>\n";
}

}  // namespace

Isometry3d PlacementOnHead(const Scene& scene, CameraSpec camera, double pitch_rad) {
  camera.position_m.z() -= kHeadM * scene.body.stand_height_m / kTrunkM;
  camera.pitch_rad += pitch_rad;
  return PlacementOf(camera);
}

RobotModel ModelOf(const RobotSpec& robot) {
  Builder model(robot.name, robot.name + "/");
  model.AddRoot(Cylinder(2 * robot.radius_m, robot.height_m, robot.height_m / 2, robot.color));
  model.AddAlias(model.root(), robot.name);
  if (robot.lidar.enabled) {
    model.AddFixed(model.root(), "lidar", PlacementOf(robot.lidar.mount),
                   Cylinder(0.06, 0.04, 0, kSensorColor));
  }
  if (robot.camera && robot.camera->enabled) {
    model.AddFixed(model.root(), "camera", PlacementOf(*robot.camera));
  }
  if (robot.range_down) {
    model.AddFixed(model.root(), "range_down",
                   At(robot.range_down->position_m, Turned(0, M_PI / 2, 0)));
  }
  if (robot.hand) {
    model.AddFixed(model.root(), "hand", At(robot.hand->position_m), Sphere(0.06, kSensorColor));
  }
  return model.Take();
}

RobotModel ModelOfBody(const Scene& scene) {
  Builder model("body", "");
  if (scene.humanoid) {
    const double scale = scene.body.stand_height_m / kTrunkM;
    model.AddRoot(LinkShape{LinkShape::Kind::kBox, Vector3d(0.2, 0.28, 0.14) * scale,
                            Vector3d(0, 0, -0.03) * scale, kLimbColor});
    AddLimbs(model, scale);
  } else {
    model.AddRoot(LinkShape{LinkShape::Kind::kBox,
                            {2 * scene.body.radius_m, 0.75 * scene.body.radius_m, 0.12},
                            {0, 0, 0},
                            kTrunkColor});
  }
  AddSensors(model, scene);
  return model.Take();
}

std::string ToUrdf(const RobotModel& model) {
  std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"" + model.name + "\">\n";
  for (const ModelLink& link : model.links) text += UrdfOf(link);
  for (const ModelJoint& joint : model.joints) text += UrdfOf(joint);
  return text + "</robot>\n";
}

msg::TransformStamped TransformOf(const std::string& parent, const std::string& child,
                                  const Isometry3d& placement, Duration at) {
  msg::TransformStamped transform;
  transform.header = {msg::ToStamp(at), parent};
  transform.child_frame_id = child;
  const Vector3d& origin_m = placement.translation();
  transform.transform.translation = {origin_m.x(), origin_m.y(), origin_m.z()};
  const Eigen::Quaterniond turned(placement.linear());
  transform.transform.rotation = {turned.x(), turned.y(), turned.z(), turned.w()};
  return transform;
}

msg::TransformStamped TransformOf(const ModelJoint& joint, const Angles& angles, Duration at) {
  Isometry3d placement = joint.origin;
  if (joint.angle) placement.rotate(AngleAxisd(angles.at(*joint.angle), joint.axis));
  return TransformOf(joint.parent, joint.child, placement, at);
}

}  // namespace musher::world
