// Goals whose server hangs or is lost, on a simulated network in virtual time.

#include "musher/modules/meilin/mission/goal_channel.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "musher/messages/r2_interfaces/suspension_control.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::meilin::goal_channel_test {

using ::testing::SizeIs;
using Action = msg::SuspensionControl;

class AGoalChannel : public ::testing::Test {
 protected:
  AGoalChannel() {
    transport::ActionHandlers<Action> handlers;
    handlers.start = [this](transport::ServerGoal<Action> goal) {
      goal.Execute();
      goals_.push_back(goal);
    };
    handlers.cancel = [this](transport::ServerGoal<Action> goal) {
      cancelled_.push_back(goal.id());
      goal.Canceled({});
    };
    served_.ServeAction<Action>("suspension_control", std::move(handlers));
    Run(1000);  // discovery
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> server_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> mission_ = network_.MakeNode("mission");
  std::vector<transport::ServerGoal<Action>> goals_;
  std::vector<transport::GoalId> cancelled_;
  transport::Endpoints served_{*server_, ""};
  std::unique_ptr<transport::ActionClient<Action>> client_ =
      transport::MakeActionClient<Action>(*mission_, "suspension_control").value();
  std::shared_ptr<GoalChannel<Action>> channel_ = std::make_shared<GoalChannel<Action>>(
      client_.get(), mission_->loop(), std::chrono::seconds(3), [](const auto&) { return ""; });
};

TEST_F(AGoalChannel, CancelsAGoalThatIsAcceptedAfterItWasDropped) {
  network_.Pause(*server_);
  const GoalPtr climb = channel_->Begin({});
  Run(200);
  climb->Cancel();
  Run(1200);
  const GoalPtr later = channel_->Begin({});
  EXPECT_EQ(climb->state(), GoalState::kLost);
  network_.Resume(*server_);
  Run(1000);
  ASSERT_THAT(goals_, SizeIs(2));
  ASSERT_THAT(cancelled_, SizeIs(1));
  EXPECT_EQ(cancelled_[0], goals_[0].id());
  EXPECT_EQ(later->state(), GoalState::kAccepted);
}

TEST_F(AGoalChannel, CancelsAGoalWhoseServerItHasLostOnceThatGoesOn) {
  const GoalPtr climb = channel_->Begin({});
  Run(200);
  ASSERT_EQ(climb->state(), GoalState::kAccepted);
  network_.Partition("robot", "mission");
  Run(60'000);
  EXPECT_EQ(climb->state(), GoalState::kLost);
  network_.Heal("robot", "mission");
  Run(3000);
  EXPECT_THAT(cancelled_, SizeIs(1));
}

}  // namespace musher::meilin::goal_channel_test
