// RunSkill on a simulated network in virtual time, with fakes of the skill actuators: what it does
// when a connection is lost, when an actuator crashes, and where several machines have skills.

#include <unistd.h>

#include "musher/application/skill_node.hpp"
#include "musher/base/host.hpp"
#include "musher/messages/musher_msgs/actuator_status.hpp"
#include "musher/messages/musher_msgs/machine_status.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/messages/plan_msgs/skill.hpp"
#include "musher/test/behavior/tree/trees.hpp"
#include "musher/test/transport/node_with_peers.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::skill_node_network_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using tree::Status;

constexpr Duration kLease = std::chrono::seconds(1);

// Latches the status of an actuator of that machine.
void PublishStatus(transport::Endpoints& endpoints, const std::string& actuator,
                   const std::string& machine) {
  msg::ActuatorStatus status;
  status.name = actuator;
  status.machine = machine;
  endpoints.PublishFunction<msg::ActuatorStatus>("musher/actuator_status",
                                                 transport::kLatchedQos)(status);
}

// A skill actuator with the skills `wait` and `home`, whose runs the test ends.
class FakeRobot {
 public:
  using Goal = transport::ServerGoal<msg::SkillExecution>;
  struct Options {
    std::string actuator = "show";
    std::string action = "/skill_execution";
    std::string machine{};    // empty: it publishes no status
    std::string continues{};  // a skill that ran when the process before was killed
    std::string goal_of_it{};
  };

  explicit FakeRobot(std::unique_ptr<transport::Node> node) : FakeRobot(std::move(node), {}) {}
  FakeRobot(std::unique_ptr<transport::Node> node, const Options& options)
      : node_(std::move(node)), endpoints_(*node_, "") {
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [this](Goal goal) {
      goal.Execute();
      log.push_back(goal.goal().skill_request.skill_list.at(0).skill + " starts");
      goals.push_back(std::move(goal));
    };
    handlers.cancel = [this](const Goal& goal) {
      log.push_back(goal.goal().skill_request.skill_list.at(0).skill + " is to stop");
    };
    if (!options.action.empty()) {
      endpoints_.ServeAction<msg::SkillExecution>(options.action, std::move(handlers));
    }
    endpoints_.Serve<msg::GetSkill>(
        options.actuator + "/get_skill", [options](const auto& request, auto reply) {
          msg::GetSkill::Response response;
          response.feedback.skill = request.skill;
          response.feedback.state = request.skill == options.continues ? "WAITING" : "IDLE";
          response.feedback.goal_id = options.goal_of_it;
          reply(response);
        });
    endpoints_.Serve<msg::CancelSkill>(
        options.actuator + "/cancel_skill", [this](const auto& request, auto reply) {
          log.push_back(request.skill + " is cancelled by " + request.by);
          msg::CancelSkill::Response response;
          response.success = true;
          reply(response);
        });
    msg::SkillOffers offers{options.actuator, options.action, {}};
    for (const char* skill : {"wait", "home"}) offers.skills.push_back({skill, "", {}});
    endpoints_.PublishFunction<msg::SkillOffers>("skills", transport::kLatchedQos)(offers);
    if (!options.machine.empty()) PublishStatus(endpoints_, options.actuator, options.machine);
  }

  transport::Node& node() { return *node_; }

  std::vector<Goal> goals;  // that were started
  std::vector<std::string> log;

 private:
  std::unique_ptr<transport::Node> node_;
  transport::Endpoints endpoints_;
};

class RunSkill : public ::testing::Test {
 protected:
  RunSkill() {
    network_.SetLease(kLease);
    EXPECT_TRUE(nodes_.Register(factory_));
    EXPECT_TRUE(factory_.Add<tree::Say>("Say", said_));
    nodes_.Open(endpoints_);
  }

  void Make(const std::string& content) {
    tree_ = tree::MakeTree(tree::Main(content), factory_);
    ASSERT_TRUE(tree_);
  }
  Status Tick() {
    const auto ticked = tree_->TickOnce(network_.now());
    EXPECT_TRUE(ticked) << ticked.error().message;
    return ticked ? ticked.value() : Status::kIdle;
  }
  void Run(double seconds) { network_.RunFor(Milliseconds(static_cast<int>(1000 * seconds))); }
  // Once the offers are received, and as long as the node looks for more.
  Status Begin() {
    Run(0.5);
    Status status = Tick();
    for (int i = 0; i < 8 && status == Status::kRunning; ++i) {
      Run(0.5);
      status = Tick();
    }
    return status;
  }
  std::string Entry(const std::string& key) {
    const auto entry = tree_->board().Get<std::string>(key);
    return entry ? entry.value() : "";
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("desk");
  SkillNodes nodes_;
  std::string said_;
  tree::Factory factory_;
  std::unique_ptr<tree::Tree> tree_;
  transport::Endpoints endpoints_{*node_, ""};
};

constexpr const char* kWait = R"(<RunSkill skill="wait" message="{message}"/>)";
constexpr const char* kWaitOrHome = R"(<Fallback>
  <RunSkill skill="wait" message="{message}"/>
  <RunSkill skill="home" message="{home}"/>
</Fallback>)";

