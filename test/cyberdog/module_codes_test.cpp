// The program includes the header and calls nothing of it: that gives the modules their names.

#include "musher/cyberdog/codes/module_codes.hpp"

#include <gtest/gtest.h>

namespace musher::cyberdog::module_codes_test {

TEST(ModuleCodes, AreNamedInTextsOfAProgramThatIncludesThem) {
  EXPECT_EQ(CodeText(3009), "3009 (MotionManager: SelfCheckFailed)");
  EXPECT_EQ(CodeText(3040), "3040 (MotionManager)");
  EXPECT_EQ(WithCode("it is silent", 2012), "it is silent (2012 SensorManager: DeviceError)");
  EXPECT_EQ(CodeText(200), "200 (Server)");
  EXPECT_EQ(CodeText(1101), "1101 (LED: Failed)");
  EXPECT_EQ(CodeText(2207), "2207 (ToF: Timeout)");
  EXPECT_EQ(CodeText(5001), "5001 (AudioNX: Failed)");
  EXPECT_EQ(CodeText(5901), "5901 (Face: Failed)");
}

TEST(ModuleCodes, LeaveMushersOwnNamesAsTheyAre) {
  EXPECT_EQ(CodeText(109), "109 (Robot: SelfCheckFailed)");
  EXPECT_EQ(CodeText(5721), "5721 (OTA)");
  EXPECT_TRUE(NameModuleCodes()) << "repeated, and no module has another name";
}

TEST(ModuleCodes, MakeCodes) {
  EXPECT_EQ(MakeCode(module_code::kMotionManager, KeyCode::kSelfCheckFailed), 3009);
  EXPECT_EQ(MakeCode(module_code::kLidar, KeyCode::kOk), 0);
}

}  // namespace musher::cyberdog::module_codes_test
