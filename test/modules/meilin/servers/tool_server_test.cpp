// arm_action and spear_action on a simulated network with a simulated hardware, in virtual time.

#include "musher/modules/meilin/servers/tool_server.hpp"

#include <chrono>
#include <limits>

#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/test/modules/meilin/servers/server_rig.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::meilin::servers::tool_server_test {

using testing::ArrayOf;
using ::testing::ElementsAre;
using transport::GoalEnd;

template <msg::Action A>
class ToolRig : public testing::ServerRig<A> {
 protected:
  ToolRig(const std::string& action, const std::string& command, const std::string& report) {
    this->action_ = action;
    command_ = command;
    ConnectHardware();
    report_out_ =
        this->Must(transport::MakePublisher<msg::Float32MultiArray>(*this->peer_, report));
    hardware_ = this->peer_->loop().Every(Milliseconds(10), [this] {
      left_ms_ -= 10;
      if (left_ms_ == 0 && !silent_) done_ = true;
      EXPECT_TRUE(report_out_->Publish(ArrayOf({done_ ? 1.0F : 0.0F, 0, 0, 0, 0, 0, 0, 0, 0})));
    });
  }

  void ConnectHardware() {
    command_in_ = this->Must(transport::MakeSubscription<msg::Float32MultiArray>(
        *this->peer_, command_, [this](const msg::Float32MultiArray& message, const auto&) {
          commands_.push_back(message.data);
          left_ms_ = message.data.at(0) == 0 ? 200 : 1000;
          done_ = false;
        }));
  }
  // Of a new process, which has stopped what its hardware did.
  void Start(const std::string& file) {
    testing::ServerRig<A>::Start(file);
    this->Run(1000);
    if (this->HasFailure()) return;
    EXPECT_THAT(commands_, ElementsAre(std::vector<float>{0, 0, 0, 0}));
    commands_.clear();
  }

  std::string command_;
  std::vector<std::vector<float>> commands_;
  int left_ms_ = 0;
  bool done_ = true;  // of something before
  bool silent_ = false;
  std::unique_ptr<transport::Subscription> command_in_;
  std::unique_ptr<transport::Publisher<msg::Float32MultiArray>> report_out_;
  transport::LoopHandlePtr hardware_;
};

class ArmServerTest : public ToolRig<msg::ArmAction> {
 protected:
  ArmServerTest() : ToolRig("arm_action", "t0x0103_", "r0x0203") {
    state_in_ = Must(transport::MakeSubscription<msg::Bool>(
        *peer_, "arm_runtime_state",
        [this](const msg::Bool& message, const auto&) {
          well_ = message.data;
          ++states_;
        },
        transport::kLatchedQos));
  }
  static constexpr const char* kFile = "server = \"arm\"\n";
  std::optional<bool> well_;
  int states_ = 0;
  std::unique_ptr<transport::Subscription> state_in_;
};

class SpearServerTest : public ToolRig<msg::SpearAction> {
 protected:
  SpearServerTest() : ToolRig("spear_action", "t0x0104_", "r0x0204") {}
};

TEST_F(ArmServerTest, CarriesOutACommand) {
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  ExpectEnd(goal, GoalEnd::kSucceeded, "Arm command 1 done");
  EXPECT_THAT(commands_, ElementsAre(std::vector<float>{1, 0, 0, 0}));
  EXPECT_EQ(ends_[goal]->result.final_state, 10);
  EXPECT_NEAR(ends_[goal]->result.elapsed_sec, 1, 0.1);
  EXPECT_EQ(feedback_.at(5).current_state, 2);
  EXPECT_EQ(feedback_.at(5).message, "GRASP");
  EXPECT_GT(feedback_.at(20).progress, feedback_.at(10).progress);
}

TEST_F(ArmServerTest, PublishesWhetherItIsIdleAndWell) {
  Start(kFile);
  EXPECT_EQ(well_, true);
  const std::size_t goal = Send({1, false, 0});
  Run(500);
  EXPECT_EQ(well_, false);
  Await(goal);
  Run(50);
  EXPECT_EQ(well_, true);
  silent_ = true;
  Await(Send({1, true, 1.5}));
  Run(50);
  EXPECT_EQ(well_, false) << "the command has failed";
  const int states = states_;
  Run(1000);
  EXPECT_NEAR(states_ - states, 5, 1) << "for clients that wait for the next one";
}

