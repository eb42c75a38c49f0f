#pragma once
#include "musher/messages/std_msgs/header.hpp"

namespace musher::msg {

// geometry_msgs/msg/Vector3
struct Vector3 {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Vector3_";
  double x = 0;
  double y = 0;
  double z = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.x, m.y, m.z);
  }
  friend bool operator==(const Vector3&, const Vector3&) = default;
};

// geometry_msgs/msg/Point: metres.
struct Point {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Point_";
  double x = 0;
  double y = 0;
  double z = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.x, m.y, m.z);
  }
  friend bool operator==(const Point&, const Point&) = default;
};

// geometry_msgs/msg/Quaternion: a new one is no rotation.
struct Quaternion {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Quaternion_";
  double x = 0;
  double y = 0;
  double z = 0;
  double w = 1;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.x, m.y, m.z, m.w);
  }
  friend bool operator==(const Quaternion&, const Quaternion&) = default;
};

// geometry_msgs/msg/Pose
struct Pose {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Pose_";
  Point position;
  Quaternion orientation;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.position, m.orientation);
  }
  friend bool operator==(const Pose&, const Pose&) = default;
};

// geometry_msgs/msg/PoseStamped
struct PoseStamped {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::PoseStamped_";
  Header header;
  Pose pose;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.pose);
  }
  friend bool operator==(const PoseStamped&, const PoseStamped&) = default;
};

// geometry_msgs/msg/Twist
struct Twist {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Twist_";
  Vector3 linear;
  Vector3 angular;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.linear, m.angular);
  }
  friend bool operator==(const Twist&, const Twist&) = default;
};

// geometry_msgs/msg/PoseWithCovariance
struct PoseWithCovariance {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::PoseWithCovariance_";
  Pose pose;
  std::array<double, 36> covariance{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.pose, m.covariance);
  }
  friend bool operator==(const PoseWithCovariance&, const PoseWithCovariance&) = default;
};

// geometry_msgs/msg/TwistWithCovariance
struct TwistWithCovariance {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::TwistWithCovariance_";
  Twist twist;
  std::array<double, 36> covariance{};

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.twist, m.covariance);
  }
  friend bool operator==(const TwistWithCovariance&, const TwistWithCovariance&) = default;
};

// geometry_msgs/msg/Transform
struct Transform {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::Transform_";
  Vector3 translation;
  Quaternion rotation;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.translation, m.rotation);
  }
  friend bool operator==(const Transform&, const Transform&) = default;
};

// geometry_msgs/msg/TransformStamped
struct TransformStamped {
  static constexpr std::string_view kTypeName = "geometry_msgs::msg::dds_::TransformStamped_";
  Header header;
  std::string child_frame_id;
  Transform transform;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.header, m.child_frame_id, m.transform);
  }
  friend bool operator==(const TransformStamped&, const TransformStamped&) = default;
};

}  // namespace musher::msg
