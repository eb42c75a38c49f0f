#include "musher/modules/motion/board_message.hpp"

#include <algorithm>
#include <cmath>

#include "musher/modules/motion/motion_code.hpp"
#include "musher/transport/lcm_type.hpp"
#include "musher_lcm/danger_states_lcmt.hpp"
#include "musher_lcm/file_recv_lcmt.hpp"
#include "musher_lcm/file_send_lcmt.hpp"
#include "musher_lcm/localization_lcmt.hpp"
#include "musher_lcm/robot_control_cmd_lcmt.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::motion {
namespace {

Error BadMessage(const std::string& what) {
  return {MotionCode(KeyCode::kParametersInvalid), what};
}

template <typename Wire>
Result<Wire> Decode(Bytes bytes) {
  auto decoded = transport::DecodeLcm<Wire>(bytes);
  if (!decoded) return BadMessage(decoded.error().message);
  return decoded;
}

template <std::size_t N>
void Copy(const std::array<float, N>& from, float (&to)[N]) {
  std::copy(from.begin(), from.end(), to);
}
template <std::size_t N>
void Copy(const float (&from)[N], std::array<float, N>& to) {
  std::copy(std::begin(from), std::end(from), to.begin());
}

template <std::size_t N>
bool AreFinite(const float (&values)[N]) {
  return std::all_of(std::begin(values), std::end(values),
                     [](float v) { return std::isfinite(v); });
}

Eigen::Vector3d Vector(const float (&values)[3]) {
  return {values[0], values[1], values[2]};
}

// Bits of the board's motor_error.
struct BoardBit {
  int bit;
  MotorFault fault;
};
constexpr BoardBit kBoardBits[] = {
    {0, MotorFault::kOffline},      {1, MotorFault::kTooHot},       {2, MotorFault::kDriver},
    {3, MotorFault::kUnderVoltage}, {4, MotorFault::kOverVoltage},  {5, MotorFault::kOverCurrent},
    {6, MotorFault::kOverCurrent},  {8, MotorFault::kEncoder},      {9, MotorFault::kOverloaded},
    {10, MotorFault::kOverloaded},  {11, MotorFault::kOverloaded},  {12, MotorFault::kOverloaded},
    {13, MotorFault::kOverloaded},  {14, MotorFault::kOverloaded},  {15, MotorFault::kOverloaded},
    {16, MotorFault::kOverloaded},  {17, MotorFault::kOverCurrent},
};
// The warning of 82 °C, and what the motor does: rest, calibration, motor, brake.
constexpr std::uint32_t kNoFaults = 1U << 24 | 1U << 30 | 1U << 31;

}  // namespace

std::vector<std::byte> EncodeCommand(const BodyCommand& command) {
  // The bit of `value` that calibrates the speed; never sent.
  constexpr std::int32_t kCalibration = 4;
  musher_lcm::robot_control_cmd_lcmt wire{};
  wire.mode = command.mode;
  wire.gait_id = command.gait;
  wire.contact = command.contact;
  wire.life_count = command.life_count;
  Copy(command.vel, wire.vel_des);
  Copy(command.rpy, wire.rpy_des);
  Copy(command.pos, wire.pos_des);
  Copy(command.acc, wire.acc_des);
  Copy(command.ctrl_point, wire.ctrl_point);
  Copy(command.foot_pose, wire.foot_pose);
  Copy(command.step_height, wire.step_height);
  wire.value = command.value & ~kCalibration;
  wire.duration = command.duration_ms;
  return transport::EncodeLcm(wire);
}

Result<BodyCommand> DecodeCommand(Bytes bytes) {
  const auto decoded = Decode<musher_lcm::robot_control_cmd_lcmt>(bytes);
  if (!decoded) return decoded.error();
  const musher_lcm::robot_control_cmd_lcmt& wire = decoded.value();
  BodyCommand command;
  command.mode = wire.mode;
  command.gait = wire.gait_id;
  command.contact = wire.contact;
  command.life_count = wire.life_count;
  Copy(wire.vel_des, command.vel);
  Copy(wire.rpy_des, command.rpy);
  Copy(wire.pos_des, command.pos);
  Copy(wire.acc_des, command.acc);
  Copy(wire.ctrl_point, command.ctrl_point);
  Copy(wire.foot_pose, command.foot_pose);
  Copy(wire.step_height, command.step_height);
  command.value = wire.value;
  command.duration_ms = wire.duration;
  return command;
}