TEST_F(RunSkill, ReadsTheOutcomeOfItsSkillAlsoAfterAnotherNodeHasStartedOne) {
  FakeRobot robot(network_.MakeNode("robot"));
  Make(R"(<Parallel success_count="2">
    <Sequence><Say name="gate" does="RS"/><RunSkill skill="home"/></Sequence>
    <RunSkill skill="wait" message="{message}"/>
  </Parallel>)");
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  ASSERT_THAT(robot.log, ElementsAre("wait starts"));
  ASSERT_TRUE(robot.goals[0].Succeed({true, "completed: Waited (100%)"}));
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning) << "the other skill runs";
  EXPECT_EQ(Entry("message"), "completed: Waited (100%)");
  Run(0.5);
  EXPECT_THAT(robot.log, ElementsAre("wait starts", "home starts"));
}

TEST_F(RunSkill, CancelsASkillThatItHasLostOnceTheConnectionIsBackAndStartsNoOtherBefore) {
  FakeRobot robot(network_.MakeNode("robot"));
  Make(kWaitOrHome);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  ASSERT_THAT(robot.log, ElementsAre("wait starts"));
  network_.Partition("desk", "robot");
  Run(6);
  EXPECT_EQ(Tick(), Status::kRunning) << "it looks for the skill after it";
  EXPECT_THAT(Entry("message"), HasSubstr("may still run"));
  EXPECT_THAT(Entry("message"), HasSubstr("connection to the server lost"));
  network_.Heal("desk", "robot");
  Run(2);
  EXPECT_THAT(robot.log, ElementsAre("wait starts", "wait is to stop"));
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(1);
  EXPECT_EQ(robot.log.size(), 2U) << "the skill before it has not ended";
  ASSERT_TRUE(robot.goals[0].Canceled({false, "cancelled: by its client (10%)"}));
  Run(1);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(1);
  EXPECT_THAT(robot.log, ElementsAre("wait starts", "wait is to stop", "home starts"));
}

TEST_F(RunSkill, FailsWhileASkillThatItHasLostDoesNotEnd) {
  FakeRobot robot(network_.MakeNode("robot"));
  Make(kWaitOrHome);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  network_.Pause(robot.node());
  Run(6);
  EXPECT_EQ(Tick(), Status::kRunning);
  network_.Resume(robot.node());
  Run(2);
  for (int i = 0; i < 12; ++i) {
    Run(1);
    Tick();
  }
  EXPECT_THAT(Entry("home"), HasSubstr("has not ended"));
  EXPECT_THAT(robot.log, ::testing::Not(::testing::Contains("home starts")));
}

TEST_F(RunSkill, StartsAnotherSkillWhenTheActuatorHasRestartedAndDoesNotKnowTheLostOne) {
  auto robot = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Make(kWaitOrHome);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  network_.Crash(robot->node());
  FakeRobot restarted(network_.MakeNode("robot"));
  Run(2);
  EXPECT_EQ(Tick(), Status::kRunning);
  EXPECT_THAT(Entry("message"), HasSubstr("the server does not know the goal"));
  Run(1);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(1);
  EXPECT_THAT(restarted.log, ElementsAre("home starts"));
}

TEST_F(RunSkill, CancelsARunThatTheActuatorContinuesWithoutItsGoalAfterARestart) {
  auto robot = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Make(kWaitOrHome);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  network_.Crash(robot->node());
  FakeRobot restarted(network_.MakeNode("robot"), {.continues = "wait"});
  Run(3);
  EXPECT_EQ(Tick(), Status::kRunning);
  EXPECT_THAT(restarted.log, ElementsAre("wait is cancelled by a behaviour tree that has lost it"));
  Run(1);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(1);
  EXPECT_EQ(restarted.log.back(), "home starts");
}

TEST_F(RunSkill, DoesNotCancelTheRunOfAnotherClientAfterARestart) {
  auto robot = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Make(kWait);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  network_.Crash(robot->node());
  FakeRobot restarted(network_.MakeNode("robot"), {.continues = "wait", .goal_of_it = "4f"});
  Run(6);
  EXPECT_EQ(Tick(), Status::kFailure);
  EXPECT_THAT(restarted.log, IsEmpty());
}

