// Plans for several robots, on a simulated network in virtual time, with fakes of the robots.

#include "musher/modules/skills/plan/plan_server.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "musher/test/support/refusals.hpp"
#include "musher/test/support/temp_folder.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skills::plan_server_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Pair;
using ::testing::SizeIs;
using transport::GoalEnd;
using transport::GoalState;

// The action of a robot, whose goals the test ends.
struct FakeSkills {
  using Goal = transport::ServerGoal<msg::SkillExecution>;

  FakeSkills(transport::Node& node, const std::string& robot) : endpoints(node, "") {
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [this](Goal goal) {
      goal.Execute();
      goals.push_back(goal);
    };
    handlers.cancel = [this](Goal goal) {
      ++cancels;
      goal.Canceled({false, "cancelled: by its client (0%)"});
    };
    endpoints.ServeAction<msg::SkillExecution>(robot + "/skill_execution", std::move(handlers));
  }

  std::vector<Goal> goals;
  int cancels = 0;
  transport::Endpoints endpoints;
};

// A node that makes no writers of a robot's action while it has to fail.
class FailingNode : public musher::testing::WrappedNode {
 public:
  using WrappedNode::WrappedNode;

  Result<std::unique_ptr<transport::RawWriter>> MakeRawWriter(
      const std::string& topic, const std::string& type, const transport::Qos& qos,
      transport::WriterCallbacks callbacks) override {
    if (fails && topic.find("b/skill_execution/") != std::string::npos) {
      ++failures;
      return Error{kCodeFailed, "out of memory"};
    }
    return WrappedNode::MakeRawWriter(topic, type, qos, std::move(callbacks));
  }

  bool fails = true;
  int failures = 0;
};

class APlanServer : public ::testing::Test {
 protected:
  APlanServer() {
    endpoints_ = Serve(*node_);
    client_ = transport::MakeActionClient<msg::PlanExecution>(*desk_, "plan_execution").value();
    Run(500);
  }
  // A dispatcher in this process.
  std::unique_ptr<transport::Endpoints> Serve(transport::Node& node) {
    auto endpoints = std::make_unique<transport::Endpoints>(node, "");
    const auto server = std::make_shared<PlanServer>(
        node, "plan_dispatcher", "", DispatcherConfig{},
        [this](LogLevel, const std::string& line) { log_.push_back(line); }, goals_file_);
    server->Open(*endpoints);
    endpoints->Keep(server);
    server_ = server;
    server->Permit(true, "");
    return endpoints;
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }

  static msg::SkillPlan PlanOf(const std::vector<std::vector<std::string>>& steps) {
    msg::SkillPlan plan;
    for (const auto& robots : steps) {
      msg::TimestepSkills step{static_cast<std::int32_t>(plan.steps.size() + 1), {}};
      for (const std::string& robot : robots) {
        msg::SkillInfo skill;
        skill.skill = "wait";
        step.robots.push_back({robot, {skill}});
      }
      plan.steps.push_back(step);
    }
    return plan;
  }
  struct Sent {
    transport::GoalId id{};
    std::optional<transport::GoalOutcome<msg::PlanExecution>> outcome;
    std::vector<msg::PlanExecution::Feedback> feedback;
  };
  std::shared_ptr<Sent> Send(const msg::SkillPlan& plan) {
    auto sent = std::make_shared<Sent>();
    transport::GoalEvents<msg::PlanExecution> events;
    events.on_feedback = [sent](const auto& feedback) { sent->feedback.push_back(feedback); };
    events.on_end = [sent](const auto& outcome) { sent->outcome = outcome; };
    sent->id = client_->SendGoal({plan}, std::chrono::seconds(3), events);
    Run(1000);
    return sent;
  }
  // A file in the place of the folder.
  void BlockDisk() const { std::ofstream(folder_ / "state") << "full"; }
  void FreeDisk() const { std::filesystem::remove(folder_ / "state"); }
  static std::string EndOf(const Sent& sent) {
    if (!sent.outcome) return "not ended";
    return std::string(transport::GoalEndName(sent.outcome->end)) + ": " +
           sent.outcome->result.message;
  }

