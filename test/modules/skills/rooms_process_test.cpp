// A machine of real programs in the rooms: world, planner, controller and the skills of a robot.
// Its client is plain C and has only ROS 2's wire.

#include <gmock/gmock.h>

#include <cmath>
#include <csignal>
#include <future>
#include <limits>
#include <utility>

#include "musher/messages/nav2_msgs/navigate_to_pose.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/test/modules/skills/skills_machine.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/dds/node_thread.hpp"

namespace musher::skills::rooms_process_test {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

class Rooms : public SkillsMachine {
 protected:
  Rooms()
      : SkillsMachine(
            {{"world", "[\"musher-world\", \"scenes/rooms.toml\"]"},
             {"planner_server", "[\"musher-planner\", \"navigation/planner.toml\"]", "\"world\""},
             {"controller_server", "[\"musher-controller\", \"navigation/controller.toml\"]",
              "\"world\""},
             {"jetbot_0", "[\"musher-skills\", \"skills/jetbot_0.toml\"]",
              "\"planner_server\", \"controller_server\""}},
            "clock = \"topic\"\n") {
    Up();
  }
  // What the client prints of a goal of nav_2d. `more`: "cancel".
  static std::string Navigate(const std::string& place, const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{BinDir() + "/skill_client_peer",
                                   std::to_string(transport::TestDomain()),
                                   "jetbot_0/skill_execution",
                                   "nav_2d",
                                   "goal_pos",
                                   place};
    words.insert(words.end(), more.begin(), more.end());
    const testing::Ended ended = testing::RunToEnd(words);
    EXPECT_EQ(ended.exit, 0) << ended.out << ended.err;
    return ended.out;
  }
  // From the robot to a place of the map, m, by its next odometry.
  static double Distance(double x_m, double y_m) {
    const auto node = transport::NodeThread::Start().value();
    std::promise<double> distance;
    std::unique_ptr<transport::Subscription> subscription;
    bool first = true;
    node->RunOnLoop([&] {
      subscription = transport::MakeSubscription<msg::Odometry>(
                         node->node(), "jetbot_0/odom",
                         [&](const msg::Odometry& odometry, const auto&) {
                           const msg::Point& at = odometry.pose.pose.position;
                           if (std::exchange(first, false))
                             distance.set_value(std::hypot(at.x - x_m, at.y - y_m));
                         })
                         .value();
    });
    auto came = distance.get_future();
    const bool in_time = came.wait_for(std::chrono::seconds(120)) == std::future_status::ready;
    node->RunOnLoop([&] { subscription.reset(); });
    return in_time ? came.get() : std::numeric_limits<double>::quiet_NaN();
  }
};

using RoomsNightly = Rooms;

TEST_F(Rooms, LetAPlainClientNavigateARobot) {
  EXPECT_THAT(Navigate("[1.8, 1.2, 0]"),
              MatchesRegex("offered by jetbot_0 on /jetbot_0/skill_execution: [^\n]*nav_2d[^\n]*\n"
                           "accepted\n"
                           "feedback: processing: [^\n]*\n"
                           "result of status 4: true completed: Reached goal .100%.\n"));
  EXPECT_THAT(Navigate("[11, 8]"),
              HasSubstr("result of status 6: false failed: Planning failed: no path is wide enough "
                        "for the robot: the goal (11.00, 8.00) or the start is walled in"));
  const std::string cancelled = Navigate("[4, 1.2]", {"cancel"});
  EXPECT_THAT(cancelled, HasSubstr("cancel: code 0\n"));
  EXPECT_THAT(cancelled, HasSubstr("result of status 5: false cancelled: by its client"));
}

TEST_F(Rooms, LetAClientOfNav2SendARobotToAPose) {
  using Client = transport::ActionClient<msg::NavigateToPose>;
  using Outcome = transport::GoalOutcome<msg::NavigateToPose>;
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<Client> client;
  transport::LoopHandlePtr until_ready;
  std::promise<Outcome> ended;
  bool sent = false;
  node->RunOnLoop([&] {
    client = std::move(transport::MakeActionClient<msg::NavigateToPose>(
                           node->node(), "jetbot_0/navigate_to_pose"))
                 .value();
    until_ready = node->loop().Every(Milliseconds(50), [&] {
      if (!client->Ready() || std::exchange(sent, true)) return;
      msg::NavigateToPose::Goal goal;
      goal.pose.header.frame_id = "map";
      goal.pose.pose.position = {1.8, 1.2, 0};
      goal.pose.pose.orientation.w = 1;
      transport::GoalEvents<msg::NavigateToPose> events;
      events.on_end = [&ended](const Outcome& outcome) { ended.set_value(outcome); };
      client->SendGoal(goal, std::chrono::seconds(120), std::move(events));
    });
  });
  auto end = ended.get_future();
  const bool in_time = end.wait_for(std::chrono::seconds(240)) == std::future_status::ready;
  node->RunOnLoop([&] {
    until_ready.reset();
    client.reset();
  });
  ASSERT_TRUE(in_time);
  const Outcome outcome = end.get();
  EXPECT_EQ(outcome.end, transport::GoalEnd::kSucceeded) << outcome.result.error_msg;
  EXPECT_NEAR(Distance(1.8, 1.2), 0, 0.3);
}

TEST_F(RoomsNightly, LetARobotGoFromWayPointToWayPoint) {
  const testing::Ended moved =
      Skill({"move", "path=[[1.8, 1.2], [1.8, 2.0], [1.2, 1.2]]", "loops=1"});
  EXPECT_EQ(moved.exit, 0) << moved.out << moved.err;
  EXPECT_NEAR(Distance(1.2, 1.2), 0, 0.3);
}

TEST_F(RoomsNightly, LetARobotGoToAPlaceWithoutAMap) {
  const testing::Ended arrived = Skill({"avoid_obstacle", "goal_pos=[2.2, 1.2]"});
  EXPECT_EQ(arrived.exit, 0) << arrived.out << arrived.err;
  EXPECT_NEAR(Distance(2.2, 1.2), 0, 0.3);
}

TEST_F(RoomsNightly, LetARobotStandBeforeWhatItsDetectorSees) {
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<transport::Publisher<msg::PoseStamped>> place;
  transport::LoopHandlePtr again;
  msg::PoseStamped before_the_car;
  before_the_car.pose.position = {1.8, 5.8, 0};
  before_the_car.pose.orientation.w = 1;
  node->RunOnLoop([&] {
    place =
        transport::MakePublisher<msg::PoseStamped>(node->node(), "world/jetbot_0/place").value();
    again = node->loop().Every(Milliseconds(200), [&] {
      if (place->MatchedReaders() > 0) static_cast<void>(place->Publish(before_the_car));
    });
  });
  for (int i = 0; i < 20 && !(Distance(1.8, 5.8) < 0.01); ++i) {
  }
  node->RunOnLoop([&] {
    again.reset();
    place.reset();
  });
  ASSERT_NEAR(Distance(1.8, 5.8), 0, 0.01);
  const testing::Ended seen = Skill({"visual_servoing", "target=car", "distance=0.8"});
  EXPECT_EQ(seen.exit, 0) << seen.out << seen.err;
  EXPECT_NEAR(Distance(3.9, 5.2), 0.8, 0.1);
  const testing::Ended lost = Skill({"visual_servoing", "target=unicorn"});
  EXPECT_THAT(lost.out + lost.err, HasSubstr("unicorn is not seen"));
}

// The target is a robot of another machine, whose odometry this test publishes; the movers of the
// scene have other names.
TEST_F(RoomsNightly, LetARobotFollowATarget) {
  const auto node = transport::NodeThread::Start().value();
  std::unique_ptr<transport::Publisher<msg::Odometry>> target;
  transport::LoopHandlePtr again;
  msg::Odometry odometry;
  odometry.header.frame_id = "map";
  odometry.pose.pose.position = {4, 1.2, 0};
  odometry.pose.pose.orientation.w = 1;
  node->RunOnLoop([&] {
    target = transport::MakePublisher<msg::Odometry>(node->node(), "leader/odom").value();
    again =
        node->loop().Every(Milliseconds(50), [&] { static_cast<void>(target->Publish(odometry)); });
  });
  testing::Process tracks(
      {BinDir() + "/musher", "skill", "run", "track", "target_topic=leader/odom", "distance=1.5"});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  double apart_m = Distance(4, 1.2);
  while (apart_m > 2 && std::chrono::steady_clock::now() < deadline) apart_m = Distance(4, 1.2);
  tracks.Signal(SIGINT);  // cancels it
  const testing::Ended tracked = tracks.Wait();
  node->RunOnLoop([&] {
    again.reset();
    target.reset();
  });
  EXPECT_NEAR(apart_m, 1.75, 0.3) << tracked.out << tracked.err;
  EXPECT_THAT(tracked.out + tracked.err, HasSubstr("ancelled"));
}

}  // namespace musher::skills::rooms_process_test
