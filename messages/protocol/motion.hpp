#pragma once
#include "musher/messages/cdr.hpp"

namespace musher::msg {

// The ids that the package protocol gives a name. 1xx to 2xx and 4xx to 5xx are done once, 3xx are
// gaits.
struct MotionId {
  static constexpr std::int32_t kEmergencyStop = 0;
  static constexpr std::int32_t kGetDown = 101;
  static constexpr std::int32_t kPassiveGetDown = 102;
  static constexpr std::int32_t kRecoveryStand = 111;
  static constexpr std::int32_t kWalkStand = 112;
  static constexpr std::int32_t kBackFlip = 121;
  static constexpr std::int32_t kTwoLegStand = 123;
  static constexpr std::int32_t kRollOver = 124;
  static constexpr std::int32_t kPassiveTrot = 125;
  static constexpr std::int32_t kJumpUpstair = 126;
  static constexpr std::int32_t kJumpLeft90Deg = 130;
  static constexpr std::int32_t kJumpRight90Deg = 131;
  static constexpr std::int32_t kJumpForward60Cm = 132;
  static constexpr std::int32_t kJumpForward30Cm = 133;
  static constexpr std::int32_t kJumpLeft20Cm = 134;
  static constexpr std::int32_t kJumpRight20Cm = 135;
  static constexpr std::int32_t kJumpUp30Cm = 136;
  static constexpr std::int32_t kJumpDownstair = 137;
  static constexpr std::int32_t kForceControlAbsolute = 201;
  static constexpr std::int32_t kForceControlRelative = 202;
  static constexpr std::int32_t kPoseControlAbsolute = 211;
  static constexpr std::int32_t kPoseControlRelative = 212;
  static constexpr std::int32_t kBound = 301;
  static constexpr std::int32_t kPronk = 302;
  static constexpr std::int32_t kWalkUserTrot = 303;
  static constexpr std::int32_t kWalkAdaptively = 304;
  static constexpr std::int32_t kWalkFlyTrot = 305;
  static constexpr std::int32_t kSequenceCustom = 400;
};

// The source of a motion command: `cmd_source` of the messages and services here.
struct MotionSource {
  static constexpr std::int32_t kFsm = -2;  // the lifecycle itself
  static constexpr std::int32_t kDebug = -1;
  static constexpr std::int32_t kApp = 0;
  static constexpr std::int32_t kAudio = 1;
  static constexpr std::int32_t kVis = 2;      // visual programming
  static constexpr std::int32_t kBluTele = 3;  // the remote control
  static constexpr std::int32_t kAlgo = 4;
};

// protocol/msg/MotionServoCmd: topic `motion_servo_cmd`, a motion that continues as long as these
// come.
struct MotionServoCmd {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionServoCmd_";

  static constexpr std::int32_t kStart = 0;
  static constexpr std::int32_t kData = 1;
  static constexpr std::int32_t kEnd = 2;

  std::int32_t motion_id = 0;
  std::int32_t cmd_type = 0;
  std::int32_t cmd_source = 0;
  std::int32_t value = 0;
  std::vector<float> vel_des;
  std::vector<float> rpy_des;
  std::vector<float> pos_des;
  std::vector<float> acc_des;
  std::vector<float> ctrl_point;
  std::vector<float> foot_pose;
  std::vector<float> step_height;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.motion_id, m.cmd_type, m.cmd_source, m.value, m.vel_des, m.rpy_des, m.pos_des,
                    m.acc_des, m.ctrl_point, m.foot_pose, m.step_height);
  }
  friend bool operator==(const MotionServoCmd&, const MotionServoCmd&) = default;
};

// protocol/msg/MotionServoResponse: topic `motion_servo_response`, the outcome of a servo command.
struct MotionServoResponse {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionServoResponse_";
  std::int32_t motion_id = 0;
  std::int32_t cmd_id = 0;
  std::int8_t order_process_bar = 0;
  std::int8_t status = 0;
  bool result = false;
  std::int32_t code = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.motion_id, m.cmd_id, m.order_process_bar, m.status, m.result, m.code);
  }
  friend bool operator==(const MotionServoResponse&, const MotionServoResponse&) = default;
};

// protocol/msg/MotionStatus: topic `motion_status`, every 100 ms.
struct MotionStatus {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionStatus_";