// Its done was taken for that of the first command of the next process.
TEST_F(ArmServerTest, StopsWhatAProcessBeforeItHasBegunOnceItsHardwareIsThere) {
  command_in_.reset();
  ServerRig::Start(kFile);
  Run(3000);
  EXPECT_EQ(well_, false) << "it is not known";
  left_ms_ = 500;  // it still works
  done_ = false;
  ConnectHardware();
  ASSERT_TRUE(RunUntil([this] { return !commands_.empty(); }));
  EXPECT_EQ(well_, false);
  ExpectEnd(Send({2, true, 0}), GoalEnd::kSucceeded, "Arm command 2 done");
  EXPECT_THAT(commands_,
              ElementsAre(std::vector<float>{0, 0, 0, 0}, std::vector<float>{2, 0, 0, 0}));
}

TEST_F(ArmServerTest, EndsAtItsLimitAndStopsTheArm) {
  silent_ = true;
  Start(kFile);
  const std::size_t goal = Send({5, true, 2});
  ExpectEnd(goal, GoalEnd::kAborted, "Timeout");
  Run(50);
  EXPECT_EQ(ends_[goal]->result.final_state, -1);
  EXPECT_THAT(commands_,
              ElementsAre(std::vector<float>{5, 0, 0, 0}, std::vector<float>{0, 0, 0, 0}));
}

TEST_F(ArmServerTest, RejectsUnknownCommands) {
  Start(kFile);
  ExpectRejected({7, true, 0}, "command 7 is not one of 0 to 6");
  ExpectRejected({1, true, std::numeric_limits<float>::infinity()},
                 "timeout_sec is not a finite number");
  EXPECT_TRUE(commands_.empty());
}

TEST_F(ArmServerTest, StopsTheArmWhenAGoalIsCancelled) {
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  Run(300);
  Cancel(goal);
  ExpectEnd(goal, GoalEnd::kCanceled, "Cancelled");
  Run(50);
  EXPECT_EQ(commands_.back(), (std::vector<float>{0, 0, 0, 0}));
}

TEST_F(ArmServerTest, SendsTheCommandAfterACancellationOnceTheArmIsIdle) {
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  Run(300);
  Cancel(goal);
  ExpectEnd(goal, GoalEnd::kCanceled, "Cancelled");
  const std::size_t next = Send({2, true, 0});
  ExpectEnd(next, GoalEnd::kSucceeded, "Arm command 2 done");
  EXPECT_THAT(commands_, ElementsAre(std::vector<float>{1, 0, 0, 0}, std::vector<float>{0, 0, 0, 0},
                                     std::vector<float>{2, 0, 0, 0}));
  EXPECT_NEAR(ends_[next]->result.elapsed_sec, 1.2, 0.1);
}

TEST_F(ArmServerTest, StopsTheArmOutsideOfActive) {
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  Run(300);
  ExpectRejected({2, true, 0}, "another goal runs");
  Await(goal);
  const std::size_t second = Send({2, true, 0});
  Run(300);
  server_->Permit(false, "it is in LowPower");
  ExpectEnd(second, GoalEnd::kAborted, "Aborted: it is in LowPower");
  Run(50);
  EXPECT_EQ(commands_.back(), (std::vector<float>{0, 0, 0, 0}));
  ExpectRejected({2, true, 0}, "it is in LowPower");
}

// A second goal is never accepted while one runs: the late goal was to replace nothing.
TEST_F(ArmServerTest, GoesOnWithItsCommandWhereALateGoalIsRejected) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  Run(300);
  suspended += std::chrono::seconds(9);
  EXPECT_EQ(Await(Send({2, true, 0})).end, GoalEnd::kRejected);
  EXPECT_THAT(log_,
              ::testing::Contains(musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate)));
  ExpectEnd(goal, GoalEnd::kSucceeded, "Arm command 1 done");
}

