// The actions of nav2 by plain clients, on a simulated network: each pose is a run of navigate_to.

#include "musher/modules/skills/nav2/nav2_goals.hpp"

#include <gmock/gmock.h>

#include "musher/messages/nav2_msgs/follow_waypoints.hpp"
#include "musher/messages/nav2_msgs/navigate_through_poses.hpp"
#include "musher/messages/nav2_msgs/navigate_to_pose.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/test/modules/skills/moving_robot.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skills::nav2_goals_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MovingRobot;
using ::testing::SizeIs;
using transport::GoalEnd;

template <class Action>
struct Sent {
  std::unique_ptr<transport::ActionClient<Action>> client;
  transport::GoalId id{};
  std::optional<transport::GoalOutcome<Action>> end;
  std::vector<typename Action::Feedback> feedback;
};

class Nav2 : public ::testing::Test {
 protected:
  // `run_limit`: of each run of a skill; nullopt: as the skills declare it.
  explicit Nav2(std::optional<Duration> run_limit = std::nullopt) {
    EXPECT_TRUE(RegisterNavigationSkills(registry_, robot_));
    std::vector<skill::Entry> entries = registry_.All();
    for (skill::Entry& entry : entries) entry.settings.run = run_limit;
    manager_ = std::make_unique<skill::Manager>(std::move(entries));
    InterfaceNames names;
    names.navigate_to_pose = "navigate_to_pose";
    names.navigate_through_poses = "navigate_through_poses";
    names.follow_waypoints = "follow_waypoints";
    names.goal_pose = "goal_pose";
    nav2_ = std::make_unique<Nav2Goals>(
        Nav2Goals::Context{robot_, *manager_, [this] { return may_start_; },
                           [this](LogLevel, const std::string& line) { log_.push_back(line); }},
        names, endpoints_);
    EXPECT_TRUE(endpoints_.opened());
    steps_ = node_->loop().Every(Milliseconds(100), [this] {
      robot_.Advance(Milliseconds(100));
      manager_->RunOnce(node_->loop().Now());
      nav2_->Update();
    });
  }
  ~Nav2() override { nav2_.reset(); }

  static msg::PoseStamped At(double x_m, double y_m) {
    return ToMessage(navigation::Pose{{x_m, y_m, 0}, 0}, {});
  }
  template <class Action>
  std::unique_ptr<Sent<Action>> Send(const std::string& name, const typename Action::Goal& goal) {
    auto sent = std::make_unique<Sent<Action>>();
    sent->client = std::move(transport::MakeActionClient<Action>(*peer_, name)).value();
    Run(1);  // discovery
    transport::GoalEvents<Action> events;
    events.on_end = [&to = *sent](const auto& outcome) { to.end = outcome; };
    events.on_feedback = [&to = *sent](const auto& feedback) { to.feedback.push_back(feedback); };
    sent->id = sent->client->SendGoal(goal, Milliseconds(2000), std::move(events));
    return sent;
  }
  auto ToPose(const msg::PoseStamped& pose) {
    return Send<msg::NavigateToPose>("navigate_to_pose", {.pose = pose, .behavior_tree = {}});
  }
  // As RViz does.
  void Click(const msg::PoseStamped& pose) {
    if (!button_) {
      button_ = transport::MakePublisher<msg::PoseStamped>(*peer_, "goal_pose").value();
      Run(1);  // discovery
    }
    EXPECT_TRUE(button_->Publish(pose));
    Run(0.1);
  }
  void Run(double seconds) { network_.RunFor(FromSeconds(seconds)); }
  template <class Action>
  bool Await(const Sent<Action>& sent, double seconds = 60) {
    return network_.RunUntil([&] { return sent.end.has_value(); },
                             network_.now() + FromSeconds(seconds));
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peer_ = network_.MakeNode("desk");
  MovingRobot robot_;
  skill::Registry registry_;
  std::unique_ptr<skill::Manager> manager_;
  Result<> may_start_;
  std::vector<std::string> log_;
  transport::Endpoints endpoints_{*node_, ""};
  std::unique_ptr<Nav2Goals> nav2_;
  std::unique_ptr<transport::Publisher<msg::PoseStamped>> button_;
  transport::LoopHandlePtr steps_;
};

TEST_F(Nav2, NavigatesToAPoseForAPlainClient) {
  const auto sent = ToPose(At(4, 3));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kSucceeded) << sent->end->result.error_msg;
  EXPECT_NEAR(robot_.at.at.x_m, 4, 0.2);
  ASSERT_FALSE(sent->feedback.empty());
  EXPECT_EQ(sent->feedback.back().current_pose.header.frame_id, "map");
  EXPECT_LT(sent->feedback.back().distance_remaining, 5);
  EXPECT_GT(sent->feedback.back().navigation_time.sec, 2);
}