  static constexpr std::int8_t kNormal = 0;
  static constexpr std::int8_t kTransitioning = 1;
  static constexpr std::int8_t kEstop = 2;
  static constexpr std::int8_t kEdamp = 3;
  static constexpr std::int8_t kLifted = 4;
  static constexpr std::int8_t kBanTrans = 5;
  static constexpr std::int8_t kOverHeat = 6;
  static constexpr std::int8_t kLowBat = 7;
  static constexpr std::int8_t kOriErr = 8;
  static constexpr std::int8_t kFootposErr = 9;
  static constexpr std::int8_t kStandStuck = 10;
  static constexpr std::int8_t kMotorOverHeat = 11;
  static constexpr std::int8_t kMotorOverCurr = 12;
  static constexpr std::int8_t kMotorErr = 13;
  static constexpr std::int8_t kCharging = 14;

  std::int32_t motion_id = 0;
  std::int8_t contact = 0;
  std::int8_t order_process_bar = 0;
  std::int8_t switch_status = 0;
  std::int8_t ori_error = 0;
  std::int16_t footpos_error = 0;
  std::vector<std::int32_t> motor_error;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.motion_id, m.contact, m.order_process_bar, m.switch_status, m.ori_error,
                    m.footpos_error, m.motor_error);
  }
  friend bool operator==(const MotionStatus&, const MotionStatus&) = default;
};

// protocol/msg/MotionCustomCmd: what the motion board takes, and an item of a queue.
struct MotionCustomCommand {
  static constexpr std::string_view kTypeName = "protocol::msg::dds_::MotionCustomCmd_";
  std::int8_t mode = 0;
  std::int8_t gait_id = 0;
  std::int8_t contact = 0;
  std::int8_t life_count = 0;
  std::vector<float> vel_des;
  std::vector<float> rpy_des;
  std::vector<float> pos_des;
  std::vector<float> acc_des;
  std::vector<float> ctrl_point;
  std::vector<float> foot_pose;
  std::vector<float> step_height;
  std::int32_t value = 0;
  std::int32_t duration = 0;

  template <class Self>
  static auto Fields(Self& m) {
    return std::tie(m.mode, m.gait_id, m.contact, m.life_count, m.vel_des, m.rpy_des, m.pos_des,
                    m.acc_des, m.ctrl_point, m.foot_pose, m.step_height, m.value, m.duration);
  }
  friend bool operator==(const MotionCustomCommand&, const MotionCustomCommand&) = default;
};

// protocol/srv/MotionResultCmd: service `motion_result_cmd`, a motion that ends; answered when it
// has.
struct MotionResultCmd {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotionResultCmd_";
  struct Request {
    std::int32_t motion_id = 0;
    std::int32_t cmd_source = 0;
    std::vector<float> vel_des;
    std::vector<float> rpy_des;
    std::vector<float> pos_des;
    std::vector<float> acc_des;
    std::vector<float> ctrl_point;
    std::vector<float> foot_pose;
    std::vector<float> step_height;
    std::int32_t duration = 0;
    std::int32_t value = 0;
    std::int32_t contact = 0;
    std::string gait_toml;
    std::string toml_data;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.motion_id, m.cmd_source, m.vel_des, m.rpy_des, m.pos_des, m.acc_des,
                      m.ctrl_point, m.foot_pose, m.step_height, m.duration, m.value, m.contact,
                      m.gait_toml, m.toml_data);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t motion_id = 0;
    bool result = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.motion_id, m.result, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/MotionCustomCmd: service `motion_custom_cmd`.
struct MotionCustomCmd {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotionCustomCmd_";

  static constexpr std::int32_t kDefinition = 0;
  static constexpr std::int32_t kExecution = 1;

  struct Request {
    std::int32_t cmd_type = 0;
    std::int32_t cmd_source = 0;
    std::int32_t motion_id = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.cmd_type, m.cmd_source, m.motion_id);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    std::int32_t motion_id = 0;
    bool result = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.motion_id, m.result, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/MotionQueueCustomCmd: service `motion_queue_cmd`.
struct MotionQueueCustomCmd {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotionQueueCustomCmd_";
  struct Request {
    std::vector<MotionCustomCommand> cmds;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.cmds);
    }
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Response {
    bool result = false;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

// protocol/srv/MotorTemp: service `motor_temp`.
struct MotorTemp {
  static constexpr std::string_view kTypeName = "protocol::srv::dds_::MotorTemp_";
  using Request = Empty;
  struct Response {
    bool result = false;
    std::vector<float> motor_temp;
    std::int32_t code = 0;

    template <class Self>
    static auto Fields(Self& m) {
      return std::tie(m.result, m.motor_temp, m.code);
    }
    friend bool operator==(const Response&, const Response&) = default;
  };
};

}  // namespace musher::msg