TEST_F(ArmServerTest, StopsTheArmAfterALongBreakOfItsProcess) {
  Duration& suspended = MakeSuspendable();
  Start(kFile);
  const std::size_t goal = Send({1, true, 0});
  Run(300);
  suspended += std::chrono::minutes(2);
  ExpectEnd(goal, GoalEnd::kAborted, "Aborted: this server could not run for 120 s");
  Run(50);
  EXPECT_EQ(commands_.back(), (std::vector<float>{0, 0, 0, 0}));
}

TEST_F(ArmServerTest, NamesASilentHardware) {
  hardware_.reset();
  report_out_.reset();
  Start(kFile);
  EXPECT_EQ(server_->Missing(), "no publisher of r0x0203");
}

// Another robot of the same image is in reach: `peer_` may be a program of it.
class ArmBesideAnotherRobot : public ArmServerTest {
 protected:
  using Statuses = std::unique_ptr<transport::Publisher<msg::ActuatorStatus>>;

  ArmBesideAnotherRobot() {
    others_ = Must(transport::OtherMachines::Make(*node_, ""));
    own_ = Advertise(*node_);
    PublishStatus(own_, *node_, "r2");
  }

  Statuses Advertise(transport::Node& node) {
    return Must(transport::MakePublisher<msg::ActuatorStatus>(
        node, transport::ActuatorStatusTopic(""), transport::kLatchedQos));
  }
  void PublishStatus(const Statuses& statuses, transport::Node& node, const std::string& machine) {
    msg::ActuatorStatus status;
    status.name = "mission";
    status.state = "Active";
    status.machine = machine;
    status.host = &node == node_.get() ? "boot of r2" : "boot of another computer";
    status.participant = node.participant().value();
    ASSERT_TRUE(statuses->Publish(status));
    Run(200);
  }

  Statuses own_;
  Statuses theirs_;
};

TEST_F(ArmBesideAnotherRobot, CarriesOutNoGoalOfItsMission) {
  theirs_ = Advertise(*peer_);
  PublishStatus(theirs_, *peer_, "another r2");
  Start(kFile);
  ExpectRejected({1, true, 0}, "it is of another machine, another r2");
  EXPECT_TRUE(commands_.empty());
}

TEST_F(ArmBesideAnotherRobot, CarriesOutNoGoalBeforeItIsKnownWhoseMissionItIs) {
  theirs_ = Advertise(*peer_);
  Start(kFile);
  ExpectRejected({1, true, 0}, "the status of its sender has not arrived");
  EXPECT_TRUE(commands_.empty());
  PublishStatus(theirs_, *peer_, "r2");
  ExpectEnd(Send({1, true, 0}), GoalEnd::kSucceeded, "Arm command 1 done");
}

TEST_F(ArmBesideAnotherRobot, CarriesOutTheGoalOfAProgramWithoutAStatus) {
  Start(kFile);
  ExpectEnd(Send({1, true, 0}), GoalEnd::kSucceeded, "Arm command 1 done");
}

TEST_F(SpearServerTest, CarriesOutEachCommand) {
  Start("server = \"spear\"\n");
  EXPECT_EQ(server_->Missing(), "");
  const std::vector<int> states = {0, 1, 2, 5, 6};
  for (int command = 1; command <= 4; ++command) {
    feedback_.clear();
    ExpectEnd(Send({static_cast<std::uint8_t>(command), 0}), GoalEnd::kSucceeded,
              "Spear command " + std::to_string(command) + " done");
    EXPECT_EQ(commands_.back(), (std::vector<float>{float(command), 0, 0, 0}));
    EXPECT_EQ(feedback_.at(3).current_state, states[command]);
  }
  ExpectRejected({5, 0}, "command 5 is not one of 0 to 4");
}

TEST_F(SpearServerTest, HasALimitOfFiveSeconds) {
  silent_ = true;
  Start("server = \"spear\"\n");
  const std::size_t goal = Send({1, 0});
  ExpectEnd(goal, GoalEnd::kAborted, "Timeout");
  EXPECT_NEAR(ends_[goal]->result.elapsed_sec, 5, 0.1);
}

}  // namespace musher::meilin::servers::tool_server_test
