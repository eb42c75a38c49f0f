#pragma once
// The actuator `meilin`: a match as a behaviour tree. It ticks the tree while the robot is Active
// (application/tree_actuator.hpp), once it was commanded to begin, and halts it, with every goal,
// in every other state and at an emergency stop. How far the match has come is in the machine's
// state_dir, <actuator>_progress.toml: another process goes on with it on command
// (mission.hpp).
//
// Interfaces, relative to the machine's namespace; names in mission.toml:
//   mf_action_seq       in   std_msgs/Float32MultiArray, latched: a plan. In a match that was begun
//                            one that may be late is refused (plan_topic.hpp, CheckNotLate())
//   get_action_seq      client of r2_interfaces/GetActionSeq, twice a second while there is nothing
//                       to do, with plan_service = true; a plan that it hands out again is not
//                       taken again until it has said that it has none
//   planning/segments   in   std_msgs/String, latched: a plan of the old form, JSON; refused where
//                            the tree has no PopNextSegment
//   mf_r2_data          in   std_msgs/String, latched: the boxes of the field, for plans
//   start_autonomy      served, r2_interfaces/StartAutonomy: the match begins
//   transformed/pose, r0x0201, current_state, r1_ready, arm_runtime_state   in
//   meilin/command      in   std_msgs/String: "RESET"
//   meilin/status       out  std_msgs/String, latched: all of the state in one message, JSON
//   meilin/last_error, meilin/plan_id, meilin/state   out  std_msgs/String, latched, in this order
//                            at each change
//   move_to_pose, suspension_control, arm_action, spear_action   clients of the actions
//
// Threads: the loop's, see TreeActuator.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/application/tree_actuator.hpp"
#include "musher/messages/r2_interfaces/get_action_seq.hpp"
#include "musher/messages/r2_interfaces/start_autonomy.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/meilin/mission/mission.hpp"
#include "musher/modules/meilin/mission/mission_config.hpp"
#include "musher/modules/meilin/mission/progress_file.hpp"
#include "musher/modules/meilin/mission/ros_robot.hpp"

namespace musher::meilin {

class MeilinActuator : public TreeActuator {
 public:
  MeilinActuator(const std::string& name, MissionConfig config, MatchConfig match);

 private:
  // A topic that is published when its text changes.
  struct Status {
    std::function<void(const msg::String&)> publish;
    std::string last;
    bool sent = false;
    void Set(const std::string& text);
  };

  Result<> RegisterNodes(tree::Factory& factory) override;
  Result<tree::Document> LoadTree() override;
  Result<> FillBlackboard(tree::Board& board) override { return mission_.Fill(board); }
  void OpenTopics(transport::Endpoints& topics) override;
  Result<> SelfCheck() override;
  void BeforeTick(Time now) override;
  void AfterTick(Time now, tree::Status status) override;
  void OnPause() override;
  void OnResume() override;
  void OnBreak() override;

  Result<> OnStartCommand() override;

  void OnDebuggerLost();
  Result<> MayBegin() const;
  void LogStart(const Result<std::string>& begun);
  void OnMap(const std::string& text);
  std::string WhyLate(const std::string& late) const;
  bool RefusesLate(const msg::Float32MultiArray& plan, const std::string& late);
  void OnPlan(const msg::Float32MultiArray& plan, std::int64_t written_ns, const std::string& late);
  void OnHandedOut(const msg::Float32MultiArray& plan, const std::string& late);
  void OnSegments(const std::string& text, std::int64_t written_ns, const std::string& late);
  void LogPlan(bool accepted);
  void SubscribePlans(transport::Endpoints& topics);
  void OnCommand(const std::string& command);
  void RequestPlan(Time now);
  void Follow();
  void Publish();
  std::string StatusText();
  void LoadProgress();
  void SaveProgress();

  const MissionConfig config_;
  RosRobot robot_;
  Mission mission_;
  transport::Client<msg::GetActionSeq>* plans_ = nullptr;
  Time asked_{};
  bool asking_ = false;
  std::optional<Time> unanswered_since_;
  std::int64_t handed_out_again_ = 0;  // the number of the plan, so that it is logged once
  ProgressFile progress_{[this](const std::string& text) { Log(LogLevel::kWarning, text); }};
  std::string saved_;  // its text
  std::vector<std::string> can_start_;
  Time can_start_at_{};
  std::string can_start_state_;
  Status status_;
  Status state_;
  Status error_;
  Status plan_id_;
};

}  // namespace musher::meilin