TEST_F(Nav2, EndsWithTheReasonOfTheSkill) {
  robot_.plan = [](const auto&, const auto&) -> Result<navigation::Path> {
    return MakeError(navigation::Fault::kWalledIn, "the goal is walled in");
  };
  const auto sent = ToPose(At(4, 3));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kAborted);
  EXPECT_EQ(sent->end->result.error_code, msg::NavigateToPose::kUnknown);
  EXPECT_EQ(sent->end->result.error_msg, "Planning failed: the goal is walled in");
}

TEST_F(Nav2, RefusesWhatItCannotBegin) {
  auto other_frame = At(4, 3);
  other_frame.header.frame_id = "odom";
  auto sent = ToPose(other_frame);
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->result.error_code, msg::NavigateToPose::kTfError);
  auto no_number = At(std::nan(""), 3);
  sent = ToPose(no_number);
  ASSERT_TRUE(Await(*sent));
  EXPECT_THAT(sent->end->result.error_msg, HasSubstr("not finite"));
  ASSERT_TRUE(manager_->Start("track", {{"target_topic", std::string("/t")}}));
  robot_.targets["/t"] = [](Time) { return navigation::Pose{{9, 0, 0}, 0}; };
  sent = ToPose(At(4, 3));
  ASSERT_TRUE(Await(*sent));
  EXPECT_THAT(sent->end->result.error_msg, HasSubstr("track"));
  manager_->CancelAllNow("the test");
  may_start_ = Error{kCodeStateInvalid, "it runs no skills in DeActive"};
  sent = ToPose(At(4, 3));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->result.error_msg, "it runs no skills in DeActive");
}

TEST_F(Nav2, DrivesToAPoseOfTheTopicOfRViz) {
  Click(At(4, 3));
  Run(20);
  EXPECT_NEAR(robot_.at.at.x_m, 4, 0.2);
  EXPECT_NEAR(robot_.at.at.y_m, 3, 0.2);
  EXPECT_THAT(log_, ElementsAre("the goal (4.00, 3.00) on goal_pose is reached"));
  const auto sent = ToPose(At(40, 3));
  Run(2);
  Click(At(2, 3));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->result.error_msg, "a newer goal has replaced this one");
  Run(20);
  EXPECT_NEAR(robot_.at.at.x_m, 2, 0.2);
}

TEST_F(Nav2, RefusesAPoseOfTheTopicOfRVizWithTheReason) {
  may_start_ = Error{kCodeStateInvalid, "it runs no skills in DeActive"};
  Click(At(4, 3));
  may_start_ = Ok();
  auto other_frame = At(4, 3);
  other_frame.header.frame_id = "odom";
  Click(other_frame);
  ASSERT_TRUE(manager_->Start("track", {{"target_topic", std::string("/t")}}));
  Click(At(4, 3));
  EXPECT_THAT(log_,
              ElementsAre("a goal on goal_pose is refused: it runs no skills in DeActive",
                          HasSubstr("is refused: the frame of the goal is 'odom'"),
                          AllOf(HasSubstr("the goal (4.00, 3.00) on goal_pose is not reached"),
                                HasSubstr("track"))));
  Run(3);
  EXPECT_EQ(robot_.drives, 0);
}

TEST_F(Nav2, StandsAtACancellation) {
  const auto sent = ToPose(At(40, 3));
  Run(3);
  sent->client->Cancel(sent->id, Milliseconds(1000), [](const auto&) {});
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kCanceled);
  Run(1);
  EXPECT_TRUE(robot_.Rests());
}

