// A controller in a program without an extension, and so without a manager that reads its tables of
// [policy]: a program of its own, since the reader belongs to a program.

#include <gmock/gmock.h>

#include <fstream>

#include "musher/controller/machine_controller.hpp"
#include "musher/test/actuator/robot_file.hpp"

namespace musher::without_manager_test {

using ::testing::HasSubstr;
using testing::kAllStates;
using testing::RobotFile;

TEST(WithoutManager, WarnsOfATableOfAManagerThatItDoesNotHave) {
  const RobotFile file({"legs"}, kAllStates);
  std::ofstream(file.path(), std::ios::app) << "[policy.voice]\nsay = []\n";
  ::testing::internal::CaptureStderr();
  {
    MachineController controller;
    EXPECT_TRUE(controller.Init(file.path()));
  }
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("policy.voice has no effect: no extension of this program reads it"));
}

TEST(WithoutManager, RefusesARobotThatLiesWithoutTheMotionsThatCount) {
  const RobotFile file({"legs"}, kAllStates);
  std::ofstream(file.path(), std::ios::app) << "[policy.low_power]\n";
  MachineController controller;
  const Result<> begun = controller.Init(file.path());
  ASSERT_FALSE(begun.ok());
  EXPECT_EQ(begun.error().message,
            "policy.low_power: motion_ids is missing: the motions of a robot that lies; an "
            "extension with a manager, such as cyberdog::Extension(), has a default");
}

}  // namespace musher::without_manager_test
