#pragma once
// Both servers of the navigation chain for one robot on a simulated network, with its peers, in
// virtual time.

#include <gmock/gmock.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/trajectory_msgs/joint_trajectory.hpp"
#include "musher/modules/navigation/controller_server/controller_server.hpp"
#include "musher/modules/navigation/planner_server/planner_server.hpp"
#include "musher/test/modules/navigation/loop_background.hpp"
#include "musher/test/modules/navigation/simulated_robot.hpp"
#include "musher/test/navigation/maps.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::navigation::testing {

// Two rooms of 4 m with a door of 1.2 m between them.
inline CellMap TwoRooms() {
  return Drawn({"####################", "#........#.........#", "#........#.........#",
                "#........#.........#", "#..................#", "#..................#",
                "#..................#", "#........#.........#", "#........#.........#",
                "#........#.........#", "####################"},
               0.4, 4);
}

// The ends of the goals that a client has sent to one server.
template <msg::Action A>
class Goals {
 public:
  using Outcome = transport::GoalOutcome<A>;

  Goals(transport::Node& node, const std::string& action)
      : client_(std::move(transport::MakeActionClient<A>(node, action)).value()) {}

  // The index of the goal in `ends`.
  std::size_t Send(const typename A::Goal& goal) {
    const std::size_t index = ends.size();
    ends.emplace_back();
    transport::GoalEvents<A> events;
    events.on_end = [this, index](const Outcome& outcome) { ends[index] = outcome; };
    events.on_feedback = [this](const typename A::Feedback& value) { feedback.push_back(value); };
    ids.push_back(client_->SendGoal(goal, Milliseconds(2000), std::move(events)));
    return index;
  }
  void Cancel(std::size_t index) {
    client_->Cancel(ids[index], Milliseconds(1000), [](const auto&) {});
  }

  std::vector<std::optional<Outcome>> ends;
  std::vector<transport::GoalId> ids;
  std::vector<typename A::Feedback> feedback;

 private:
  std::unique_ptr<transport::ActionClient<A>> client_;
};

// A mask over the map, as nav2's costmap filters have it, with one square of a value.
class MaskPeer {
 public:
  MaskPeer(transport::Node& node, const std::string& topic)
      : info_(transport::MakePublisher<msg::CostmapFilterInfo>(node, topic, transport::kLatchedQos)
                  .value()),
        grid_(transport::MakePublisher<msg::OccupancyGrid>(node, topic + "_mask",
                                                           transport::kLatchedQos)
                  .value()),
        topic_(topic) {}

  // Cells of 0.5 m from (0, 0) on; those from x to x + side, and so for y, have this occupancy.
  void Publish(std::uint8_t type, const Point& from, double side_m, std::int8_t occupancy) {
    msg::CostmapFilterInfo info;
    info.type = type;
    info.filter_mask_topic = topic_ + "_mask";
    info.multiplier = 1;
    msg::OccupancyGrid grid;
    grid.header.frame_id = "map";
    grid.info.resolution = 0.5F;
    grid.info.width = 20;
    grid.info.height = 12;
    grid.info.origin = ToMessage(Pose{});
    for (int y = 0; y < 12; ++y) {
      for (int x = 0; x < 20; ++x) {
        const double x_m = 0.5 * x + 0.25 - from.x_m, y_m = 0.5 * y + 0.25 - from.y_m;
        const bool inside = x_m > 0 && y_m > 0 && x_m < side_m && y_m < side_m;
        grid.data.push_back(inside ? occupancy : std::int8_t{0});
      }
    }
    EXPECT_TRUE(info_->Publish(info));
    EXPECT_TRUE(grid_->Publish(grid));
  }

 private:
  std::unique_ptr<transport::Publisher<msg::CostmapFilterInfo>> info_;
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> grid_;
  const std::string topic_;
};

