#include "musher/base/code.hpp"

#include <gtest/gtest.h>

namespace musher::code_test {

TEST(Code, IsModuleBasePlusKey) {
  EXPECT_EQ(MakeCode(ModuleCode::kMotionManager, KeyCode::kSelfCheckFailed), 3009);
  EXPECT_EQ(RobotCode(KeyCode::kTimeout), 107);
}

TEST(Code, IsZeroForSuccessWhateverTheModule) {
  EXPECT_EQ(MakeCode(ModuleCode::kMotionManager, KeyCode::kOk), 0);
  EXPECT_EQ(kCodeOk, 0);
}

TEST(CodeText, NamesModuleAndKey) {
  EXPECT_EQ(CodeText(3009), "3009 (MotionManager: SelfCheckFailed)");
  EXPECT_EQ(CodeText(kCodeStateInvalid), "103 (Robot: StateInvalid)");
}

TEST(CodeText, NamesKeysWithoutModule) {
  EXPECT_EQ(CodeText(0), "0 (ok)");
  EXPECT_EQ(CodeText(8), "8 (UnSupport)");
}

TEST(CodeText, NamesTheModuleAloneWhereTheKeyIsTheModulesOwn) {
  EXPECT_EQ(CodeText(3040), "3040 (MotionManager)");
}

TEST(CodeText, GivesTheBareNumberWhereNothingIsKnown) {
  EXPECT_EQ(CodeText(-1), "-1");
  EXPECT_EQ(CodeText(50), "50");
  EXPECT_EQ(CodeText(4711 + 100'000), "104711");
}

TEST(WithCode, PutsTheCodeBehindTheSentence) {
  EXPECT_EQ(WithCode("it is silent", 2012), "it is silent (2012 (SensorManager: DeviceError))");
  EXPECT_EQ(WithCode("", 107), "(107 (Robot: Timeout))");
  EXPECT_EQ(WithCode("it took 50 ms", 50), "it took 50 ms (50)");
}

TEST(WithCode, LeavesOutSuccessAndACodeThatTheSentenceNames) {
  EXPECT_EQ(WithCode("all is well", kCodeOk), "all is well");
  EXPECT_EQ(WithCode("lidar: failed with 2012 (SensorManager: DeviceError), silent", 2012),
            "lidar: failed with 2012 (SensorManager: DeviceError), silent");
  EXPECT_EQ(WithCode("lidar: failed with 6202, as above", 6202),
            "lidar: failed with 6202, as above");
  EXPECT_EQ(WithCode("port 16202 is used", 6202), "port 16202 is used (6202)");
}

}  // namespace musher::code_test
