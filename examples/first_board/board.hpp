#pragma once
// What a motion board decides: it takes the commands of Musher's motion manager, moves the legs,
// and reports the body. Time is an argument, so a test needs no waiting.

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "legs.hpp"
#include "musher/messages/musher_msgs/body.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/yaw.hpp"

class Board {
 public:
  using Command = musher::msg::MotionCustomCommand;
  using Status = musher::msg::MotionStatus;

  void Take(const Command& command, musher::Time now) {
    heard_at_ = now;
    if (command.life_count == life_count_) return;  // the same once more
    const bool known =
        (command.mode == kOff && command.gait_id == 0) ||
        (command.mode == kLying && command.gait_id <= 1) ||
        (command.mode == kStanding && command.gait_id == 0) ||
        (command.mode == kWalking && (command.gait_id == kStill || command.gait_id == 27));
    const bool possible = command.mode != kWalking || legs_.Arrived();
    const bool off = mode_ == kOff && command.mode != kOff && command.mode != kStanding;
    if (!known || !possible || off) {
      refused_ = true;
      return;
    }
    refused_ = false;
    life_count_ = command.life_count;
    Do(command.mode, command.gait_id, command.vel_des);
  }

  musher::msg::BodyState Report(musher::Time now) {
    if (advanced_to_) legs_.Advance(now - *advanced_to_);
    advanced_to_ = now;
    const bool walks = mode_ == kWalking && gait_ != kStill;
    if (walks && now - heard_at_ > musher::Milliseconds(500)) {
      Do(kWalking, kStill, {});  // the motion manager has crashed, or hangs
    }
    musher::msg::BodyState state;
    state.mode = mode_;
    state.gait_id = gait_;
    state.contact = 15;
    state.life_count = life_count_;
    state.order_process_bar = legs_.Arrived() ? 100 : 50;
    state.switch_status = mode_ == kOff      ? Status::kEstop
                          : refused_         ? Status::kBanTrans
                          : !legs_.Arrived() ? Status::kTransitioning
                                             : Status::kNormal;
    state.motor_temperature.fill(40);
    state.header.frame_id = "odom";
    state.pose.position = {legs_.x_m, legs_.y_m, legs_.height_m};
    state.pose.orientation = musher::msg::FromYaw(legs_.yaw_rad);
    state.twist.linear = {legs_.forwards_m_s, legs_.left_m_s, 0};
    state.twist.angular.z = legs_.turn_rad_s;
    state.linear_acceleration.z = 9.81;
    return state;
  }

  // The emergency stop of the robot, beside that of the motion manager, which sends mode 0.
  void Stop() { Do(kOff, 0, {}); }

  const Legs& legs() const { return legs_; }

 private:
  static constexpr std::int8_t kOff = 0;
  static constexpr std::int8_t kLying = 7;
  static constexpr std::int8_t kWalking = 11;
  static constexpr std::int8_t kStanding = 12;
  static constexpr std::int8_t kStill = 1;  // gait of kWalking

  void Do(std::int8_t mode, std::int8_t gait, const std::vector<float>& speed) {
    mode_ = mode;
    gait_ = gait;
    legs_.Power(mode != kOff);
    legs_.Stand(mode == kStanding || mode == kWalking ? 0.28 : 0);
    const bool walks =
        mode == kWalking && gait != kStill && speed.size() == 3 &&
        std::all_of(speed.begin(), speed.end(), [](float v) { return std::isfinite(v); });
    walks ? legs_.Walk(speed[0], speed[1], speed[2]) : legs_.Walk(0, 0, 0);
  }

  Legs legs_;
  std::int8_t mode_ = kLying;
  std::int8_t gait_ = 1;
  std::int8_t life_count_ = 0;
  bool refused_ = false;  // the last command
  musher::Time heard_at_{};
  std::optional<musher::Time> advanced_to_;
};
