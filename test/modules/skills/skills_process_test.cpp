// The real programs over DDS, driven as a controller drives them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/geometry_msgs/geometry.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/modules/actuator_peer.hpp"
#include "musher/transport/action.hpp"

namespace musher::skills::skills_process_test {

using ::testing::HasSubstr;

const std::vector<std::string> kStates = {"SetUp",    "TearDown", "SelfCheck",
                                          "Active",   "DeActive", "Protected",
                                          "LowPower", "OTA",      "Error"};

class SkillsProcess : public ::testing::Test {
 protected:
  SkillsProcess() {
    odometry_ = transport::MakePublisher<msg::Odometry>(peer_.node(), "r/odom").value();
    commands_in_ = transport::MakeSubscription<msg::Twist>(
                       peer_.node(), "r/cmd_vel",
                       [this](const msg::Twist& twist, const auto&) { commands_.push_back(twist); })
                       .value();
    client_ =
        transport::MakeActionClient<msg::SkillExecution>(peer_.node(), "r/skill_execution").value();
    again_ = peer_.node().loop().Every(Milliseconds(20),
                                       [this] { static_cast<void>(odometry_->Publish({})); });
  }
  // A flyer, which is commanded to rise.
  void BeginToRise() {
    peer_.Start("robot = \"r\"\nkind = \"cf2x\"\nflies = true\nself_check_ms = 1000\n");
    ASSERT_TRUE(peer_.AwaitVisible()) << peer_.Output();
    ASSERT_TRUE(peer_.Switch("SelfCheck")) << peer_.Output();
    ASSERT_TRUE(peer_.Switch("Active")) << peer_.Output();
    msg::SkillInfo skill;
    skill.skill = "take_off";
    skill.params = {{"altitude", "2"}};
    client_->SendGoal({{"r", {skill}}}, std::chrono::seconds(20), {});
    ASSERT_TRUE(peer_.Until([this] { return !commands_.empty() && commands_.back().linear.z > 0; }))
        << peer_.Output();
  }

  test::ActuatorPeer peer_{"r", kStates, "musher-skills"};
  std::vector<msg::Twist> commands_;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  std::unique_ptr<transport::Subscription> commands_in_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> client_;
  transport::LoopHandlePtr again_;
};

TEST_F(SkillsProcess, StandsWhenItIsTerminated) {
  BeginToRise();
  peer_.Signal(SIGTERM);
  EXPECT_TRUE(peer_.Until([this] { return commands_.back() == msg::Twist{}; })) << peer_.Output();
  peer_.AwaitExit();
}

TEST_F(SkillsProcess, StandsInLowPower) {
  BeginToRise();
  ASSERT_TRUE(peer_.Switch("LowPower")) << peer_.Output();
  EXPECT_TRUE(peer_.Until([this] { return commands_.back() == msg::Twist{}; })) << peer_.Output();
}

TEST_F(SkillsProcess, ExitsWithCode2AndTheErrorsOfItsConfig) {
  peer_.Start("robot = \"r\"\nkindd = \"cf2x\"\nradius_m = 0\n");
  EXPECT_EQ(peer_.AwaitExit(), 2);
  EXPECT_THAT(peer_.Output(), HasSubstr("unknown key \"kindd\"; did you mean \"kind\"?"));
  EXPECT_THAT(peer_.Output(), HasSubstr(":3:12: error: radius_m: "));
}

TEST(DispatcherProcess, ExitsWithCode2AndTheErrorsOfItsConfig) {
  test::ActuatorPeer peer("plan_dispatcher", kStates, "musher-plan-dispatcher");
  peer.Start("server_wait = 3\n");
  EXPECT_EQ(peer.AwaitExit(), 2);
  EXPECT_THAT(peer.Output(), HasSubstr("did you mean \"server_wait_ms\"?"));
}

}  // namespace musher::skills::skills_process_test
