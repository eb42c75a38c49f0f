#pragma once
// The tasks of a TreeRobot (tree_robot.hpp) that are whole missions, and the check of places.
//
// Threads: the loop of the actuator.

#include <memory>
#include <string>

#include "musher/modules/skills/nav2/tree_robot.hpp"

namespace musher::skills {

// To each of the places, one after the other, each by a run of navigate_to.
std::unique_ptr<tree::nav2::Task> MakeNavigation(Robot& robot, Handover& handover,
                                                 const tree::nav2::Goals& places);
// A run of track; it succeeds after `limit`, 0: never.
std::unique_ptr<tree::nav2::Task> MakeFollowing(Robot& robot, Handover& handover,
                                                const std::string& topic, Duration limit);
std::unique_ptr<tree::nav2::Task> MakeTeleoperation(Robot& robot, Handover& handover,
                                                    Duration limit);
std::unique_ptr<tree::nav2::Task> MakePlaceCheck(Robot& robot,
                                                 const tree::nav2::OccupancyRequest& request);

}  // namespace musher::skills