TEST_F(Nav2, ReplacesThePresentGoalByANewerOne) {
  const auto first = ToPose(At(40, 3));
  Run(2);
  const auto second = ToPose(At(2, 3));
  ASSERT_TRUE(Await(*second));
  EXPECT_EQ(second->end->end, GoalEnd::kSucceeded) << second->end->result.error_msg;
  ASSERT_TRUE(first->end);
  EXPECT_EQ(first->end->end, GoalEnd::kAborted);
  EXPECT_EQ(first->end->result.error_msg, "a newer goal has replaced this one");
}

TEST_F(Nav2, EndsAGoalWhoseSkillsAreCancelled) {
  const auto sent = ToPose(At(40, 3));
  Run(2);
  manager_->CancelAllNow("emergency stop");
  nav2_->Update();
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kAborted);
  EXPECT_THAT(sent->end->result.error_msg, HasSubstr("emergency stop"));
}

// While the robot was not Active a person cancelled the run, then a client sent it elsewhere. It
// was sent to the next way-point at the end of that run.
TEST_F(Nav2, DoesNotTakeTheRunOfAnotherClientForItsOwn) {
  const auto sent = Send<msg::FollowWaypoints>("follow_waypoints", {.poses = {At(9, 0), At(0, 9)}});
  Run(2);
  ASSERT_TRUE(manager_->CancelNow("navigate_to", "by alice"));
  ASSERT_TRUE(manager_->Start("navigate_to", {{"goal_pos", skill::Numbers{4, 3, 0}}}));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kAborted);
  EXPECT_EQ(sent->end->result.error_msg,
            "its run has ended, and another client has started navigate_to");
  Run(20);
  EXPECT_NEAR(robot_.at.at.x_m, 4, 0.2);
  EXPECT_EQ(robot_.drives, 2);
}

TEST_F(Nav2, ItsCancellationLeavesTheRunOfAnotherClient) {
  const auto sent = ToPose(At(9, 0));
  Run(2);
  ASSERT_TRUE(manager_->CancelNow("navigate_to", "by alice"));
  ASSERT_TRUE(manager_->Start("navigate_to", {{"goal_pos", skill::Numbers{4, 3, 0}}}));
  sent->client->Cancel(sent->id, Milliseconds(1000), [](const auto&) {});
  ASSERT_TRUE(Await(*sent));
  Run(20);
  EXPECT_NEAR(robot_.at.at.x_m, 4, 0.2);
}

TEST_F(Nav2, DrivesThroughPosesAndEndsAtTheFirstThatItDoesNotReach) {
  const auto sent = Send<msg::NavigateThroughPoses>(
      "navigate_through_poses", {.poses = {At(2, 0), At(2, 2), At(0, 2)}, .behavior_tree = {}});
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kSucceeded) << sent->end->result.error_msg;
  EXPECT_EQ(robot_.drives, 3);
  EXPECT_EQ(sent->feedback.back().number_of_poses_remaining, 1);
  robot_.plan = [](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (goal.at.x_m < 5) return navigation::Path{start, goal};
    return MakeError(navigation::Fault::kWalledIn, "walled in");
  };
  const auto fails = Send<msg::NavigateThroughPoses>(
      "navigate_through_poses", {.poses = {At(2, 0), At(6, 2), At(0, 2)}, .behavior_tree = {}});
  ASSERT_TRUE(Await(*fails));
  EXPECT_EQ(fails->end->end, GoalEnd::kAborted);
  EXPECT_EQ(robot_.drives, 4);
}

TEST_F(Nav2, FollowsWayPointsInLoopsAndListsThoseThatItHasMissed) {
  robot_.plan = [](const auto& start, const auto& goal) -> Result<navigation::Path> {
    if (goal.at.x_m < 5) return navigation::Path{start, goal};
    return MakeError(navigation::Fault::kWalledIn, "walled in");
  };
  const auto sent = Send<msg::FollowWaypoints>(
      "follow_waypoints",
      {.number_of_loops = 1, .goal_index = 1, .poses = {At(2, 0), At(6, 2), At(0, 2)}});
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kAborted);
  EXPECT_EQ(sent->end->result.error_msg,
            "2 way-points not reached; the first one: Planning failed: walled in");
  ASSERT_THAT(sent->end->result.missed_waypoints, SizeIs(2));
  EXPECT_EQ(sent->end->result.missed_waypoints[0].index, 1U);
  EXPECT_EQ(robot_.drives, 3) << "(0, 2), then (2, 0) and (0, 2)";
}

