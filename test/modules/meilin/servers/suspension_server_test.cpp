// suspension_control on a simulated network with a simulated chassis, in virtual time.

#include "musher/modules/meilin/servers/suspension_server.hpp"

#include <chrono>
#include <limits>

#include "musher/test/modules/meilin/servers/server_rig.hpp"

namespace musher::meilin::servers::suspension_server_test {

using testing::ArrayOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using transport::GoalEnd;

class SuspensionServerTest : public testing::ServerRig<msg::SuspensionControl> {
 protected:
  SuspensionServerTest() {
    action_ = "suspension_control";
    targets_in_ = Must(transport::MakeSubscription<msg::Float32MultiArray>(
        *peer_, "t0x0102_action", [this](const msg::Float32MultiArray& message, const auto&) {
          targets_ = message.data;
          ++commands_;
        }));
    state_in_ = Must(transport::MakeSubscription<msg::Int32>(
        *peer_, "current_state",
        [this](const msg::Int32& message, const auto&) { states_.push_back(message.data); },
        transport::kLatchedQos));
    chassis_out_ = Must(transport::MakePublisher<msg::Float32MultiArray>(*peer_, "r0x0201"));
    distances_out_ =
        Must(transport::MakePublisher<msg::Float32MultiArray>(*peer_, "sensor_distances"));
    hardware_ = peer_->loop().Every(Milliseconds(10), [this] { Hardware(); });
  }
  void Hardware() {
    if (silent_) return;
    for (std::size_t i = 0; i < 4 && !stuck_ && targets_.size() == 4; ++i) {
      heights_[i] += std::clamp(targets_[i] - heights_[i], -2.0F, 2.0F);
    }
    EXPECT_TRUE(chassis_out_->Publish(
        ArrayOf({1, 0, 1, 0, heights_[0], heights_[1], heights_[2], heights_[3], 0, 0, 0, 0})));
    EXPECT_TRUE(distances_out_->Publish(ArrayOf({1, 2, 3, 4, 5, 6, 7, 8})));
  }
  static msg::SuspensionControl::Goal GoalOf(int mode, float height, float timeout_sec = 10) {
    return {static_cast<std::uint8_t>(mode), 0, height, timeout_sec};
  }

