#pragma once
// The action `plan_execution` (plan_msgs/PlanExecution): executes one plan at a time by the action
// `<robot>/skill_execution` of each robot.
//
// A goal is aborted at once, with the reason in its result: an invalid plan, a plan while another
// one is executed, a machine that is not Active, and one that may have waited while this process
// could not run (base/break_watch.hpp). A plan ends after a break of more than a minute: its robots
// may have finished their step long ago, and do not see that the next one is late. When it is
// destroyed it cancels the goals of the present step. Those of a process that was killed are in a
// file (saved_goals.hpp): Open() of the next one cancels them. One for whose robot no client can be
// made stays in the file, and is tried again each second for a minute, then with each plan.
//
// Threads: the loop's.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "musher/base/log.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/modules/skills/plan/dispatcher_config.hpp"
#include "musher/modules/skills/plan/plan_run.hpp"
#include "musher/modules/skills/plan/saved_goals.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher::skills {

class PlanServer {
 public:
  using LogLine = std::function<void(LogLevel level, const std::string& line)>;

  // The node must outlive it. `actuator`: its name, for people. `goals_file`: for saved_goals.hpp;
  // empty: none.
  PlanServer(transport::Node& node, std::string actuator, std::string name_space,
             DispatcherConfig config, LogLine log, std::string goals_file = "")
      : node_(node),
        actuator_(std::move(actuator)),
        name_space_(std::move(name_space)),
        config_(std::move(config)),
        log_(std::move(log)),
        saved_(std::move(goals_file)),
        breaks_(node.loop()) {}
  ~PlanServer();
  PlanServer(const PlanServer&) = delete;
  PlanServer& operator=(const PlanServer&) = delete;

  // Serves the action, for as long as these endpoints exist; it must be destroyed before them.
  // Cancels what the process before has left to its robots.
  void Open(transport::Endpoints& endpoints);
  // Whether plans are executed. False cancels the present one; `why` is for people.
  void Permit(bool permitted, const std::string& why);

 private:
  using Goal = transport::ServerGoal<msg::PlanExecution>;
  using Client = transport::ActionClient<msg::SkillExecution>;
  // A plan that is executed.
  struct Execution {
    Goal goal;
    PlanRun run;
    std::map<std::size_t, transport::GoalId> sent;  // open ones of the present step, by robot
    std::set<std::size_t> cancelled;                // the same
  };

  void Start(const Goal& goal);
  Result<> Admit(const msg::SkillPlan& plan);
  Result<> MakeClient(const std::string& robot);
  Result<> CheckNotLate();
  void CancelAfterBreak();
  void Advance();
  void SendAll(const std::vector<std::size_t>& robots);
  void Send(std::size_t robot);
  void CancelGoal(std::size_t robot);
  // Also after the end of its plan: a robot that was out of reach may go on with it.
  void CancelUntilReply(const std::string& robot, const transport::GoalId& id);
  void CancelGoalsOfProcessBefore();
  // Those for which a client can be made.
  void CancelLeftGoals();
  void SaveGoals();
  // Each second while it has to: goals are left, or not saved.
  void TryAgain();
  void TryAgainLater();
  void LogGivenUp() const;
  void End(const PlanEnd& end);
  // The events of a goal that was sent, as long as its step is executed.
  transport::GoalEvents<msg::SkillExecution> EventsOf(std::size_t robot);

  transport::Node& node_;
  const std::string actuator_;
  const std::string name_space_;
  const DispatcherConfig config_;
  const LogLine log_;
  SavedGoals saved_;
  transport::LoopBreaks breaks_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::map<std::string, std::unique_ptr<Client>> clients_;  // by robot
  SavedGoals::Goals cancelling_;                            // without a reply
  SavedGoals::Goals left_;  // by the process before; without a client that could cancel them
  int attempts_ = 0;        // to make these clients
  std::string no_client_;   // why the last one could not be made
  transport::LoopHandlePtr try_again_;
  std::shared_ptr<Execution> execution_;  // null: no plan is executed
  transport::LoopHandlePtr ticks_;        // during an execution
};

}  // namespace musher::skills