class Nav2WithRunsOfThreeSeconds : public Nav2 {
 protected:
  Nav2WithRunsOfThreeSeconds() : Nav2(std::chrono::seconds(3)) {}
};

// The robot drove to the next way-point.
TEST_F(Nav2WithRunsOfThreeSeconds, DrivesToNoOtherWayPointWhenARunFailsDuringItsCancellation) {
  const auto sent = Send<msg::FollowWaypoints>(
      "follow_waypoints",
      {.number_of_loops = 0, .goal_index = 0, .poses = {At(40, 0), At(0, 40), At(0, 2)}});
  Run(2.9);
  ASSERT_TRUE(manager_->running());
  ASSERT_EQ(robot_.drives, 1);
  sent->client->Cancel(sent->id, Milliseconds(1000), [](const auto&) {});
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kCanceled);
  EXPECT_THAT(sent->end->result.missed_waypoints, SizeIs(0));
  Run(3);
  EXPECT_EQ(robot_.drives, 1);
  EXPECT_TRUE(robot_.Rests());
}

// With a low battery the run of a skill ends, and the next one began before it was known again.
TEST_F(Nav2, DrivesToNoOtherWayPointOnceNoSkillMayStart) {
  const auto sent = Send<msg::FollowWaypoints>(
      "follow_waypoints",
      {.number_of_loops = 1000, .goal_index = 0, .poses = {At(40, 0), At(0, 40)}});
  Run(2);
  ASSERT_EQ(robot_.drives, 1);
  may_start_ = Error{kCodeProtectedError, "the battery of r is at 0 %, its limit is 0 %"};
  ASSERT_TRUE(manager_->FailNow("navigate_to", "navigate_to has ended: the battery"));
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kAborted);
  EXPECT_EQ(sent->end->result.error_msg, "the battery of r is at 0 %, its limit is 0 %");
  EXPECT_THAT(sent->end->result.missed_waypoints, SizeIs(1));
  may_start_ = Ok();
  Run(3);
  EXPECT_EQ(robot_.drives, 1) << "charged, it does not drive off by itself";
}

TEST_F(Nav2, FliesToAPoseOfTheTopicOfRVizAtThePresentHeight) {
  robot_.robot_kind = "cf2x";
  robot_.at.at.z_m = 1.5;
  Click(At(4, 3));
  Run(20);
  EXPECT_NEAR(robot_.at.at.x_m, 4, 0.2);
  EXPECT_NEAR(robot_.at.at.z_m, 1.5, 0.2);
  EXPECT_THAT(log_, ElementsAre("the goal (4.00, 3.00, 1.50) on goal_pose is reached"));
}

TEST_F(Nav2, KeepsThePresentGoalWhenTheHeightOfANewerOneIsRefused) {
  robot_.robot_kind = "cf2x";
  robot_.ceiling = 3;
  robot_.at.at.z_m = 1.5;
  auto far = At(20, 0), high = At(4, 3), low = At(4, 3);
  far.pose.position.z = 1.5;
  high.pose.position.z = 9;
  const auto sent = ToPose(far);
  Run(2);
  Click(high);
  EXPECT_THAT(log_, ElementsAre(AllOf(HasSubstr("is refused: "), HasSubstr("the ceiling"))));
  const auto refused = ToPose(low);
  ASSERT_TRUE(Await(*refused));
  EXPECT_THAT(refused->end->result.error_msg, HasSubstr("expected more than 0 m"));
  EXPECT_FALSE(sent->end);
  ASSERT_TRUE(Await(*sent));
  EXPECT_EQ(sent->end->end, GoalEnd::kSucceeded);
}

TEST_F(Nav2, RefusesGoalsWithoutPoses) {
  const auto empty = Send<msg::FollowWaypoints>("follow_waypoints", {});
  ASSERT_TRUE(Await(*empty));
  EXPECT_EQ(empty->end->result.error_msg, "the goal has no poses");
  const auto beyond = Send<msg::FollowWaypoints>(
      "follow_waypoints", {.number_of_loops = 0, .goal_index = 7, .poses = {At(1, 0)}});
  ASSERT_TRUE(Await(*beyond));
  EXPECT_EQ(beyond->end->result.error_msg, "goal_index is 7, of 1 pose");
}

}  // namespace musher::skills::nav2_goals_test