  static constexpr const char* kFile = "server = \"suspension\"\n";
  std::vector<float> heights_{20, 20, 20, 20};
  std::vector<float> targets_;
  std::vector<int> states_;
  int commands_ = 0;
  bool silent_ = false;
  bool stuck_ = false;
  std::unique_ptr<transport::Subscription> targets_in_;
  std::unique_ptr<transport::Subscription> state_in_;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> chassis_out_;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> distances_out_;
  transport::LoopHandlePtr hardware_;
};

TEST_F(SuspensionServerTest, SetsTheWheelsToAHeight) {
  Start(kFile);
  const std::size_t goal = Send(GoalOf(3, 230));
  ExpectEnd(goal, GoalEnd::kSucceeded, "Direct height set");
  EXPECT_THAT(targets_, ElementsAre(230, 230, 230, 230));
  EXPECT_GT(ends_[goal]->result.elapsed_sec, 0.9F);
  EXPECT_EQ(ends_[goal]->result.final_state, 0);
  Run(50);
  const int commands = commands_;
  Run(500);
  EXPECT_EQ(commands_, commands) << "nothing is sent any more";
}

TEST_F(SuspensionServerTest, ReportsSensorsAndWheelsAHundredTimesASecond) {
  Start(kFile);
  Send(GoalOf(1, 200));
  Run(100);
  feedback_.clear();
  commands_ = 0;
  Run(500);
  EXPECT_NEAR(double(feedback_.size()), 50, 2);
  EXPECT_NEAR(commands_, 50, 2);
  const auto& last = feedback_.back();
  EXPECT_EQ(last.current_state, 10);
  EXPECT_THAT(last.distance_data, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_THAT(last.photoelectric_data, ElementsAre(1, 0, 1, 0));
  EXPECT_THAT(last.wheel_heights_target, ElementsAre(205, 205, 205, 205));
  EXPECT_GT(last.wheel_heights_current.at(0), 100);
  EXPECT_GT(last.elapsed_sec, 0.5F);
}

TEST_F(SuspensionServerTest, PublishesTheStateOfAClimb) {
  Start(kFile);
  ExpectEnd(Send(GoalOf(1, 200, 3)), GoalEnd::kAborted, "Timeout");
  Run(100);
  // 13, 14: the distance of 1 mm is over a step; there is no second front switch.
  EXPECT_THAT(states_, ElementsAre(0, 10, 12, 13, 14, 0));
  EXPECT_EQ(ends_[0]->result.final_state, 14);
  EXPECT_THAT(log_, ::testing::Contains("the sequence has ended in UP_5_FRONT_LAND"));
}

TEST_F(SuspensionServerTest, RejectsMalformedGoals) {
  Start(kFile);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ExpectRejected(GoalOf(4, 200), "mode 4 is not one of 0 to 3");
  ExpectRejected({1, 255, 200, 10}, "direction 255 is not one of 0 to 3");
  ExpectRejected(GoalOf(3, nan), "height is not a finite number");
  ExpectRejected(GoalOf(3, 30, nan), "timeout_sec is not a finite number");
}

TEST_F(SuspensionServerTest, AbortsImpossibleGoalsWithTheReason) {
  Start(kFile);
  ExpectEnd(Send(GoalOf(0, 0)), GoalEnd::kAborted,
            "AUTO needs a height: above 0 it climbs up, below 0 down");
  ExpectEnd(Send(GoalOf(3, -170)), GoalEnd::kAborted, "a height of -170 mm is negative");
  ExpectEnd(Send(GoalOf(2, 600)), GoalEnd::kAborted,
            "a step of 600 mm is too high, at most 400 mm");
  EXPECT_EQ(commands_, 0) << "no wheel is moved";
}

TEST_F(SuspensionServerTest, HoldsTheWheelsWhenAGoalIsCancelled) {
  Start(kFile);
  const std::size_t goal = Send(GoalOf(1, 200));
  Run(500);
  Cancel(goal);
  ExpectEnd(goal, GoalEnd::kCanceled, "Cancelled");
  EXPECT_EQ(ends_[goal]->result.final_state, 10);
  Run(500);
  EXPECT_LT(heights_[0], 150) << "they have stopped on their way";
  EXPECT_NEAR(targets_.at(0), heights_[0], 0.1);
}

TEST_F(SuspensionServerTest, RejectsASecondGoalWhileOneRuns) {
  Start(kFile);
  const std::size_t goal = Send(GoalOf(3, 230));
  Run(200);
  ExpectRejected(GoalOf(3, 30), "another goal runs");
  ExpectEnd(goal, GoalEnd::kSucceeded, "Direct height set");
}

TEST_F(SuspensionServerTest, HoldsTheWheelsWhenTheRobotLeavesActive) {
  Start(kFile);
  const std::size_t goal = Send(GoalOf(1, 200));
  Run(500);
  server_->Permit(false, "an emergency stop holds it");
  ExpectEnd(goal, GoalEnd::kAborted, "Aborted: an emergency stop holds it");
  Run(500);
  EXPECT_NEAR(targets_.at(0), heights_[0], 0.1);
  EXPECT_LT(heights_[0], 150);
  const int commands = commands_;
  Run(500);
  EXPECT_EQ(commands_, commands);
  ExpectRejected(GoalOf(3, 30), "an emergency stop holds it");
}

TEST_F(SuspensionServerTest, HoldsTheWheelsAfterALongBreakOfItsProcess) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  const std::size_t goal = Send(GoalOf(1, 200));
  Run(500);
  suspended += std::chrono::minutes(2);
  ExpectEnd(goal, GoalEnd::kAborted, "Aborted: this server could not run for 120 s");
  Run(500);
  EXPECT_NEAR(targets_.at(0), heights_[0], 0.1);
  EXPECT_LT(heights_[0], 150);
}

TEST_F(SuspensionServerTest, NamesASilentHardware) {
  silent_ = true;
  Start(kFile);
  EXPECT_EQ(server_->Missing(),
            "no reading yet of the wheels on r0x0201; no reading yet of the distances on "
            "sensor_distances");
  ExpectEnd(Send(GoalOf(3, 30)), GoalEnd::kAborted, "the wheels do not report: no reading yet");
  silent_ = false;
  Run(100);
  EXPECT_EQ(server_->Missing(), "");
  const std::size_t goal = Send(GoalOf(1, 200));
  Run(300);
  silent_ = true;
  EXPECT_THAT(Await(goal).result.message, HasSubstr("Wheel feedback lost: no reading for 0.5 s"));
}

TEST_F(SuspensionServerTest, ReadsAndCommandsWheelsInTheOrderOfTheHardware) {
  // The corners clockwise from front-left: rear-left is the last one.
  Start("server = \"suspension\"\nwheel_order = [0, 1, 3, 2]\nswitch_order = [0, 1, 3, 2]\n");
  heights_ = {20, 21, 22, 23};
  stuck_ = true;
  Run(100);
  const std::size_t goal = Send(GoalOf(1, 200));
  Run(100);
  ASSERT_FALSE(feedback_.empty());
  EXPECT_THAT(feedback_.back().wheel_heights_current, ElementsAre(20, 21, 23, 22));
  EXPECT_THAT(feedback_.back().photoelectric_data, ElementsAre(1, 0, 0, 1));
  Cancel(goal);
  Run(100);
  EXPECT_THAT(targets_, ElementsAre(20, 21, 22, 23));
}

TEST_F(SuspensionServerTest, IgnoresMessagesThatAreTooShort) {
  silent_ = true;
  Start(kFile);
  EXPECT_TRUE(chassis_out_->Publish(ArrayOf({1, 1, 1, 1, 20, 20, 20})));
  EXPECT_TRUE(distances_out_->Publish(ArrayOf({})));
  Run(100);
  EXPECT_THAT(server_->Missing(), HasSubstr("no reading yet of the wheels"));
  EXPECT_THAT(
      log_, ::testing::Contains("a message of r0x0201 is ignored: it has 7 numbers, expected 12"));
}

TEST_F(SuspensionServerTest, HoldsTheWheelsWhenTheServerEnds) {
  Start(kFile);
  Send(GoalOf(1, 200));
  Run(500);
  server_.reset();
  Run(500);
  EXPECT_NEAR(targets_.at(0), heights_[0], 0.1);
  EXPECT_LT(heights_[0], 150);
}

}  // namespace musher::meilin::servers::suspension_server_test
