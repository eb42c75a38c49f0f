#pragma once
// The planner and the controller of a robot: its requests of paths and its drives, as goals of
// their actions.
//
//   request  sent ──→ path or reason.        Its goal is cancelled when its future is dropped.
//   drive    sent ──→ arrived, cancelled or failed.   Cancel() is repeated until it has ended. One
//                     whose controller was lost has failed, and is cancelled once that replies.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "musher/messages/nav2_msgs/compute_path_to_pose.hpp"
#include "musher/messages/nav2_msgs/follow_path.hpp"
#include "musher/modules/skills/robot/conversions.hpp"
#include "musher/modules/skills/robot/robot.hpp"
#include "musher/transport/action.hpp"

namespace musher::skills {

class Navigator {
 public:
  using Planner = transport::ActionClient<msg::ComputePathToPose>;
  using Controller = transport::ActionClient<msg::FollowPath>;

  // Both must outlive it; null: there is none. `stamp`: of the messages. `in_map` places the
  // planner's paths.
  Navigator(Planner* planner, Controller* controller, std::function<msg::Stamp()> stamp,
            PlaceOfFrame in_map);

  ~Navigator();  // cancels nothing, see CancelAll(); its drives fail
  Navigator(const Navigator&) = delete;
  Navigator& operator=(const Navigator&) = delete;

  bool HasPlanner() const { return planner_ != nullptr && planner_->Ready(); }
  // Whether a drive has not ended.
  bool Drives() const;
  bool HasController() const { return controller_ != nullptr && controller_->Ready(); }

  skill::Future<navigation::Path> ComputePath(const navigation::Pose& goal,
                                              const std::optional<navigation::Pose>& start);
  std::unique_ptr<Drive> FollowPath(const navigation::Path& path);

  // At each step: cancels what is not wanted any more, and repeats cancellations.
  void Update();
  // Cancels all requests and drives.
  void CancelAll();
  // Cancels the drives that the controller has accepted until now, by its clock: also those that a
  // process before this one has left behind. Repeated until the controller has replied; later
  // drives are not cancelled. Where the clocks of two hosts differ, it is wrong by so much.
  void CancelEarlierDrives();

 private:
  struct Request;
  struct EarlierDrives;
  struct DriveGoal;
  class GoalDrive;

  void CancelRequest(const std::shared_ptr<Request>& request);
  void CancelGoal(const std::shared_ptr<DriveGoal>& goal);
  void RequestCancelOfEarlier();

  Planner* const planner_;
  Controller* const controller_;
  const std::function<msg::Stamp()> stamp_;
  const PlaceOfFrame in_map_;
  const std::shared_ptr<EarlierDrives> earlier_;
  std::vector<std::shared_ptr<Request>> requests_;  // not ended
  std::vector<std::shared_ptr<DriveGoal>> drives_;  // not ended, or lost and not cancelled yet
};

}  // namespace musher::skills
