// The messages of a motion board on LCM: values to bytes and back, and bytes that are none.

#include "musher/modules/motion/board_message.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "musher/modules/motion/motion_code.hpp"
#include "musher_lcm/danger_states_lcmt.hpp"
#include "musher_lcm/localization_lcmt.hpp"
#include "musher_lcm/robot_control_response_lcmt.hpp"

namespace musher::motion::testing::board_message_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

template <typename Wire>
std::vector<std::byte> BytesOf(const Wire& wire) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(wire.getEncodedSize()));
  wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

TEST(BoardMessage, EncodesACommandAndDecodesIt) {
  BodyCommand command;
  command.mode = 11;
  command.gait = 27;
  command.contact = 15;
  command.life_count = static_cast<std::int8_t>(200);
  command.vel = {0.5F, -0.25F, 1};
  command.rpy = {0.1F, 0.2F, 0.3F};
  command.pos = {0, 0, 0.25F};
  command.acc = {1, 2, 3, 4, 5, 6};
  command.ctrl_point = {7, 8, 9};
  command.foot_pose = {10, 11, 12, 13, 14, 15};
  command.step_height = {0.05F, 0.06F};
  command.value = 2;
  command.duration_ms = 1500;
  const auto bytes = EncodeCommand(command);
  EXPECT_EQ(bytes.size(), 8U + 4U + 4U * 26U + 8U);
  EXPECT_EQ(DecodeCommand(bytes).value(), command);
}

TEST(BoardMessage, NeverAsksForACalibrationOfTheSpeed) {
  BodyCommand command;
  command.value = 6;
  EXPECT_EQ(DecodeCommand(EncodeCommand(command)).value().value, 2);
}

TEST(BoardMessage, RefusesAWrongLengthAndAnotherFingerprint) {
  std::vector<std::byte> bytes = BytesOf(musher_lcm::robot_control_response_lcmt{});
  ASSERT_TRUE(DecodeResponse(bytes));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = DecodeResponse(Bytes(bytes).first(size));
    ASSERT_FALSE(cut) << size;
    EXPECT_EQ(cut.error().code, 3010);
  }
  bytes.push_back(std::byte{0});
  EXPECT_THAT(DecodeResponse(bytes).error().message, HasSubstr("too long"));
  EXPECT_THAT(DecodeResponse(BytesOf(musher_lcm::danger_states_lcmt{})).error().message,
              AllOf(HasSubstr("fingerprint 0x"), HasSubstr("robot_control_response_lcmt")));
}

TEST(BoardMessage, RefusesNumbersThatAreNotFinite) {
  for (const float bad : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
    musher_lcm::localization_lcmt location{};
    ASSERT_TRUE(DecodeLocation(BytesOf(location)));
    location.vBody[1] = bad;
    EXPECT_FALSE(DecodeLocation(BytesOf(location)));
    musher_lcm::danger_states_lcmt temperatures{};
    ASSERT_TRUE(DecodeTemperatures(BytesOf(temperatures)));
    temperatures.motor_temperature[11] = bad;
    EXPECT_FALSE(DecodeTemperatures(BytesOf(temperatures)));
  }
}

TEST(BoardMessage, ReadsThePositionOfTheBody) {
  musher_lcm::localization_lcmt wire{};
  wire.xyz[0] = 1;
  wire.rpy[2] = static_cast<float>(M_PI / 2);
  wire.vBody[0] = 0.5F;
  wire.omegaBody[2] = 0.25F;
  wire.timestamp = 42;
  const BoardLocation location = DecodeLocation(BytesOf(wire)).value();
  EXPECT_EQ(location.timestamp.count(), 42);
  EXPECT_EQ(location.motion.X_OB.translation().x(), 1);
  EXPECT_TRUE((location.motion.X_OB.rotation() * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d::UnitY(), 1e-6));
  EXPECT_EQ(location.motion.v_B.x(), 0.5);
  EXPECT_EQ(location.motion.w_B.z(), 0.25);
  EXPECT_FALSE(location.motion.has_acceleration);
}

TEST(BoardMessage, TranslatesTheErrorsOfAMotor) {
  const auto code = [](std::uint32_t board_error) {
    return CodeOfMotorError(MotorFaultsOf(static_cast<std::int32_t>(board_error)));
  };
  EXPECT_EQ(code(0), 0);
  EXPECT_EQ(code(1U << 30), 0) << "the motor's mode";
  EXPECT_EQ(code(1U << 31 | 1U << 24), 0) << "a warning";
  EXPECT_EQ(code(1U << 0), 3032);
  EXPECT_EQ(code(1U << 1), 3033);
  EXPECT_EQ(code(1U << 12), 3034);
  EXPECT_EQ(code(1U << 17), 3054);
  EXPECT_EQ(code(1U << 8), 3055);
  EXPECT_EQ(code(1U << 20), 3055) << "not known";
  EXPECT_EQ(MotorFaultText(MotorFaultsOf(1 << 3 | 1 << 8)), "under-voltage, encoder fault");
}

TEST(BoardMessage, NamesLegAndJointOfAMotor) {
  EXPECT_EQ(MotorName(0), "motor 0 (front right hip abduction)");
  EXPECT_EQ(MotorName(4), "motor 4 (front left hip)");
  EXPECT_EQ(MotorName(11), "motor 11 (rear left knee)");
}

TEST(BoardMessage, RefusesAGaitOf1Megabyte) {
  ASSERT_TRUE(EncodeGaitFile("# Gait Def\n"));
  const auto refused = EncodeGaitFile(std::string(1 << 20, 'x'));
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("1048576 bytes"));
}

}  // namespace musher::motion::testing::board_message_test