TEST_F(RunSkill, DoesNotCancelAContinuedRunWhereItsOwnGoalWasNeverAccepted) {
  auto robot = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Make(kWait);
  Run(0.5);
  network_.Pause(robot->node());  // it does not receive the goal
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(6);
  EXPECT_EQ(Tick(), Status::kFailure);
  network_.Crash(robot->node());
  FakeRobot restarted(network_.MakeNode("robot"), {.continues = "wait"});
  Run(6);
  EXPECT_THAT(restarted.log, IsEmpty()) << "the run is another client's";
}

TEST_F(RunSkill, AwaitsTheEndOfAContinuedRunThatMayBeThatOfItsOwnGoal) {
  auto robot = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Make(kWaitOrHome);
  Run(0.5);
  network_.Pause(robot->node());
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(6);
  EXPECT_EQ(Tick(), Status::kRunning);
  network_.Crash(robot->node());
  auto restarted = std::make_unique<FakeRobot>(network_.MakeNode("robot"),
                                               FakeRobot::Options{.continues = "wait"});
  Run(4);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  EXPECT_THAT(restarted->log, IsEmpty()) << "neither cancelled nor taken for ended";
  network_.Crash(restarted->node());
  FakeRobot idle(network_.MakeNode("robot"));
  Run(4);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(0.5);
  EXPECT_THAT(idle.log, ElementsAre("home starts"));
}

TEST_F(RunSkill, CancelsAContinuedRunAlsoWhereTheReplyToItsGoalWasLost) {
  const auto node = network_.MakeNode("robot");
  transport::Endpoints topics(*node, "");
  const auto status = topics.PublishFunction<msg::GoalStatusArray>("skill_execution/_action/status",
                                                                   transport::kLatchedQos);
  topics.Serve<msg::SkillExecution::SendGoal>(
      "skill_execution/_action/send_goal", [&status](const auto& request, const auto& /*reply*/) {
        status({{{{request.goal_id, {}}, msg::GoalStatus::kStatusExecuting}}});
      });
  topics.PublishFunction<msg::SkillOffers>(
      "skills", transport::kLatchedQos)({"show", "/skill_execution", {{"wait", "", {}}}});
  Make(kWait);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  Run(6);
  EXPECT_EQ(Tick(), Status::kRunning) << "its status says that it runs";
  network_.Crash(*node);
  FakeRobot restarted(network_.MakeNode("robot"), {.continues = "wait"});
  Run(6);
  EXPECT_THAT(restarted.log, ElementsAre("wait is cancelled by a behaviour tree that has lost it"));
}

TEST_F(RunSkill, SharesOneClientWithTheOtherNodesThatRunSkillsOfAnActuator) {
  FakeRobot robot(network_.MakeNode("robot"));
  const auto feedback = transport::MakePublisher<msg::SkillExecution::FeedbackMessage>(
                            robot.node(), "skill_execution/_action/feedback")
                            .value();
  Make(R"(<Parallel success_count="2">
    <RunSkill skill="wait"/><RunSkill skill="home"/></Parallel>)");
  EXPECT_EQ(Begin(), Status::kRunning);
  Run(0.5);
  EXPECT_EQ(Tick(), Status::kRunning);
  EXPECT_THAT(robot.log, ElementsAre("wait starts", "home starts"));
  EXPECT_EQ(feedback->MatchedReaders(), 1U);
}

TEST_F(RunSkill, StartsASkillOfAnActuatorThatHasRestartedBeforeTheOneThatCrashedIsLost) {
  network_.SetLease(std::chrono::seconds(60));
  auto crashed = std::make_unique<FakeRobot>(network_.MakeNode("robot"));
  Run(0.5);
  network_.Crash(crashed->node());
  FakeRobot restarted(network_.MakeNode("robot"));
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kRunning) << Entry("message");
  EXPECT_THAT(restarted.log, ElementsAre("wait starts"));
}

TEST_F(RunSkill, FailsForAnOfferWithoutAnAction) {
  FakeRobot robot(network_.MakeNode("robot"), {.action = ""});
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kFailure);
  EXPECT_EQ(Entry("message"), "show offers wait without an action");
}

TEST_F(RunSkill, StartsNoSkillOfTheActuatorOfAnotherMachine) {
  PublishStatus(endpoints_, "patrol", "dog");
  FakeRobot cat(network_.MakeNode("cat"), {.machine = "cat"});
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kFailure);
  EXPECT_EQ(Entry("message"),
            "no actuator of dog that runs offers the skill wait; it is offered by show of cat");
  Make(R"(<RunSkill skill="wait" actuator="show" message="{message}"/>)");
  EXPECT_EQ(Begin(), Status::kFailure);
  EXPECT_EQ(Entry("message"),
            "no actuator show of dog offers the skill wait; it is offered by show of cat");
  EXPECT_THAT(cat.log, IsEmpty());
}

