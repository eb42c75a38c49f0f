#pragma once
// A round body that is driven from a start to a goal by planner, trajectory and follower, 60 times
// a second of simulated time, among discs that move. Its velocity follows the command with a lag.
// Its scanner sees walls and discs 10 times a second. Deterministic.

#include <functional>
#include <string>
#include <vector>

#include "musher/navigation/controller/follower.hpp"
#include "musher/navigation/planner/planner.hpp"

namespace musher::navigation::testing {

// Goes to and fro on a line.
struct Mover {
  Point from;
  Point to;
  double radius_m = 0.25;
  double speed_m_s = 0.4;
  double at_m = 0;  // on the line
  bool back = false;
  bool yields = true;  // it stands right before the body, and turns back after 5 s
  double stood_s = 0;

  Point At() const;
};

struct DriveOptions {
  double body_radius_m = 0.25;
  double lag_s = 0.2;  // of the body
  PlannerRules planner;
  TrajectoryRules trajectory;
  FollowerRules follower;
  std::vector<Mover> movers;
  double longest_s = 300;
  // Called in each step, for example to push the body.
  std::function<void(double at_s, Pose& pose)> disturb;

  DriveOptions();
};

struct DriveResult {
  enum class End { kArrived, kRefused, kFailed } end = End::kFailed;
  std::string reason;  // why it was refused or failed
  double seconds = 0;
  Pose pose;                  // at the end
  double tracking_rms_m = 0;  // distance to the reference
  double tracking_most_m = 0;
  double highest_m_s = 0;
  double least_room_m = 0;  // to the walls, from the body's edge, up to 1 m
  int replans = 0;
  int hits_of_body = 0;    // contacts with a mover that the body drives towards
  int hits_of_movers = 0;  // others: the mover has come to the body
  double waited_s = 0;
};

DriveResult Drive(const CellMap& map, const Pose& start, const Pose& goal,
                  const DriveOptions& options);

}  // namespace musher::navigation::testing
