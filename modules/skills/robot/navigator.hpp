#pragma once
// The planner and the controller of a robot: its requests of paths and its drives, as goals of
// their actions.
//
//   request  sent ──→ path or reason.        Its goal is cancelled when its future is dropped.
//   drive    sent ──→ arrived, cancelled or failed.   Cancel() is repeated until it has ended. One
//                     whose controller was lost has failed, and is cancelled once that replies.
//   earlier drive, of any client   cancelled ──→ a status says that it has ended.
//
// Threads: the loop's.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "musher/messages/action_msgs/goal_status.hpp"
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

  // The loop, planner and controller must outlive it; null: there is none. `stamp`: of the
  // messages. `in_map` places the planner's paths.
  Navigator(transport::EventLoop& loop, Planner* planner, Controller* controller,
            std::function<msg::Stamp()> stamp, PlaceOfFrame in_map);

  ~Navigator();  // cancels nothing, see CancelAll(); its drives fail
  Navigator(const Navigator&) = delete;
  Navigator& operator=(const Navigator&) = delete;

  bool HasPlanner() const { return planner_ != nullptr && planner_->Ready(); }
  // Whether a drive of its own has not ended.
  bool Drives() const;
  // Whether a controller has a drive of any client, by its last status.
  bool ControllerDrives() const;
  bool HasController() const { return controller_ != nullptr && controller_->Ready(); }

  skill::Future<navigation::Path> ComputePath(const navigation::Pose& goal,
                                              const std::optional<navigation::Pose>& start);
  std::unique_ptr<Drive> FollowPath(const navigation::Path& path);

  // At each step: cancels what is not wanted any more, and repeats cancellations.
  void Update();
  // Cancels all requests and drives.
  void CancelAll();
  // Cancels the drives that have begun until now, of every client, also those that a process before
  // this one has left behind. Each is cancelled by its id, and again until a status says that it
  // has ended. No clock is compared: those of two hosts differ, and any clock may be set. Later
  // drives are not cancelled. What a controller drives for another client when it is reached for
  // the first time counts as begun before, if its status comes within 3 s.
  void CancelEarlierDrives();

  // A status of the controller's action, and the loss of its publisher.
  void TakeStatus(const msg::GoalStatusArray& goals, transport::EndpointId controller);
  void ForgetStatus(transport::EndpointId controller) { active_.erase(controller); }

 private:
  struct Request;
  struct DriveGoal;
  using GoalIds = std::set<transport::GoalId>;
  class GoalDrive;

  void CancelRequest(const std::shared_ptr<Request>& request);
  void CancelGoal(const std::shared_ptr<DriveGoal>& goal);
  void CancelEarlier(const GoalIds& active);
  void RequestCancel(const transport::GoalId& id);
  void RepeatCancellations();

  Planner* const planner_;
  Controller* const controller_;
  const std::function<msg::Stamp()> stamp_;
  const PlaceOfFrame in_map_;
  std::vector<std::shared_ptr<Request>> requests_;  // not ended
  std::vector<std::shared_ptr<DriveGoal>> drives_;  // not ended, or lost and not cancelled yet
  // The drives of each controller, by its last status. A controller that starts again after a crash
  // publishes no status before its first goal.
  std::map<transport::EndpointId, GoalIds> active_;
  GoalIds earlier_;             // to be cancelled; no status says yet that they have ended
  int reached_s_ = 0;           // since when a controller can be reached; at most 3
  bool awaits_status_ = false;  // the first one of a controller: its drives are earlier ones
  transport::LoopHandlePtr repeats_;
};

}  // namespace musher::skills
