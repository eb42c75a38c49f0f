// What a goal of an action costs beside two plain request-replies, which is what it consists of at
// least (goal and result): on Cyclone DDS, client and server on a thread each, in turns. And what a
// step of the engine costs for running skills.
//
//   benchmark_skill [GOALS [STEPS]]    (2000, 100000)

#include <cstdlib>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "musher/behavior/skill/manager.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/dds/node_thread.hpp"
#include "musher/transport/service.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;
using Goal = transport::ServerGoal<msg::SkillExecution>;

constexpr Duration kTimeout = std::chrono::seconds(10);

std::shared_ptr<transport::NodeThread> StartNode() {
  auto node = transport::NodeThread::Start();
  if (!node) Fail(node.error().message);
  return node.value();
}

class Wire {
 public:
  Wire() : server_(StartNode()), client_(StartNode()) {
    server_->RunOnLoop([this] {
      transport::ActionHandlers<msg::SkillExecution> handlers;
      handlers.start = [](Goal goal) { goal.Succeed({true, "completed"}); };
      action_server_ = transport::MakeActionServer<msg::SkillExecution>(server_->node(), "work",
                                                                        std::move(handlers))
                           .value();
      transport::Server<msg::SetBool>::Handler answer = [](const auto&, const auto& reply) {
        reply({});
      };
      service_server_ =
          transport::MakeServer<msg::SetBool>(server_->node(), "flag", std::move(answer)).value();
    });
    client_->RunOnLoop([this] {
      action_ = transport::MakeActionClient<msg::SkillExecution>(client_->node(), "work").value();
      service_ = transport::MakeClient<msg::SetBool>(client_->node(), "flag").value();
    });
  }
  ~Wire() {
    client_->RunOnLoop([this] { action_.reset(), service_.reset(); });
    server_->RunOnLoop([this] { action_server_.reset(), service_server_.reset(); });
  }
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  void RunGoal() {
    std::promise<bool> ended;
    client_->RunOnLoop([&] {
      transport::GoalEvents<msg::SkillExecution> events;
      events.on_end = [&ended](const auto& outcome) {
        ended.set_value(outcome.end == transport::GoalEnd::kSucceeded);
      };
      action_->SendGoal({}, kTimeout, std::move(events));
    });
    if (!ended.get_future().get()) Fail("a goal has not succeeded");
  }
  void CallTwice() {
    for (int i = 0; i < 2; ++i) {
      std::promise<bool> ended;
      client_->RunOnLoop([&] {
        service_->Call({}, kTimeout, [&ended](const auto& reply) { ended.set_value(reply.ok()); });
      });
      if (!ended.get_future().get()) Fail("a call has not been answered");
    }
  }

 private:
  std::shared_ptr<transport::NodeThread> server_;
  std::shared_ptr<transport::NodeThread> client_;
  std::unique_ptr<transport::ActionServer<msg::SkillExecution>> action_server_;
  std::unique_ptr<transport::Server<msg::SetBool>> service_server_;
  std::unique_ptr<transport::ActionClient<msg::SkillExecution>> action_;
  std::unique_ptr<transport::Client<msg::SetBool>> service_;
};

double Time(const std::function<void()>& call) {
  const auto begin = Clock::now();
  call();
  return Microseconds(Clock::now() - begin);
}

void MeasureGoals(int goals) {
  Wire wire;
  for (int i = 0; i < 100; ++i) wire.RunGoal(), wire.CallTwice();  // warm
  std::vector<double> of_goals, of_calls;
  for (int i = 0; i < goals; ++i) {
    of_goals.push_back(Time([&] { wire.RunGoal(); }));
    of_calls.push_back(Time([&] { wire.CallTwice(); }));
  }
  const Table table("A goal beside two calls of a service");
  table.Row("two plain request-replies", of_calls, "µs");
  table.Row("a goal: accepted, executed, result", of_goals, "µs");
  table.Row("ratio", Ratios(of_goals, of_calls), "×");
}

// Reports as a skill does that moves.
std::unique_ptr<skill::Skill> Moving() {
  return std::make_unique<skill::StepFunction>(
      [](skill::Table& table) {
        table.To(table.State("EXECUTING"), skill::kSucceeded, "never here");
        table.Limit({.run = skill::kNoLimit});
      },
      [](skill::Tick& tick) {
        tick.Report(50, "Moving");
        tick.Detail("distance_to_goal", 1.5);
        return skill::Next::Stay();
      });
}

void MeasureSteps(int steps) {
  constexpr int kTurns = 30;
  const Table table("A step of the engine");
  for (const int running : {1, 10}) {
    skill::Registry registry;
    for (int i = 0; i < running; ++i) {
      if (!registry.Add("move_" + std::to_string(i), Moving)) Fail("a skill is not registered");
    }
    skill::Manager manager(registry.All());
    for (const std::string& name : manager.Names()) {
      if (!manager.Start(name)) Fail(name + " does not start");
    }
    musher::Time now{};
    std::vector<double> times;
    for (int turn = 0; turn < kTurns; ++turn) {
      const double us = Time([&] {
        for (int i = 0; i < steps / kTurns; ++i) manager.RunOnce(now += Milliseconds(100));
      });
      times.push_back(us * 1000 / (steps / kTurns) / running);
    }
    if (!manager.running()) Fail("the skills have ended");
    table.Row(std::to_string(running) + " running: a skill", times, "ns");
  }
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  using namespace musher::benchmark;
  setenv("ROS_DOMAIN_ID", std::to_string(Domain()).c_str(), 1);
  MeasureGoals(argc > 1 ? std::atoi(argv[1]) : 2000);
  MeasureSteps(argc > 2 ? std::atoi(argv[2]) : 100'000);
}
