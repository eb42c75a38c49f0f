// What the robot can do now, as people and scripts query it.

#include "musher/test/integration/cli/machine.hpp"

namespace musher::testing::capabilities_test {

using ::testing::HasSubstr;

class Capabilities : public MachineByCli {};

TEST_F(Capabilities, FollowTheMachineAndSayWhyNot) {
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  const Ended listed = Musher({"capabilities"});
  EXPECT_EQ(listed.exit, 0) << listed.err;
  EXPECT_THAT(listed.out, HasSubstr("CAPABILITY  ALLOWED  RUNS IN           REASON\n"));
  EXPECT_THAT(listed.out, HasSubstr("talk        yes      Active, LowPower\n"));
  const auto all = Json(Musher({"capabilities", "--json"}).out)["capabilities"];
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0]["capability"], "guide");
  EXPECT_EQ(all[0]["allowed"], false);
  EXPECT_EQ(all[0]["code"], 103);
  EXPECT_EQ(all[0]["reason"], "guide runs in Active only; legs is in LowPower");
  ASSERT_EQ(Musher({"set", "Active"}).exit, 0);
  const auto talk = Json(Musher({"capabilities", "talk", "--json"}).out);
  EXPECT_EQ(talk["allowed"], true);
  EXPECT_EQ(talk["reason"], "");
}

TEST_F(Capabilities, AnswerAScriptWithAnExitCode) {
  ASSERT_EQ(UpDetached().exit, 0);
  EXPECT_EQ(Musher({"capabilities", "talk"}).exit, 0);
  const Ended refused = Musher({"capabilities", "jump"});
  EXPECT_EQ(refused.exit, 1);
  EXPECT_THAT(refused.out, HasSubstr("jump needs at least 50 % of the battery; its level is not "
                                     "known (113 Robot: ProtectedError)"));
  const Ended unknown = Musher({"capabilities", "guid"});
  EXPECT_EQ(unknown.exit, 1);
  EXPECT_THAT(unknown.err, HasSubstr("did you mean 'guide'?"));
  ASSERT_EQ(Musher({"estop", "smoke"}).exit, 0);
  EXPECT_EQ(Musher({"capabilities", "talk"}).exit, 1);
}

TEST_F(Capabilities, NeedAController) {
  EXPECT_EQ(Musher({"capabilities"}).exit, 3);
}

}  // namespace musher::testing::capabilities_test
