// musher-route as its clients use it: the real program over DDS.

#include <fstream>
#include <memory>
#include <string>

#include "musher/messages/nav2_msgs/compute_and_track_route.hpp"
#include "musher/messages/nav2_msgs/compute_route.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/test/modules/module_process.hpp"
#include "musher/test/navigation/route_graphs.hpp"
#include "musher/transport/action.hpp"

namespace musher::navigation::route_process_test {

using ::testing::HasSubstr;
using transport::GoalEnd;

class RouteProcess : public test::ModuleProcess {
 protected:
  RouteProcess() : ModuleProcess("route_server", "musher-route") {
    std::ofstream(folder_ / "graph.geojson")
        << testing::JsonOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}}, {{12, 1, 2}});
    file_ = "graph = \"" + (folder_ / "graph.geojson") +
            "\"\nself_check_ms = 15000\nstale_ms = 10000\n[[robot]]\nname = \"jetbot_0\"\n";
  }
  // Where the robot is from now on.
  void Place(double x_m) {
    if (!odometry_) {
      odometry_ = Publisher<msg::Odometry>("jetbot_0/odom", transport::kSensorDataQos);
      timer_ = peer_.node().loop().Every(Milliseconds(50), [this] {
        msg::Odometry odometry;
        odometry.header.frame_id = "map";
        odometry.pose.pose.position.x = x_m_;
        EXPECT_TRUE(odometry_->Publish(odometry));
      });
    }
    x_m_ = x_m;
  }

  const TempFolder folder_;
  std::string file_;
  double x_m_ = 0;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_;
  transport::LoopHandlePtr timer_;
};

TEST_F(RouteProcess, FindsAndTracksARouteInActive) {
  Place(0);
  Start(file_);
  ExpectDone("SelfCheck");
  ExpectDone("Active");
  const auto routes =
      transport::MakeActionClient<msg::ComputeRoute>(peer_.node(), "jetbot_0/compute_route")
          .value();
  std::optional<transport::GoalOutcome<msg::ComputeRoute>> route;
  transport::GoalEvents<msg::ComputeRoute> events;
  events.on_end = [&](const auto& end) { route = end; };
  msg::ComputeRoute::Goal goal;
  goal.use_poses = true;
  goal.goal.pose.position.x = 10;
  routes->SendGoal(goal, Milliseconds(120'000), std::move(events));
  ASSERT_TRUE(peer_.Until([&] { return route.has_value(); })) << peer_.Output();
  EXPECT_EQ(route->end, GoalEnd::kSucceeded) << route->reason << peer_.Output();
  EXPECT_EQ(route->result.route.nodes.size(), 2U);

  const auto tracks = transport::MakeActionClient<msg::ComputeAndTrackRoute>(
                          peer_.node(), "jetbot_0/compute_and_track_route")
                          .value();
  std::optional<transport::GoalOutcome<msg::ComputeAndTrackRoute>> tracked;
  transport::GoalEvents<msg::ComputeAndTrackRoute> reports;
  reports.on_feedback = [&](const auto& feedback) {
    if (feedback.next_node_id == 2) Place(10);
  };
  reports.on_end = [&](const auto& end) { tracked = end; };
  msg::ComputeAndTrackRoute::Goal to_track;
  to_track.start_id = 1;
  to_track.goal_id = 2;
  tracks->SendGoal(to_track, Milliseconds(120'000), std::move(reports));
  ASSERT_TRUE(peer_.Until([&] { return tracked.has_value(); })) << peer_.Output();
  EXPECT_EQ(tracked->end, GoalEnd::kSucceeded) << tracked->reason << peer_.Output();
  ExpectTornDown();
}

TEST_F(RouteProcess, FailsItsSelfCheckWithoutOdometry) {
  file_.replace(file_.find("15000"), 5, "100");
  Start(file_);
  EXPECT_THAT(Failure(kSelfCheck), HasSubstr("jetbot_0: no odometry on jetbot_0/odom"));
}

}  // namespace musher::navigation::route_process_test