  const TempFolder folder_;
  std::vector<std::string> log_;
  const std::string goals_file_ = folder_ / "state/plan_dispatcher_goals.toml";
  transport::sim::Network network_{1};
  std::unique_ptr<musher::testing::SuspendedNode> node_ =
      std::make_unique<musher::testing::SuspendedNode>(network_.MakeNode("robot"));
  std::unique_ptr<transport::Node> a_node_ = network_.MakeNode("a");
  std::unique_ptr<transport::Node> b_node_ = network_.MakeNode("b");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  FakeSkills a_{*a_node_, "a"};
  FakeSkills b_{*b_node_, "b"};
  std::weak_ptr<PlanServer> server_;
  std::unique_ptr<transport::Endpoints> endpoints_;
  std::unique_ptr<transport::ActionClient<msg::PlanExecution>> client_;
};

TEST_F(APlanServer, ExecutesAPlan) {
  const auto sent = Send(PlanOf({{"a", "b"}, {"b"}}));
  ASSERT_THAT(a_.goals, SizeIs(1));
  ASSERT_THAT(b_.goals, SizeIs(1));
  EXPECT_EQ(a_.goals[0].goal().skill_request.robot_id, "a");
  a_.goals[0].PublishFeedback({"processing: Waiting (5%)"});
  Run(100);
  ASSERT_FALSE(sent->feedback.empty());
  EXPECT_EQ(sent->feedback.back().skill_statuses[0].status, "processing: Waiting (5%)");
  EXPECT_THAT(sent->feedback.back().skill_statuses[0].skill_id, SizeIs(32));
  a_.goals[0].Succeed({true, "completed"});
  b_.goals[0].Succeed({true, "completed"});
  Run(200);
  ASSERT_THAT(b_.goals, SizeIs(2));
  EXPECT_EQ(sent->feedback.back().current_timestep, 2);
  b_.goals[1].Succeed({true, "completed"});
  Run(200);
  EXPECT_EQ(EndOf(*sent), "succeeded: All timesteps completed.");
  EXPECT_TRUE(sent->outcome->result.success);
}

TEST_F(APlanServer, CancelsTheOthersWhenARobotFails) {
  const auto sent = Send(PlanOf({{"a", "b"}, {"b"}}));
  a_.goals[0].Abort({false, "failed: no path (15%)"});
  Run(500);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_THAT(b_.goals, SizeIs(1));
  EXPECT_EQ(EndOf(*sent), "aborted: Execution failed in timestep 1. a wait: failed: no path (15%)");
}

TEST_F(APlanServer, NamesARobotThatIsNotThere) {
  const auto sent = Send(PlanOf({{"a", "c"}}));
  Run(3000);
  EXPECT_EQ(EndOf(*sent),
            "aborted: Execution failed in timestep 1. no action server within 3.0 s: c");
  EXPECT_THAT(a_.goals, SizeIs(0));
}

TEST_F(APlanServer, CancelsAllRobotsForItsClient) {
  const auto sent = Send(PlanOf({{"a", "b"}}));
  client_->Cancel(sent->id, std::chrono::seconds(1), [](const auto&) {});
  Run(500);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_EQ(EndOf(*sent), "canceled: Cancelled in timestep 1: by its client");
}

// A robot that loses the first two cancellations.
TEST_F(APlanServer, RepeatsACancellationUntilItIsAnswered) {
  using Action = msg::SkillExecution;
  const std::string name = "d/skill_execution/_action/";
  const auto status = transport::MakePublisher<msg::GoalStatusArray>(*a_node_, name + "status",
                                                                     transport::kLatchedQos);
  const auto feedback =
      transport::MakePublisher<Action::FeedbackMessage>(*a_node_, name + "feedback");
  const auto send_goal = transport::MakeServer<Action::SendGoal>(
      *a_node_, name + "send_goal", [](const auto&, const auto& reply) {
        reply({true, {}});
      });
  std::optional<transport::Server<Action::GetResult>::Reply> result;
  const auto get_result = transport::MakeServer<Action::GetResult>(
      *a_node_, name + "get_result", [&](const auto&, auto reply) { result = std::move(reply); });
  int cancels = 0;
  const auto cancel_goal = transport::MakeServer<msg::CancelGoal>(
      *a_node_, name + "cancel_goal", [&](const auto& request, const auto& reply) {
        if (++cancels < 3) return;
        reply({msg::CancelGoal::kErrorNone, {request.goal_info}});
        (*result)({msg::GoalStatus::kStatusCanceled, {false, "cancelled"}});
      });
  Run(500);
  const auto sent = Send(PlanOf({{"d"}}));
  client_->Cancel(sent->id, std::chrono::seconds(1), [](const auto&) {});
  Run(4000);
  EXPECT_EQ(cancels, 3);
  EXPECT_EQ(EndOf(*sent), "canceled: Cancelled in timestep 1: by its client");
  Run(3000);
  EXPECT_EQ(cancels, 3);
}

