#pragma once
// The execution of a plan: its steps in their order, all robots of a step together. Pure: events
// and the time are arguments, actions are results.
//
//   for each step:  WAITING ──all servers are available──→ RUNNING ──all succeeded──→ next step
//                      │ 3 s without one                      │ a failure, or Cancel()
//                      │ or Cancel()                          ▼
//                      │                                  CANCELLING ──all have ended, or 10 s──┐
//                      └──────────────────────────────────────────────────────────────────────→ end
//
// No goal of a step is sent before all of its robots can be reached. The first failure counts:
// "Execution failed in timestep 2. jetbot_0 navigate_to: failed: no path (15%)".
//
// Times are those of the loop. Threads: one at a time.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/messages/plan_msgs/plan.hpp"

namespace musher::skills {

struct PlanRules {
  Duration server_wait = std::chrono::seconds(3);    // for all servers of a step
  Duration cancel_limit = std::chrono::seconds(10);  // until all goals of a step have ended
};

enum class PlanOutcome : std::uint8_t { kSucceeded, kCanceled, kAborted };

struct PlanEnd {
  PlanOutcome outcome = PlanOutcome::kAborted;
  std::string message;

  friend bool operator==(const PlanEnd&, const PlanEnd&) = default;
};

// What the caller does; indices of the robots of the present step.
struct PlanActions {
  std::vector<std::size_t> send;    // the goal of the robot
  std::vector<std::size_t> cancel;  // a goal that was sent
  bool feedback = false;            // is to be published
  std::optional<PlanEnd> end;       // nothing follows
};

class PlanRun {
 public:
  // A plan that CheckPlan() accepts.
  PlanRun(msg::SkillPlan plan, const PlanRules& rules, Time now);

  // At the begin, after each event and at least ten times a second. `available`: whether the action
  // server of a robot can be reached.
  PlanActions Advance(Time now, const std::function<bool(const std::string& robot)>& available);

  // Events of the goals of the present step. They only change the state; Advance() decides.
  void OnSent(std::size_t robot, std::string goal_id);
  void OnFeedback(std::size_t robot, std::string status);
  void OnEnd(std::size_t robot, bool success, std::string message);
  // Ends all goals of the step; nothing more is started. `by_client`: ends as canceled, else as
  // aborted. Only the first call counts.
  void Cancel(const std::string& why, bool by_client);

  // The step that is executed, from 0.
  std::size_t step() const { return step_; }
  const msg::TimestepSkills& present() const { return plan_.steps[step_]; }
  msg::PlanExecution::Feedback Feedback() const;

 private:
  struct Member {
    std::string goal_id;
    std::string status = "waiting for its server";
    bool sent = false;
    bool cancelled = false;
    bool ended = false;
  };

  void BeginStep(Time now);
  void Fail(const std::string& why);
  bool AllEnded() const;
  std::string NameOf(std::size_t robot) const;  // "jetbot_0 navigate_to"
  PlanActions SendAll();
  PlanActions CancelRest(Time now);

  const msg::SkillPlan plan_;
  const PlanRules rules_;
  std::size_t step_ = 0;
  Time step_begun_;
  bool running_ = false;  // the goals of the step are sent
  std::vector<Member> members_;
  std::string why_cancelled_;      // for the other robots of the step
  std::optional<PlanEnd> ending_;  // a failure or a cancellation: the end, when all have ended
  std::optional<Time> cancelling_since_;
  bool changed_ = true;  // since the last feedback
};

}  // namespace musher::skills
