// The show with invalid inputs.

#include <gmock/gmock.h>

#include <cmath>
#include <limits>
#include <string>

#include "musher/test/modules/wedding/show_rig.hpp"

namespace musher::wedding::show_input_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class ShowInput : public ShowRig {};

TEST_F(ShowInput, RefusesImpossibleTargets) {
  for (const Target& target :
       {Target{{kNan, 0.5}, 1, {}}, Target{{0.5, kNan}, 1, {}}, Target{{1.01, 0.5}, 1, {}},
        Target{{0.5, -0.1}, 1, {}}, Target{{320, 240}, 1, {}}, Target{{0.5, 0.5}, kNan, {}},
        Target{{0.5, 0.5}, -1, {}},
        Target{{0.5, 0.5}, std::numeric_limits<double>::infinity(), {}}}) {
    show_->OnTarget(target, now_);
  }
  Tick();
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(show_->faults(), 8);
  EXPECT_THAT(script_.log, ElementsAre(HasSubstr("target (nan, 0.5, 1) is not in the picture")));
}

TEST_F(ShowInput, RefusesUnknownGesturesAndKeepsTheLastOne) {
  Track();
  Gesture("heart");
  Gesture(std::string(100'000, 'x'));
  EXPECT_LT(script_.log.back().size(), 120);
  Tick();
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(ShowInput, ReadsFacesAndRefusesInvalidOnes) {
  show_->OnFaces(R"({"faces": [
      {"area": 0.1, "is_frontal": true, "face_id": 3},
      {"area": 0.3, "is_frontal": false, "face_id": 4},
      {"area": 0.2, "is_frontal": true, "face_id": 5}], "count": 3, "timestamp": 12.5})",
                 now_);
  Tick();
  EXPECT_EQ(data().perception.face_count, 3);
  EXPECT_EQ(data().perception.face_id, 5);
  for (const char* nonsense :
       {"", "{", "[]", "{\"faces\": 3}", "{\"faces\": [1]}", "{\"faces\": [], \"count\": -1}",
        R"({"faces": [{"is_frontal": true, "face_id": 4294967297}]})",
        R"({"faces": [{"is_frontal": true, "face_id": -2}]})"}) {
    show_->OnFaces(nonsense, now_);
  }
  Tick();
  EXPECT_EQ(data().perception.face_count, 3);
  EXPECT_EQ(data().perception.face_id, 5);
  EXPECT_EQ(show_->faults(), 8);
  Tick(80);
  EXPECT_EQ(data().perception.face_count, 0) << "too old";
}

TEST_F(ShowInput, MapsTwentyFourJointsByNameOrInTheirOrder) {
  std::vector<double> angles(kJointCount, 0.25);
  show_->OnJointStates({}, angles, Duration(1), now_);
  const std::vector<std::string> names = {"j23_head_yaw", "j12_waist_yaw"};
  const std::vector<double> two = {0.5, -0.125};
  show_->OnJointStates(names, two, Duration(2), now_);
  show_->OnJointCommands(names, two, now_);
  EXPECT_EQ(data().motion.joint_positions[0], 0.25);
  EXPECT_EQ(data().motion.joint_positions[kHeadYaw], 0.5);
  EXPECT_EQ(data().motion.joint_positions[kWaistYaw], -0.125);
  EXPECT_EQ(data().motion.joint_commands[kHeadYaw], 0.5);
  EXPECT_EQ(LookYaw(data().motion.joint_positions), 0.375);

  const std::vector<std::string> strange = {"j23_head_yaw", "j99_tail"};
  show_->OnJointStates(strange, two, Duration(3), now_);
  show_->OnJointStates(names, angles, Duration(3), now_);
  show_->OnJointStates({}, two, Duration(3), now_);
  const std::vector<double> broken = {1, kNan};
  show_->OnJointStates(names, broken, Duration(3), now_);
  EXPECT_EQ(data().motion.joint_positions[kHeadYaw], 0.5) << "nothing of them is taken";
  EXPECT_EQ(show_->faults(), 4);
}

TEST_F(ShowInput, RefusesJointsSoFarRoundThatTheirSumIsNoNumberAndLooksOnWhereAFaceIs) {
  ShowConfig config;
  config.gaze.camera = Mount::kHead;
  Begin(config);
  const std::vector<std::string> names = {"j23_head_yaw", "j12_waist_yaw"};
  const std::vector<double> zero = {0, 0};
  for (const double angle : {1e308, -1e308, 12.6, std::numeric_limits<double>::infinity()}) {
    const std::vector<double> far = {angle, angle};
    show_->OnJointStates(names, far, Milliseconds(1000), now_);
    show_->OnJointCommands(names, far, now_);
  }
  EXPECT_EQ(show_->faults(), 8);
  show_->OnJointStates(names, zero, Milliseconds(1020), now_);
  show_->OnTarget({{0.9, 0.5}, 1.5, Milliseconds(1010)}, now_);
  Tick(3);
  EXPECT_GT(data().motion.look_at_target.x, 0.5);
}

}  // namespace musher::wedding::show_input_test