TEST_F(APlanServer, CancelsTheSkillOfARobotThatItHasLostOnceThatIsBack) {
  const auto sent = Send(PlanOf({{"a", "b"}}));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Partition("robot", "b");
  Run(60'000);
  EXPECT_THAT(EndOf(*sent), HasSubstr("b wait: "));
  const auto later = Send(PlanOf({{"a"}}));
  network_.Heal("robot", "b");
  Run(5000);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_EQ(EndOf(*later), "not ended");
}

TEST_F(APlanServer, FailsWhenARobotCrashes) {
  const auto sent = Send(PlanOf({{"a", "b"}}));
  network_.Crash(*b_node_);
  Run(30'000);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_THAT(EndOf(*sent), HasSubstr("aborted: Execution failed in timestep 1. b wait: "));
}

TEST_F(APlanServer, RefusesWhatItCannotExecute) {
  EXPECT_EQ(EndOf(*Send({})), "aborted: the plan has no steps");
  EXPECT_EQ(EndOf(*Send(PlanOf({{"a", "a"}}))),
            "aborted: step 1 (timestep 1), a: is in this step twice");
  const auto first = Send(PlanOf({{"a"}}));
  EXPECT_EQ(EndOf(*Send(PlanOf({{"b"}}))), "aborted: another plan is executed");
  EXPECT_THAT(b_.goals, SizeIs(0));
}

// Its client has long gone, and the robots do not see that it waited.
TEST_F(APlanServer, RefusesAPlanThatMayHaveWaitedWhileItsProcessCouldNotRun) {
  node_->loop().suspended += std::chrono::seconds(9);
  const auto late = Send(PlanOf({{"a"}}));
  EXPECT_THAT(EndOf(*late), musher::testing::HasRefusal(ApplicationRefusal::kMayBeLate));
  EXPECT_THAT(EndOf(*late), HasSubstr("aborted: plan_dispatcher could not run for 9 s"));
  EXPECT_THAT(a_.goals, SizeIs(0));
  Run(2000);
  static_cast<void>(Send(PlanOf({{"a"}})));
  EXPECT_THAT(a_.goals, SizeIs(1));
}

// It sent the next step, an hour after its robots had finished the first one.
TEST_F(APlanServer, EndsThePlanThatWasUnderWayBeforeALongBreakOfItsProcess) {
  const auto sent = Send(PlanOf({{"a", "b"}, {"b"}}));
  ASSERT_THAT(a_.goals, SizeIs(1));
  ASSERT_THAT(b_.goals, SizeIs(1));
  node_->loop().suspended += std::chrono::hours(1);
  a_.goals[0].Succeed({true, "completed"});
  b_.goals[0].Succeed({true, "completed"});
  Run(500);
  EXPECT_THAT(b_.goals, SizeIs(1));
  EXPECT_EQ(EndOf(*sent),
            "aborted: Cancelled in timestep 1: plan_dispatcher could not run for 3600 s");
}

TEST_F(APlanServer, CancelsTheSkillsThatRunAfterALongBreakOfItsProcess) {
  const auto sent = Send(PlanOf({{"a", "b"}}));
  node_->loop().suspended += std::chrono::hours(1);
  Run(500);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_EQ(EndOf(*sent),
            "aborted: Cancelled in timestep 1: plan_dispatcher could not run for 3600 s");
}

TEST_F(APlanServer, GoesOnWithItsPlanAfterAShortBreakAndAfterALongOneBeforeIt) {
  node_->loop().suspended += std::chrono::hours(1);
  Run(3000);
  const auto sent = Send(PlanOf({{"a"}, {"b"}}));
  ASSERT_THAT(a_.goals, SizeIs(1));
  node_->loop().suspended += std::chrono::seconds(50);
  a_.goals[0].Succeed({true, "completed"});
  Run(500);
  EXPECT_THAT(b_.goals, SizeIs(1));
  EXPECT_EQ(EndOf(*sent), "not ended");
}

TEST_F(APlanServer, CancelsThePlanWhenTheMachineLeavesActive) {
  const auto sent = Send(PlanOf({{"a"}}));
  server_.lock()->Permit(false, "it is in LowPower");
  Run(500);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_EQ(EndOf(*sent), "aborted: Cancelled in timestep 1: it is in LowPower");
  EXPECT_EQ(EndOf(*Send(PlanOf({{"a"}}))), "aborted: no plans are executed: it is in LowPower");
}

TEST_F(APlanServer, CancelsTheGoalsOfItsRobotsWhenItsProcessEnds) {
  static_cast<void>(Send(PlanOf({{"a", "b"}})));
  endpoints_.reset();
  Run(500);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_EQ(b_.cancels, 1);
}

// The robots went on, and refused the next plan: their skills ran already.
TEST_F(APlanServer, CancelsTheSkillsThatAKilledProcessHasLeftAndNoOthers) {
  static_cast<void>(Send(PlanOf({{"a", "b"}})));
  const auto other =
      transport::MakeActionClient<msg::SkillExecution>(*desk_, "a/skill_execution").value();
  other->SendGoal({}, std::chrono::seconds(1), {});
  Run(500);
  ASSERT_THAT(a_.goals, SizeIs(2));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Crash(node_->simulated());
  Run(1000);
  EXPECT_EQ(a_.cancels + b_.cancels, 0);
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  const auto next = Serve(*node);
  Run(500);
  EXPECT_EQ(a_.goals[0].state(), GoalState::kCanceled);
  EXPECT_EQ(a_.goals[1].state(), GoalState::kExecuting) << "of another client";
  EXPECT_EQ(b_.goals[0].state(), GoalState::kCanceled);
  static_cast<void>(Send(PlanOf({{"b"}})));
  Run(5000);
  ASSERT_THAT(b_.goals, SizeIs(2));
  EXPECT_EQ(b_.goals[1].state(), GoalState::kExecuting);
}

TEST_F(APlanServer, CancelsWhatAKilledProcessHasLeftOnceTheRobotIsBackAlsoWhenItIsKilledAgain) {
  static_cast<void>(Send(PlanOf({{"a", "b"}})));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Partition("robot", "b");
  network_.Crash(node_->simulated());
  const std::unique_ptr<transport::Node> node = network_.MakeNode("robot");
  const auto next = Serve(*node);
  Run(5000);
  EXPECT_EQ(a_.cancels, 1);
  network_.Crash(*node);
  const std::unique_ptr<transport::Node> last_node = network_.MakeNode("robot");
  const auto last = Serve(*last_node);
  Run(5000);
  EXPECT_EQ(b_.cancels, 0);
  network_.Heal("robot", "b");
  Run(5000);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_FALSE(std::filesystem::exists(goals_file_));
}

// The robot drove on: the goal was forgotten with the first attempt, also on the disk.
TEST_F(APlanServer, CancelsWhatAKilledProcessHasLeftOnceAClientForItCanBeMade) {
  static_cast<void>(Send(PlanOf({{"a", "b"}})));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Crash(node_->simulated());
  FailingNode node(network_.MakeNode("robot"));
  const auto next = Serve(node);
  Run(3000);
  EXPECT_EQ(a_.cancels, 1);
  EXPECT_EQ(b_.cancels, 0);
  EXPECT_THAT(SavedGoals(goals_file_).Found().value(), ElementsAre(Pair(b_.goals[0].id(), "b")));
  EXPECT_THAT(log_, Contains("b: a skill that a process before has left to it is not cancelled "
                             "yet: out of memory; it is tried again each second"));
  node.fails = false;
  Run(3000);
  EXPECT_EQ(b_.cancels, 1);
  EXPECT_FALSE(std::filesystem::exists(goals_file_));
}

TEST_F(APlanServer, KeepsWhatAKilledProcessHasLeftAfterAMinuteForTheNextPlan) {
  static_cast<void>(Send(PlanOf({{"a", "b"}})));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Crash(node_->simulated());
  FailingNode node(network_.MakeNode("robot"));
  const auto next = Serve(node);
  Run(61'000);
  const int failures = node.failures;
  EXPECT_EQ(failures, 61) << "at its start, and one a second";
  Run(600'000);
  EXPECT_EQ(node.failures, failures);
  EXPECT_THAT(log_, Contains(HasSubstr("is not cancelled: out of memory; it is tried again with "
                                       "each plan and after `musher restart plan_dispatcher`")));
  EXPECT_THAT(SavedGoals(goals_file_).Found().value(), ElementsAre(Pair(b_.goals[0].id(), "b")));
  node.fails = false;
  static_cast<void>(Send(PlanOf({{"b"}})));
  Run(5000);
  EXPECT_EQ(b_.cancels, 1);
  ASSERT_THAT(b_.goals, SizeIs(2));
  EXPECT_EQ(b_.goals[0].state(), GoalState::kCanceled);
  EXPECT_EQ(b_.goals[1].state(), GoalState::kExecuting);
}

// Its disk was full for a moment, and its goals did not change any more.
TEST_F(APlanServer, SavesTheGoalsOfAStepOnceTheDiskTakesThem) {
  BlockDisk();
  static_cast<void>(Send(PlanOf({{"b"}})));
  ASSERT_THAT(b_.goals, SizeIs(1));
  EXPECT_THAT(log_, Contains(HasSubstr("the goals of the plan are not saved")));
  FreeDisk();
  Run(1500);
  EXPECT_THAT(SavedGoals(goals_file_).Found().value(), ElementsAre(Pair(b_.goals[0].id(), "b")));
  EXPECT_THAT(log_, Contains("the goals of the plan are saved"));
}

TEST_F(APlanServer, SavesTheGoalsThatAPlanHasLeftOnceTheDiskTakesThem) {
  BlockDisk();
  const auto sent = Send(PlanOf({{"b"}}));
  ASSERT_THAT(b_.goals, SizeIs(1));
  network_.Partition("robot", "b");
  Run(60'000);
  ASSERT_THAT(EndOf(*sent), HasSubstr("b wait: "));
  FreeDisk();
  Run(1500);
  EXPECT_THAT(SavedGoals(goals_file_).Found().value(), ElementsAre(Pair(b_.goals[0].id(), "b")));
}

TEST_F(APlanServer, SavesTheGoalsOfAStepBeforeItSendsThem) {
  std::vector<bool> saved;
  network_.on_write = [&](transport::ParticipantId, const std::string& topic, const msg::Bytes&) {
    if (topic.find("/skill_execution/_action/send_goalRequest") == std::string::npos) return;
    saved.push_back(std::filesystem::exists(goals_file_));
  };
  static_cast<void>(Send(PlanOf({{"a"}, {"b"}})));
  network_.on_write = nullptr;
  EXPECT_THAT(saved, ElementsAre(true));
  ASSERT_THAT(a_.goals, SizeIs(1));
  const auto found = [this] { return SavedGoals(goals_file_).Found().value(); };
  EXPECT_THAT(found(), ElementsAre(Pair(a_.goals[0].id(), "a")));
  a_.goals[0].Succeed({true, "completed"});
  Run(200);
  ASSERT_THAT(b_.goals, SizeIs(1));
  EXPECT_THAT(found(), ElementsAre(Pair(b_.goals[0].id(), "b")));
  b_.goals[0].Succeed({true, "completed"});
  Run(200);
  EXPECT_FALSE(std::filesystem::exists(goals_file_));
}

}  // namespace musher::skills::plan_server_test
