#pragma once
// The robots of a world as RViz shows them: links with their shapes, the joints between them, the
// URDF of both, and the transforms of tf. Links are frames, so their names have the robot's name
// before them.
//
//   R/base_link - R, R/lidar, R/camera, R/hand                 of a robot R, all fixed
//   base_link - laser_frame, ultrasonic_frame, tof_…, camera_…  of the body, all fixed
//             - hip_pitch_l - … - ankle_roll_l                 of a humanoid, by its joints
//             - waist_yaw - head_yaw, shoulder_pitch_l - … - elbow_yaw_l - hand_l
//
// Metres and radians; x is ahead, y to the left, z up. Plain values without threads and errors.

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/modules/world/simulation/world.hpp"

namespace musher::world {

struct LinkShape {
  enum class Kind { kBox, kCylinder, kSphere };

  Kind kind = Kind::kBox;
  // Of a box its edges, of a cylinder the diameter, the same again, and the length along z, of a
  // sphere the diameter three times.
  Eigen::Vector3d size_m{0, 0, 0};
  Eigen::Vector3d middle_m{0, 0, 0};  // in the frame of the link
  Color color;
};

struct ModelLink {
  std::string name;
  std::optional<LinkShape> shape;
};

struct ModelJoint {
  std::string name, parent, child;
  Eigen::Isometry3d origin = Eigen::Isometry3d::Identity();  // of the child, at an angle of 0
  // What the joint turns the child about, by its place in JointTable(); none: it is fixed.
  std::optional<std::size_t> angle;
  Eigen::Vector3d axis{0, 0, 1};
};

struct RobotModel {
  std::string name;
  std::vector<ModelLink> links;  // the first one is the root
  std::vector<ModelJoint> joints;
};

RobotModel ModelOf(const RobotSpec& robot);
// Of the body of a scene, with its joints if it is a humanoid.
RobotModel ModelOfBody(const Scene& scene);

std::string ToUrdf(const RobotModel& model);

// A camera on the head in the frame head_yaw; the gaze tilts it by `pitch_rad`, which is no joint.
Eigen::Isometry3d PlacementOnHead(const Scene& scene, CameraSpec camera, double pitch_rad);

// Where the child is in the parent; `angles` is only read for joints that have one.
msg::TransformStamped TransformOf(const ModelJoint& joint, const Angles& angles, Duration at);
msg::TransformStamped TransformOf(const std::string& parent, const std::string& child,
                                  const Eigen::Isometry3d& placement, Duration at);

}  // namespace musher::world
