#pragma once
// The map of the ground for the skills, subscribed to while a skill asks for it: a large one is
// some megabytes, and planner and controller have it anyway.
//
// Frames: that of the map, for a grid of another frame by /tf. Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/messages/nav_msgs/occupancy_grid.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"

namespace musher::skills {

class MapFeed {
 public:
  static constexpr Duration kAwaited = std::chrono::seconds(2);  // after the first call
  static constexpr Duration kKept = std::chrono::seconds(5);     // after the last one

  // Where a frame is in the map. Fails with the reason.
  using PlaceInMap = std::function<Result<navigation::Pose>(const std::string& frame)>;

  // Node and clock must outlive it. `topic`: empty, there is none.
  MapFeed(transport::Node& node, transport::Clock& clock, std::string topic,
          PlaceInMap place_in_map);

  GroundMap Ask();
  // Each step.
  void Update();

 private:
  void OnGrid(const msg::OccupancyGrid& grid);

  transport::Node& node_;
  transport::Clock& clock_;
  const std::string topic_;
  const PlaceInMap place_in_map_;
  std::unique_ptr<transport::Subscription> subscription_;
  Time subscribed_{};
  Time asked_{};
  std::shared_ptr<const navigation::CellMap> cells_;
  std::shared_ptr<const navigation::CellMap> known_;  // the same; unknown cells are not free
};

}  // namespace musher::skills