std::int32_t MotorFaultsOf(std::int32_t board_error) {
  std::uint32_t rest = static_cast<std::uint32_t>(board_error) & ~kNoFaults;
  std::int32_t faults = 0;
  for (const BoardBit& known : kBoardBits) {
    const std::uint32_t bit = 1U << known.bit;
    if ((rest & bit) == 0) continue;
    faults |= static_cast<std::int32_t>(known.fault);
    rest &= ~bit;
  }
  if (rest != 0) faults |= static_cast<std::int32_t>(MotorFault::kOther);
  return faults;
}

Result<BodyReport> DecodeResponse(Bytes bytes) {
  const auto decoded = Decode<musher_lcm::robot_control_response_lcmt>(bytes);
  if (!decoded) return decoded.error();
  const musher_lcm::robot_control_response_lcmt& wire = decoded.value();
  BodyReport report;
  report.mode = wire.mode;
  report.gait = wire.gait_id;
  report.contact = wire.contact;
  report.bar = wire.order_process_bar;
  report.switch_status = wire.switch_status;
  report.ori_error = wire.ori_error;
  report.footpos_error = wire.footpos_error;
  std::transform(std::begin(wire.motor_error), std::end(wire.motor_error),
                 report.motor_error.begin(), MotorFaultsOf);
  return report;
}

Result<BoardLocation> DecodeLocation(Bytes bytes) {
  const auto decoded = Decode<musher_lcm::localization_lcmt>(bytes);
  if (!decoded) return decoded.error();
  const musher_lcm::localization_lcmt& wire = decoded.value();
  if (!AreFinite(wire.xyz) || !AreFinite(wire.vxyz) || !AreFinite(wire.rpy) ||
      !AreFinite(wire.omegaBody) || !AreFinite(wire.vBody)) {
    return BadMessage("a number of a localization_lcmt is NaN or infinite");
  }
  BoardLocation location;
  location.timestamp = std::chrono::nanoseconds(wire.timestamp);
  location.motion.X_OB = Eigen::AngleAxisd(wire.rpy[2], Eigen::Vector3d::UnitZ()) *
                         Eigen::AngleAxisd(wire.rpy[1], Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(wire.rpy[0], Eigen::Vector3d::UnitX());
  location.motion.X_OB.translation() = Vector(wire.xyz);
  location.motion.v_B = Vector(wire.vBody);
  location.motion.w_B = Vector(wire.omegaBody);
  location.motion.has_acceleration = false;
  return location;
}

Result<Temperatures> DecodeTemperatures(Bytes bytes) {
  const auto decoded = Decode<musher_lcm::danger_states_lcmt>(bytes);
  if (!decoded) return decoded.error();
  if (!AreFinite(decoded.value().motor_temperature)) {
    return BadMessage("a temperature of a danger_states_lcmt is NaN or infinite");
  }
  Temperatures temperatures{};
  Copy(decoded.value().motor_temperature, temperatures);
  return temperatures;
}

Result<std::vector<std::byte>> EncodeGaitFile(const std::string& text) {
  if (text.size() > kLongestGaitText) {
    return BadMessage("the definition of a gait has " + std::to_string(text.size()) +
                      " bytes; the board takes at most " + std::to_string(kLongestGaitText));
  }
  musher_lcm::file_send_lcmt wire;
  wire.data = text;
  return transport::EncodeLcm(wire);
}

Result<bool> DecodeGaitResult(Bytes bytes) {
  const auto decoded = Decode<musher_lcm::file_recv_lcmt>(bytes);
  if (!decoded) return decoded.error();
  return decoded.value().result == 0;
}

}  // namespace musher::motion
