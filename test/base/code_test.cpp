#include "musher/base/code.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace musher::code_test {

constexpr ModuleCode kGripper{6100};
constexpr ModuleName kNames[] = {{kGripper, "Gripper"}};

TEST(Code, IsModuleBasePlusKey) {
  EXPECT_EQ(MakeCode(kGripper, KeyCode::kSelfCheckFailed), 6109);
  EXPECT_EQ(RobotCode(KeyCode::kTimeout), 107);
}

TEST(Code, IsZeroForSuccessWhateverTheModule) {
  EXPECT_EQ(MakeCode(kGripper, KeyCode::kOk), 0);
  EXPECT_EQ(kCodeOk, 0);
}

TEST(CodeText, NamesModuleAndKey) {
  EXPECT_EQ(CodeText(kCodeStateInvalid), "103 (Robot: StateInvalid)");
  EXPECT_EQ(CodeText(5701), "5701 (OTA: Failed)");
}

TEST(CodeText, NamesKeysWithoutModule) {
  EXPECT_EQ(CodeText(0), "0 (ok)");
  EXPECT_EQ(CodeText(8), "8 (UnSupport)");
}

TEST(CodeText, NamesTheModuleAloneWhereTheKeyIsTheModulesOwn) {
  EXPECT_EQ(CodeText(5721), "5721 (OTA)");
  EXPECT_EQ(CodeText(5700), "5700 (OTA)");
}

TEST(CodeText, GivesTheBareNumberWhereNothingIsKnown) {
  EXPECT_EQ(CodeText(-1), "-1");
  EXPECT_EQ(CodeText(50), "50");
  EXPECT_EQ(CodeText(4711), "4711");
  EXPECT_EQ(CodeText(4711 + 100'000), "104711");
}

TEST(NameModules, GivesTheModulesOfARobotTheirNames) {
  constexpr ModuleName kLamps[] = {{ModuleCode{6300}, "Lamp"}, {ModuleCode{6400}, "Siren"}};
  EXPECT_EQ(CodeText(6309), "6309");
  EXPECT_TRUE(NameModules(kLamps));
  EXPECT_EQ(CodeText(6309), "6309 (Lamp: SelfCheckFailed)");
  EXPECT_EQ(CodeText(6442), "6442 (Siren)");
  EXPECT_EQ(CodeText(6500), "6500");
}

TEST(NameModules, ChangesNothingWhenItIsRepeated) {
  EXPECT_TRUE(NameModules(kNames));
  EXPECT_TRUE(NameModules(kNames));
  EXPECT_EQ(CodeText(6101), "6101 (Gripper: Failed)");
}

TEST(NameModules, KeepsTheFirstNameOfAModule) {
  constexpr ModuleName kOthers[] = {{ModuleCode::kRobot, "Machine"}, {ModuleCode{6600}, "Broom"}};
  EXPECT_FALSE(NameModules(kOthers));
  EXPECT_EQ(CodeText(101), "101 (Robot: Failed)");
  EXPECT_EQ(CodeText(6601), "6601 (Broom: Failed)") << "the others get theirs";
}

TEST(NameModules, IsForSeveralThreads) {
  std::vector<std::jthread> threads;
  threads.reserve(4);
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      EXPECT_TRUE(NameModules(kNames));
      EXPECT_EQ(CodeText(6107), "6107 (Gripper: Timeout)");
    });
  }
}

TEST(WithoutModuleNames, LeavesTheNumbers) {
  EXPECT_EQ(WithoutModuleNames("legs: 3009 (MotionManager: SelfCheckFailed), 5721 (OTA); 2 (two)"),
            "legs: 3009, 5721; 2 (two)");
  EXPECT_EQ(WithoutModuleNames("it is silent (6112 Gripper: DeviceError)"), "it is silent (6112)");
  EXPECT_EQ(WithoutModuleNames(""), "");
}

TEST(WithCode, PutsTheCodeBehindTheSentence) {
  NameModules(kNames);
  EXPECT_EQ(WithCode("it is silent", 6112), "it is silent (6112 Gripper: DeviceError)");
  EXPECT_EQ(WithCode("", 107), "(107 Robot: Timeout)");
  EXPECT_EQ(WithCode("it took 50 ms", 50), "it took 50 ms (50)");
}

TEST(WithCode, LeavesOutSuccessAndACodeThatTheSentenceNames) {
  NameModules(kNames);
  EXPECT_EQ(WithCode("all is well", kCodeOk), "all is well");
  EXPECT_EQ(WithCode("gripper: failed with 6112 (Gripper: DeviceError), silent", 6112),
            "gripper: failed with 6112 (Gripper: DeviceError), silent");
  EXPECT_EQ(WithCode("lidar: failed with 6202, as above", 6202),
            "lidar: failed with 6202, as above");
  EXPECT_EQ(WithCode("port 16202 is used", 6202), "port 16202 is used (6202)");
}

}  // namespace musher::code_test
