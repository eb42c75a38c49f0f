#pragma once
#include "musher/messages/geometry_msgs/geometry.hpp"

namespace musher::msg {

// protocol/msg/MotionSequenceGait: which feet stand, and for how long.
struct MotionSequenceGait {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionSequenceGait_";
  bool right_forefoot = false;
  bool left_forefoot = false;
  bool right_hindfoot = false;
  bool left_hindfoot = false;
  std::int64_t duration = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.right_forefoot, m.left_forefoot, m.right_hindfoot, m.left_hindfoot,
                    m.duration);
  }
  friend bool operator==(const MotionSequenceGait&, const MotionSequenceGait&) = default;
};

// protocol/msg/MotionSequencePace: how the body moves, and for how long.
struct MotionSequencePace {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionSequencePace_";
  Twist twist;
  Pose centroid;
  Twist weight;
  Quaternion right_forefoot;
  Quaternion left_forefoot;
  Quaternion right_hindfoot;
  Quaternion left_hindfoot;
  float friction_coefficient = 0;
  float landing_gain = 0;
  bool use_mpc_track = false;
  std::int64_t duration = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.twist, m.centroid, m.weight, m.right_forefoot, m.left_forefoot,
                    m.right_hindfoot, m.left_hindfoot, m.friction_coefficient, m.landing_gain,
                    m.use_mpc_track, m.duration);
  }
  friend bool operator==(const MotionSequencePace&, const MotionSequencePace&) = default;
};

// protocol/msg/MotionSequenceParam: one step of a choreography.
struct MotionSequenceParam {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionSequenceParam_";
  Twist twist;
  Point centroid_height;
  Point right_forefoot;
  Point left_forefoot;
  Point right_hindfoot;
  Point left_hindfoot;
  float forefoot_height = 0;
  float hindfoot_height = 0;
  float friction_coefficient = 0;
  std::int64_t duration_ms = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.twist, m.centroid_height, m.right_forefoot, m.left_forefoot, m.right_hindfoot,
                    m.left_hindfoot, m.forefoot_height, m.hindfoot_height, m.friction_coefficient,
                    m.duration_ms);
  }
  friend bool operator==(const MotionSequenceParam&, const MotionSequenceParam&) = default;
};

// protocol/srv/MotionSequenceShow: service `motion_sequence_cmd`.
struct MotionSequenceShow {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotionSequenceShow_";
  struct Request {
    std::int32_t motion_id = 0;
    std::int32_t cmd_source = 0;
    std::int64_t duration = 0;
    std::vector<MotionSequenceGait> gait_list;
    std::vector<MotionSequencePace> pace_list;
    std::vector<std::string> gait_toml_list;
    std::vector<std::string> pace_toml_list;
    std::string gait_toml;
    std::string pace_toml;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.motion_id, m.cmd_source, m.duration, m.gait_list, m.pace_list,
                      m.gait_toml_list, m.pace_toml_list, m.gait_toml, m.pace_toml);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool result = false;
    std::int32_t code = 0;
    std::string describe;
    std::int32_t motion_id = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.code, m.describe, m.motion_id);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/MotionSequence
struct MotionSequence {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotionSequence_";
  struct Request {
    std::int32_t motion_id = 0;
    std::int32_t duration = 0;
    std::string toml_data;
    std::vector<MotionSequenceParam> params;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.motion_id, m.duration, m.toml_data, m.params);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool result = false;
    std::int32_t code = 0;
    std::string describe;
    std::int32_t motion_id = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.code, m.describe, m.motion_id);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
