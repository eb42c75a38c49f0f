#pragma once
// An actuator with the skills `wait` and `fail`, and a fixture whose client sends it goals.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "musher/application/skill_actuator.hpp"
#include "musher/behavior/skill/wait.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/application/show.hpp"
#include "musher/transport/action.hpp"

namespace musher::testing {

// Throws at its end.
class Grip : public skill::Skill {
 public:
  void Declare(skill::Table& table) override {
    table.To(table.State("GRIPPING"), skill::kSucceeded, "");
  }
  skill::Next Step(skill::Tick& /*tick*/) override { return skill::Next::Stay(); }
  void OnEnd(const skill::Ended& /*ended*/) override {
    throw std::runtime_error("the hand does not reply");
  }
};

// Has the name that the harness has a config for.
class SkillTasks : public SkillActuator, public Inspected<SkillTasks> {
 public:
  explicit SkillTasks(const Options& options = {.rate_hz = 50}) : SkillActuator("show", options) {}

  std::string StateOf(const std::string& skill) {
    return Of([&](SkillTasks& tasks) { return tasks.manager().StateOf(skill).value_or("?"); });
  }

  std::string throws;  // the exception of BeforeTick; by RunOnLoop()
  std::function<void()> after_step;
  bool registers = true;
  int pauses = 0;
  bool throws_when_paused = false;
  bool grips = false;  // has the skill `grip`

  using SkillActuator::CheckMayStart;
  using SkillActuator::manager;
  using SkillActuator::Now;
  using SkillActuator::ticking;

 private:
  Result<> RegisterSkills(skill::Registry& registry) override {
    if (!registers) return Ok();
    const auto fails = [] {
      return std::make_unique<skill::StepFunction>(
          [](skill::Table& table) { table.To(table.State("TRYING"), skill::kSucceeded, ""); },
          [](skill::Tick&) { return skill::Next::Fail("no path"); });
    };
    if (Result<> added = registry.Add("fail", fails); !added) return added;
    const auto grip = [] { return std::make_unique<Grip>(); };
    if (Result<> added = grips ? registry.Add("grip", grip) : Ok(); !added) return added;
    return registry.Add("wait", skill::Wait());
  }
  void BeforeTick(Time /*now*/) override {
    if (!throws.empty()) throw std::runtime_error(throws);
  }
  void AfterTick(Time /*now*/) override {
    if (after_step) after_step();
  }
  void OnPause() override {
    ++pauses;
    if (throws_when_paused) throw std::runtime_error("stuck");
  }
};

struct SentSkill {
  transport::GoalId id{};
  bool accepted = false;
  std::vector<std::string> feedback;
  std::optional<transport::GoalOutcome<msg::SkillExecution>> outcome;
};

class SkillActuatorTest : public ::testing::Test {
 protected:
  ~SkillActuatorTest() override {
    harness_.node().RunOnLoop([this] { client_.reset(); });
  }

  template <class Application>
  void Begin(Application& tasks, std::shared_ptr<transport::NodeThread> node = nullptr) {
    harness_.Open(tasks, std::move(node));
    ASSERT_TRUE(Go("SelfCheck"));
    ASSERT_TRUE(Go("Active"));
    harness_.node().RunOnLoop([this] {
      client_ = transport::MakeActionClient<msg::SkillExecution>(harness_.node().node(),
                                                                 "skill_execution")
                    .value();
    });
  }
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }

  std::shared_ptr<SentSkill> Send(
      const std::string& skill,
      const std::vector<std::pair<std::string, std::string>>& parameters = {}) {
    msg::SkillExecution::Goal goal;
    goal.skill_request.skill_list.resize(1);
    goal.skill_request.skill_list[0].skill = skill;
    for (const auto& [key, value] : parameters) {
      goal.skill_request.skill_list[0].params.push_back({key, value});
    }
    return SendGoal(goal);
  }
  std::shared_ptr<SentSkill> SendGoal(const msg::SkillExecution::Goal& goal) {
    auto sent = std::make_shared<SentSkill>();
    transport::GoalEvents<msg::SkillExecution> events;
    events.on_accepted = [sent] { sent->accepted = true; };
    events.on_feedback = [sent](const auto& feedback) {
      sent->feedback.push_back(feedback.status);
    };
    events.on_end = [sent](const auto& outcome) { sent->outcome = outcome; };
    harness_.node().RunOnLoop(
        [&] { sent->id = client_->SendGoal(goal, std::chrono::seconds(120), events); });
    return sent;
  }
  // Until `condition` holds on the client's loop.
  template <class Condition>
  void Await(Condition condition) {
    ASSERT_TRUE(testing::Until([&] {
      bool met = false;
      harness_.node().RunOnLoop([&] { met = condition(); });
      return met;
    }));
  }
  void AwaitAccepted(const std::shared_ptr<SentSkill>& sent) {
    Await([&] { return sent->accepted && !sent->feedback.empty(); });
  }
  // "succeeded true completed: Waited (100%)"
  std::string EndOf(const std::shared_ptr<SentSkill>& sent) {
    Await([&] { return sent->outcome.has_value(); });
    const std::map<transport::GoalEnd, std::string> ends{
        {transport::GoalEnd::kSucceeded, "succeeded"},
        {transport::GoalEnd::kCanceled, "canceled"},
        {transport::GoalEnd::kAborted, "aborted"}};
    if (!sent->outcome) return "none";
    const auto end = ends.find(sent->outcome->end);
    return (end == ends.end() ? "lost" : end->second) +
           (sent->outcome->result.success ? " true " : " false ") + sent->outcome->result.message;
  }

  Harness harness_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> client_;
};

}  // namespace musher::testing
