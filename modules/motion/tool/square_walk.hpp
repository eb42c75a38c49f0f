#pragma once
// Walks a square: a side straight ahead, a quarter turn to the left, four times; the body ends
// where it began, with the same heading. Closed loop on odometry: it keeps to the lines and
// corners of the square that begins at the first pose, so that slip and lag do not add up. Pure:
// poses come in, speeds go out.

#include <Eigen/Geometry>
#include <array>

namespace musher::motion::tool {

struct PlanarPose {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();  // m
  double yaw = 0;                                // rad, left is positive
};

// The planar part of a transform that may be tilted a little.
PlanarPose PlanarPoseOf(const Eigen::Isometry3d& body);

// From -pi to pi.
double WrapAngle(double angle_rad);

class SquareWalk {
 public:
  SquareWalk(const PlanarPose& begin, double side_m, double speed)
      : begin_(begin), side_m_(side_m), speed_(speed) {}

  // The speed to walk with now, x and y in m/s and yaw in rad/s; zeros when it is done.
  std::array<float, 3> Step(const PlanarPose& pose);
  bool done() const { return leg_ == 4; }

  // How far a pose is from the beginning.
  double Gap(const PlanarPose& pose) const { return (pose.at - begin_.at).norm(); }

 private:
  double Heading(int leg) const;

  PlanarPose begin_;
  double side_m_;
  double speed_;
  int leg_ = 0;  // 0 to 3; 4: done
  bool turning_ = false;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();  // where the leg began, from the beginning
};

}  // namespace musher::motion::tool