TEST_F(RunSkill, StartsTheSkillOfItsOwnMachineWhereAnotherOneHasItToo) {
  PublishStatus(endpoints_, "patrol", "dog");
  FakeRobot cat(network_.MakeNode("cat"), {.action = "/cat/skill_execution", .machine = "cat"});
  FakeRobot dog(network_.MakeNode("dog"), {.action = "/dog/skill_execution", .machine = "dog"});
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kRunning) << Entry("message");
  EXPECT_THAT(dog.log, ElementsAre("wait starts"));
  EXPECT_THAT(cat.log, IsEmpty());
}

TEST_F(RunSkill, StartsNoSkillByAnActionThatTwoMachinesServe) {
  PublishStatus(endpoints_, "patrol", "dog");
  FakeRobot cat(network_.MakeNode("cat"), {.actuator = "purr", .machine = "cat"});
  FakeRobot dog(network_.MakeNode("dog"), {.machine = "dog"});
  Make(R"(<RunSkill skill="wait" actuator="show" message="{message}"/>)");
  EXPECT_EQ(Begin(), Status::kFailure);
  EXPECT_EQ(Entry("message"),
            "/skill_execution is served by cat, too, which would receive the goal; give each "
            "machine a namespace");
  EXPECT_THAT(dog.log, IsEmpty());
  EXPECT_THAT(cat.log, IsEmpty());
}

// With security keys an actuator receives no statuses of actuators, but the reports of controllers.
class RunSkillWithKeys : public RunSkill {
 protected:
  RunSkillWithKeys() { nodes_.Open(with_peers_); }

  // Latches the processes of its actuators, as a controller does.
  void Report(FakeRobot& robot, const std::string& machine, std::int32_t pid, bool own) {
    msg::MachineStatus status;
    status.machine = machine;
    status.actuators.resize(own ? 2 : 1);
    status.actuators[0].name = "show";
    status.actuators[0].pid = pid;
    if (own) {
      status.actuators[1].name = "patrol";
      status.actuators[1].pid = getpid();
      status.actuators[1].host = HostId();
    }
    reports_.push_back(transport::MakePublisher<msg::MachineStatus>(
                           robot.node(), "musher/machine_status", transport::kLatchedQos)
                           .value());
    EXPECT_TRUE(reports_.back()->Publish(status));
    knowing_.peers.push_back({robot.node().participant(), pid, "", 0, ""});
  }

  testing::NodeWithPeers knowing_{network_.MakeNode("desk")};
  transport::Endpoints with_peers_{knowing_, ""};
  std::vector<std::unique_ptr<transport::Publisher<msg::MachineStatus>>> reports_;
};

TEST_F(RunSkillWithKeys, KnowsTheMachineOfAnActuatorByItsProcess) {
  FakeRobot cat(network_.MakeNode("cat"), {.action = "/cat/skill_execution"});
  FakeRobot dog(network_.MakeNode("dog"), {.action = "/dog/skill_execution"});
  Report(cat, "cat", 4711, false);
  Report(dog, "dog", 815, true);
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kRunning) << Entry("message");
  EXPECT_THAT(dog.log, ElementsAre("wait starts"));
  EXPECT_THAT(cat.log, IsEmpty());
}

TEST_F(RunSkillWithKeys, StartsNoSkillByAnActionThatTwoMachinesServe) {
  FakeRobot cat(network_.MakeNode("cat"), {.actuator = "show"});
  FakeRobot dog(network_.MakeNode("dog"), {.actuator = "show"});
  Report(cat, "cat", 4711, false);
  Report(dog, "dog", 815, true);
  Make(kWait);
  EXPECT_EQ(Begin(), Status::kFailure);
  EXPECT_THAT(Entry("message"), HasSubstr("/skill_execution is served by cat, too"));
  EXPECT_THAT(dog.log, IsEmpty());
  EXPECT_THAT(cat.log, IsEmpty());
}

TEST_F(RunSkillWithKeys, TakesNoMachineWhereTwoReportTheSameProcess) {
  FakeRobot cat(network_.MakeNode("cat"), {.action = "/cat/skill_execution"});
  Report(cat, "cat", 4711, false);
  FakeRobot dog(network_.MakeNode("dog"), {.actuator = "other"});
  Report(dog, "dog", 4711, true);
  Make(R"(<RunSkill skill="wait" actuator="show" message="{message}"/>)");
  EXPECT_EQ(Begin(), Status::kRunning) << "as before: not known";
  EXPECT_THAT(cat.log, ElementsAre("wait starts"));
}

}  // namespace musher::skill_node_network_test
