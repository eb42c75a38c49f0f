#pragma once
// An actuator that offers skills, as the network sees it: what `musher skill` uses of one.
//
//   rise     feedback, then success
//   fail     feedback, then failure
//   refuse   is not started
//   wait     runs until it is cancelled, or until Finish(); it can be paused
//   deaf     the same, and rejects every cancellation and every pause

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/cli/commands/skill/skill_goal.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::cli {

// Latches the status of an actuator of that machine, of another host.
inline void PublishStatusOf(transport::Endpoints& endpoints, const std::string& actuator,
                            const MachineIdentity& machine) {
  msg::ActuatorStatus status;
  status.name = actuator;
  status.state = "Active";
  status.host = "another boot/1";
  status.machine = machine.name;
  status.machine_id = machine.id;
  endpoints.PublishFunction<msg::ActuatorStatus>(transport::ActuatorStatusTopic(""),
                                                 transport::kLatchedQos)(status);
}

class FakeSkills {
 public:
  using Goal = transport::ServerGoal<msg::SkillExecution>;

  // With a `machine` it publishes the status of an actuator of that machine, of another host.
  explicit FakeSkills(std::string actuator, const std::string& name_space = "",
                      const MachineIdentity& machine = {})
      : actuator_(std::move(actuator)), thread_(transport::NodeThread::Start().value()) {
    thread_->RunOnLoop([&] {
      Open(name_space);
      if (!machine.name.empty()) PublishStatusOf(*endpoints_, actuator_, machine);
    });
  }
  ~FakeSkills() {
    thread_->RunOnLoop([this] {
      endpoints_.reset();
      goal_.reset();
    });
  }
  FakeSkills(const FakeSkills&) = delete;
  FakeSkills& operator=(const FakeSkills&) = delete;

  // Ends the running goal.
  void Finish() {
    thread_->RunOnLoop([this] {
      if (goal_) goal_->Succeed({true, "completed: Waited (100%)"});
      goal_.reset();
    });
  }
  void Publish(msg::SkillFeedback feedback) {
    feedback.actuator = actuator_;
    thread_->RunOnLoop([&] { publish_(feedback); });
  }
  // `wait` or `deaf` runs without a goal, as after a restart.
  void GoOnWithoutGoal(const std::string& skill) {
    thread_->RunOnLoop([&] { without_goal_ = skill; });
  }
  // The last requested parameters: "altitude=2 ".
  std::string requested() {
    std::string requested;
    thread_->RunOnLoop([&] { requested = requested_; });
    return requested;
  }
  int goals() {
    int goals = 0;
    thread_->RunOnLoop([&] { goals = goals_; });
    return goals;
  }

 private:
  void Open(const std::string& name_space) {
    endpoints_ = std::make_unique<transport::Endpoints>(thread_->node(), name_space);
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [this](const Goal& goal) { Start(goal); };
    handlers.may_cancel = [](const Goal& goal) { return SkillOf(goal) != "deaf"; };
    handlers.cancel = [this](Goal goal) {
      goal.Canceled({false, "cancelled: by its client (10%)"});
      goal_.reset();
    };
    endpoints_->ServeAction<msg::SkillExecution>(actuator_ + "/skill_execution", handlers);
    endpoints_->Serve<msg::GetSkill>(
        actuator_ + "/get_skill",
        [this](const auto& request, const auto& reply) { reply(Answer(request)); });
    endpoints_->Serve<msg::PauseSkill>(
        actuator_ + "/pause_skill",
        [this](const auto& request, const auto& reply) { reply(Pause(request)); });
    endpoints_->Serve<msg::CancelSkill>(
        actuator_ + "/cancel_skill",
        [this](const auto& request, const auto& reply) { reply(CancelRun(request)); });
    publish_ = endpoints_->PublishFunction<msg::SkillFeedback>("skill_feedback");
    msg::SkillOffers offers{
        actuator_,
        "/" + (name_space.empty() ? "" : name_space + "/") + actuator_ + "/skill_execution",
        {}};
    offers.skills.push_back({"rise",
                             "rises to an altitude",
                             {"altitude: a number, default 1 (m above the ground)",
                              "text: a text, default (what it says)"}});
    for (const char* name : {"fail", "refuse", "wait", "deaf"}) {
      offers.skills.push_back({name, "", {}});
    }
    endpoints_->PublishFunction<msg::SkillOffers>("skills", transport::kLatchedQos)(offers);
  }

  static std::string SkillOf(const Goal& goal) {
    return goal.goal().skill_request.skill_list.at(0).skill;
  }
  void Start(Goal goal) {
    ++goals_;
    const std::string skill = SkillOf(goal);
    requested_.clear();
    for (const auto& parameter : goal.goal().skill_request.skill_list[0].params) {
      requested_ += parameter.key + "=" + parameter.value + " ";
    }
    if (skill == "refuse") {
      goal.Abort({false, "refuse is running already"});
      return;
    }
    goal.Execute();
    goal.PublishFeedback({"processing: Skill " + skill + " started (10%)"});
    if (skill == "rise") goal.Succeed({true, "completed: Reached altitude (100%)"});
    if (skill == "fail") goal.Abort({false, "failed: no path (40%)"});
    if (skill == "wait" || skill == "deaf") goal_ = goal;
  }
  msg::GetSkill::Response Answer(const msg::GetSkill::Request& request) const {
    msg::GetSkill::Response answer;
    answer.stepping = true;
    answer.feedback.skill = request.skill;
    answer.feedback.state = "IDLE";
    if (goal_ && SkillOf(*goal_) == request.skill) {
      answer.feedback.state = "WAITING";
      answer.feedback.progress = 10;
      answer.feedback.goal_id = GoalIdText(goal_->id());
    }
    if (request.skill == without_goal_) answer.feedback.state = "WAITING";
    if (!request.format.empty()) answer.graph = request.format + " of " + request.skill + "\n";
    return answer;
  }

  msg::PauseSkill::Response Pause(const msg::PauseSkill::Request& request) {
    msg::PauseSkill::Response answer;
    answer.success = request.skill == "wait" && request.pause != paused_;
    answer.message = request.skill == "deaf"    ? "deaf cannot be paused: it does not listen"
                     : request.pause != paused_ ? "WAITING"
                     : request.pause            ? "wait is paused already"
                                                : "wait is not paused by a request";
    if (answer.success) paused_ = request.pause;
    return answer;
  }

  msg::CancelSkill::Response CancelRun(const msg::CancelSkill::Request& request) {
    msg::CancelSkill::Response answer;
    answer.success = request.skill == "wait" && request.skill == without_goal_;
    answer.message = answer.success ? "cancelled: by " + request.by + " (10%)"
                                    : "failed: it listens to no cancellation (10%)";
    without_goal_.clear();
    return answer;
  }

  const std::string actuator_;
  bool paused_ = false;
  std::string without_goal_;  // the skill that runs so; empty: none
  std::shared_ptr<transport::NodeThread> thread_;
  std::optional<Goal> goal_;  // that runs
  std::string requested_;
  int goals_ = 0;
  std::function<void(const msg::SkillFeedback&)> publish_;
  std::unique_ptr<transport::Endpoints> endpoints_;
};

}  // namespace musher::cli