class NavigationRig : public ::testing::Test {
 protected:
  explicit NavigationRig(const SimulatedRobot::Options& options = {"jetbot_0", {{1, 2, 0}, 0}})
      : robot_(*peers_, walls_, options) {
    PlannerRobot planned;
    planned.name = options.name;
    planned.odometry = options.name + "/odom";
    planned.scanners = {{.topic = options.name + "/scan"}};
    planned.action = options.name + "/compute_path_to_pose";
    planned.path = options.name + "/planned_path";
    planned.refuge = options.name + "/compute_refuge";
    planned.clear_memory = options.name + "/clear_planner_memory";
    planner_config_.robots = {planned};
    ControllerRobot driven;
    driven.name = options.name;
    driven.odometry = planned.odometry;
    driven.scanners = planned.scanners;
    driven.action = options.name + "/follow_path";
    driven.trajectory = options.name + "/timed_trajectory";
    driven.command = options.name + "/cmd_vel";
    driven.clear_memory = options.name + "/clear_controller_memory";
    driven.differential = options.differential;
    controller_config_.robots = {driven};
  }

  // After changes of the configs.
  void StartServers(bool with_map = true) {
    planner_ = Must(PlannerServer::Make(
        DependenciesOf(*planner_node_, *planner_clock_), planner_config_, [this] {
          return std::make_unique<LoopBackground>(planner_node_->loop(), planning_takes_);
        }));
    controller_ = Must(ControllerServer::Make(
        DependenciesOf(*controller_node_, *controller_clock_), controller_config_,
        std::make_unique<LoopBackground>(controller_node_->loop(), Milliseconds(5))));
    map_ =
        Must(transport::MakePublisher<msg::OccupancyGrid>(*peers_, "map", transport::kLatchedQos));
    if (with_map) {
      EXPECT_TRUE(map_->Publish(GridOf(walls_.map())));
    }
    Run(1000);  // discovery
    Permit();
  }
  void Permit() {
    planner_->Permit(true, "");
    controller_->Permit(true, "");
  }
  template <class T>
  static T Must(Result<T> result) {
    if (!result) ADD_FAILURE() << result.error().message;
    return std::move(result).value();
  }
  Dependencies DependenciesOf(transport::Node& node, transport::Clock& clock) {
    return {node, clock, "", [this](LogLevel, const std::string& line) { log_.push_back(line); }};
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }

  // Requests a path and waits for the reply.
  transport::GoalOutcome<msg::ComputePathToPose> Plan(const msg::ComputePathToPose::Goal& goal) {
    const std::size_t index = plans_.Send(goal);
    EXPECT_TRUE(RunUntil([&] { return plans_.ends[index].has_value(); }, 10'000));
    return plans_.ends[index].value_or(transport::GoalOutcome<msg::ComputePathToPose>{});
  }
  msg::Path PathTo(double x_m, double y_m, double yaw_rad = 0) {
    const auto outcome = Plan({.goal = At(x_m, y_m, yaw_rad)});
    EXPECT_EQ(outcome.end, transport::GoalEnd::kSucceeded) << log_.back();
    return outcome.result.path;
  }
  std::size_t Follow(const msg::Path& path) { return drives_.Send({.path = path}); }
  bool AwaitEnd(std::size_t drive, std::int64_t ms = 60'000) {
    return RunUntil([&] { return drives_.ends[drive].has_value(); }, ms);
  }
  bool RunUntil(const std::function<bool()>& holds, std::int64_t ms) {
    return network_.RunUntil(holds, network_.now() + Milliseconds(ms));
  }
  // The code with which a drive was aborted.
  int CodeOf(std::size_t drive) const {
    const auto& end = drives_.ends[drive];
    return end && end->end == transport::GoalEnd::kAborted ? end->result.error_code : -1;
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> planner_node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> controller_node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peers_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Clock> planner_clock_ =
      transport::Clock::Steady(planner_node_->loop());
  std::unique_ptr<transport::Clock> controller_clock_ =
      transport::Clock::Steady(controller_node_->loop());
  Clearance walls_{TwoRooms()};
  SimulatedRobot robot_;
  PlannerConfig planner_config_;
  ControllerConfig controller_config_;
  Duration planning_takes_ = Milliseconds(20);
  std::vector<std::string> log_;
  std::unique_ptr<PlannerServer> planner_;
  std::unique_ptr<ControllerServer> controller_;
  std::unique_ptr<transport::Publisher<msg::OccupancyGrid>> map_;
  Goals<msg::ComputePathToPose> plans_{*peers_, "jetbot_0/compute_path_to_pose"};
  Goals<msg::FollowPath> drives_{*peers_, "jetbot_0/follow_path"};
};

}  // namespace musher::navigation::testing
