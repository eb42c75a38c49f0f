// In virtual time: a page runs skills of an actuator.

#include "musher/view/live/skill_requests.hpp"

#include <gmock/gmock.h>

#include "musher/transport/sim/network.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::view::skill_requests_test {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

class SkillsOfAPage : public ::testing::Test {
 protected:
  using Goal = transport::ServerGoal<msg::SkillExecution>;

  SkillsOfAPage() {
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [this](Goal goal) {
      const msg::SkillInfo& info = goal.goal().skill_request.skill_list.at(0);
      if (info.skill == "refuse") {
        goal.Abort({false, "the battery is empty"});
        return;
      }
      for (const msg::SkillParameter& one : info.params) requested_ += one.key + "=" + one.value;
      goal.Execute();
      running_.push_back(goal);
    };
    handlers.may_cancel = [](const Goal& goal) {
      return goal.goal().skill_request.skill_list.at(0).skill != "deaf";
    };
    handlers.cancel = [this](Goal goal) {
      goal.Canceled({false, "cancelled"});
      ++cancelled_;
    };
    server_ =
        transport::MakeActionServer<msg::SkillExecution>(*robot_, "dog/skill_execution", handlers)
            .value();
    ServePauses();
    cancels_ = transport::MakeServer<msg::CancelSkill>(
                   *robot_, "dog/cancel_skill",
                   [this](const msg::CancelSkill::Request& request, auto reply) {
                     msg::CancelSkill::Response response;
                     response.success = request.skill == "jump";
                     response.message = response.success ? "cancelled" : "it does not run";
                     cancelled_by_ = request.by;
                     reply(response);
                   })
                   .value();
    network_.RunFor(std::chrono::seconds(1));
  }

  void ServePauses() {
    pauses_ = transport::MakeServer<msg::PauseSkill>(
                  *robot_, "dog/pause_skill",
                  [this](const msg::PauseSkill::Request& request, auto reply) {
                    msg::PauseSkill::Response response;
                    response.success = request.pause != paused_;
                    response.message = response.success ? "EXECUTING" : request.skill + " stands";
                    paused_ = request.pause;
                    reply(response);
                  })
                  .value();
  }

  http::Respond Collect() {
    return [this](http::Response response) {
      answers_.push_back(std::to_string(response.status) + " " + *response.body);
    };
  }
  void Run(const std::string& skill, const std::string& action = "/dog/skill_execution") {
    skills_.Run({"robot", "1234"}, {action, "dog", skill, {{"height_m", "0.5"}}}, Collect());
    network_.RunFor(std::chrono::seconds(20));
  }
  // The status of the actuator dog of a machine, as its process latches it.
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> Publish(transport::Node& node,
                                                                     const std::string& machine,
                                                                     const std::string& id) {
    auto publisher = transport::MakePublisher<msg::ActuatorStatus>(
                         node, transport::ActuatorStatusTopic(""), transport::kLatchedQos)
                         .value();
    msg::ActuatorStatus status;
    status.name = "dog";
    status.machine = machine;
    status.machine_id = id;
    status.participant = node.participant().value();
    EXPECT_TRUE(publisher->Publish(status).ok());
    return publisher;
  }
  // Of the last answer.
  std::string GoalId() const {
    const std::string& answer = answers_.back();
    const std::size_t at = answer.find("goal_id\":\"");
    return at == std::string::npos ? "" : answer.substr(at + 10, 32);
  }

  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> desk_ = network_.MakeNode("desk");
  std::vector<Goal> running_;
  std::string requested_;
  int cancelled_ = 0;
  std::unique_ptr<transport::ActionServer<msg::SkillExecution>> server_;
  bool paused_ = false;
  std::unique_ptr<transport::Server<msg::PauseSkill>> pauses_;
  std::string cancelled_by_;
  std::unique_ptr<transport::Server<msg::CancelSkill>> cancels_;
  std::vector<std::string> answers_;
  SkillRequests skills_{*desk_, "", /*with_keys=*/false};
};

TEST_F(SkillsOfAPage, RunAndAreCancelled) {
  Run("jump");
  ASSERT_THAT(answers_, ElementsAre(StartsWith(R"(200 {"goal_id":")")));
  EXPECT_EQ(requested_, "height_m=0.5");
  skills_.Cancel("/dog/skill_execution", GoalId(), Collect());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_EQ(answers_.back(), "200 {}");
  EXPECT_EQ(cancelled_, 1);
}

TEST_F(SkillsOfAPage, OfTheMachineOnThePageRun) {
  const auto status = Publish(*robot_, "robot", "1234");
  Run("jump");
  EXPECT_THAT(answers_, ElementsAre(StartsWith(R"(200 {"goal_id":")")));
}

// A goal goes to every actuator of its name: it moved both robots.
TEST_F(SkillsOfAPage, OfAnActuatorThatTwoMachinesHaveRunOnNone) {
  const auto status = Publish(*robot_, "robot", "1234");
  const auto other = network_.MakeNode("other");
  const auto other_status = Publish(*other, "robot", "5678");
  transport::ActionHandlers<msg::SkillExecution> handlers;
  handlers.start = [this](Goal goal) { running_.push_back(goal); };
  const auto other_server =
      transport::MakeActionServer<msg::SkillExecution>(*other, "dog/skill_execution", handlers)
          .value();
  Run("jump");
  EXPECT_THAT(answers_, ElementsAre(::testing::AllOf(
                            StartsWith("409"), HasSubstr("is an actuator of several machines"))));
  EXPECT_THAT(running_, IsEmpty());
}

TEST_F(SkillsOfAPage, OfAnotherMachineThanThatOnThePageDoNotGoOn) {
  const auto status = Publish(*robot_, "other", "5678");
  skills_.Resume({"robot", "1234"}, "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(answers_,
              ElementsAre(::testing::AllOf(StartsWith("409"), HasSubstr("the page shows robot"))));
}

TEST_F(SkillsOfAPage, ThatAreRefusedSayWhy) {
  Run("refuse");
  EXPECT_THAT(answers_,
              ElementsAre(::testing::AllOf(StartsWith("409"), HasSubstr("the battery is empty"))));
}

TEST_F(SkillsOfAPage, ThatEndLaterAreAnsweredOnce) {
  Run("jump");
  running_.at(0).Succeed({true, "completed"});
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(answers_.size(), 1U);
}

TEST_F(SkillsOfAPage, ThatCannotBeCancelledSaySo) {
  Run("deaf");
  skills_.Cancel("/dog/skill_execution", GoalId(), Collect());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(answers_.back(), HasSubstr("refuses the cancellation"));
  skills_.Cancel("/dog/skill_execution", std::string(32, 'a'), Collect());
  network_.RunFor(std::chrono::seconds(1));
  EXPECT_THAT(answers_.back(), HasSubstr("has ended already"));
}

TEST_F(SkillsOfAPage, ArePausedAndResumedAndARefusalSaysWhy) {
  const auto pause = [&](const std::string& actuator, bool stop) {
    if (stop) skills_.Pause({"robot", "1234"}, actuator, "jump", Collect());
    if (!stop) skills_.Resume({"robot", "1234"}, actuator, "jump", Collect());
    network_.RunFor(std::chrono::seconds(20));
    return answers_.back();
  };
  EXPECT_EQ(pause("dog", true), "200 {}");
  EXPECT_TRUE(paused_);
  EXPECT_THAT(pause("dog", true), ::testing::AllOf(StartsWith("409"), HasSubstr("jump stands")));
  EXPECT_EQ(pause("dog", false), "200 {}");
  EXPECT_FALSE(paused_);
  EXPECT_THAT(pause("cat", true), StartsWith("504"));
  EXPECT_THAT(pause("dog cat", true), StartsWith("400"));
  EXPECT_EQ(answers_.size(), 5U);
}

// It waited for the machines of the actuator, and overtook the pause of another person.
TEST_F(SkillsOfAPage, ThatArePausedAgainMeanwhileDoNotGoOn) {
  skills_.Pause({"robot", "1234"}, "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(1));
  skills_.Resume({"robot", "1234"}, "dog", "jump", Collect());
  skills_.Pause({"robot", "1234"}, "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_TRUE(paused_);
  EXPECT_THAT(answers_, Contains(::testing::AllOf(StartsWith("409"), HasSubstr("meanwhile"))));
}

TEST_F(SkillsOfAPage, WithoutAGoalAreCancelledInTheNameOfThePerson) {
  const auto cancel = [&](const std::string& actuator, const std::string& skill) {
    skills_.CancelRun({"robot", "1234"}, "alice at 127.0.0.1", actuator, skill, Collect());
    network_.RunFor(std::chrono::seconds(20));
    return answers_.back();
  };
  EXPECT_EQ(cancel("dog", "jump"), "200 {}");
  EXPECT_EQ(cancelled_by_, "alice at 127.0.0.1 on the page");
  EXPECT_THAT(cancel("dog", "run"), ::testing::AllOf(StartsWith("409"), HasSubstr("does not run")));
  EXPECT_THAT(cancel("cat", "jump"), StartsWith("504"));
  EXPECT_THAT(cancel("dog cat", "jump"), StartsWith("400"));
}

// Two robots without namespaces: the first reply, of any of them, was taken for that of the page's.
class SkillsOfTwoMachines : public SkillsOfAPage {
 protected:
  SkillsOfTwoMachines() {
    other_pauses_ =
        transport::MakeServer<msg::PauseSkill>(*other_, "dog/pause_skill",
                                               [this](const msg::PauseSkill::Request&, auto reply) {
                                                 ++others_;
                                                 reply({true, "EXECUTING"});
                                               })
            .value();
    other_cancels_ = transport::MakeServer<msg::CancelSkill>(
                         *other_, "dog/cancel_skill",
                         [this](const msg::CancelSkill::Request&, auto reply) {
                           ++others_;
                           reply({true, "cancelled"});
                         })
                         .value();
    transport::ActionHandlers<msg::SkillExecution> handlers;
    handlers.start = [](const Goal& /*goal*/) {};
    other_action_ = transport::MakeActionServer<msg::SkillExecution>(*other_, "dog/skill_execution",
                                                                     std::move(handlers))
                        .value();
    network_.RunFor(std::chrono::seconds(1));
  }

  std::unique_ptr<transport::Node> other_ = network_.MakeNode("other");
  int others_ = 0;  // requests that the other machine has received
  std::unique_ptr<transport::Server<msg::PauseSkill>> other_pauses_;
  std::unique_ptr<transport::Server<msg::CancelSkill>> other_cancels_;
  std::unique_ptr<transport::ActionServer<msg::SkillExecution>> other_action_;
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> status_ =
      Publish(*robot_, "robot", "1234");
  std::unique_ptr<transport::Publisher<msg::ActuatorStatus>> other_status_ =
      Publish(*other_, "robot", "5678");
};

TEST_F(SkillsOfTwoMachines, ArePausedOnceThatOfThePageSaysSo) {
  paused_ = true;           // "jump stands": it refuses
  network_.Pause(*robot_);  // its reply is the last one
  skills_.Pause({"robot", "1234"}, "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(1));
  network_.Resume(*robot_);
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(answers_, ElementsAre(::testing::AllOf(StartsWith("409"), HasSubstr("jump stands"))));
  EXPECT_EQ(others_, 1);
}

TEST_F(SkillsOfTwoMachines, ArePausedAlsoWhereTheOtherIsDiscoveredFirst) {
  pauses_.reset();
  network_.RunFor(std::chrono::seconds(1));
  skills_.Pause({"robot", "1234"}, "dog", "jump", Collect());
  network_.RunFor(Milliseconds(500));
  EXPECT_EQ(others_, 1);
  ServePauses();
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(answers_, ElementsAre(StartsWith("200")));
  EXPECT_TRUE(paused_);
}

TEST_F(SkillsOfTwoMachines, AreNotPausedByTheReplyOfTheOther) {
  pauses_.reset();
  cancels_.reset();
  network_.RunFor(std::chrono::seconds(1));
  skills_.Pause({"robot", "1234"}, "dog", "jump", Collect());
  skills_.CancelRun({"robot", "1234"}, "alice", "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(20));
  const auto unanswered = ::testing::AllOf(StartsWith("504"), HasSubstr("only another machine's"));
  EXPECT_THAT(answers_, ElementsAre(unanswered, unanswered));
  EXPECT_EQ(others_, 2);
}

TEST_F(SkillsOfTwoMachines, ArePausedByNoReplyWhereThePageShowsNoMachine) {
  skills_.Pause({}, "dog", "jump", Collect());
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_THAT(answers_, ElementsAre(::testing::AllOf(StartsWith("504"),
                                                     HasSubstr("the machine on the page"))));
  EXPECT_TRUE(paused_);
}

// The other one does not know the goal, and has replied first: "has ended already", and it ran on.
TEST_F(SkillsOfTwoMachines, AreCancelledWhereTheyRun) {
  other_action_.reset();
  Run("jump");
  transport::ActionHandlers<msg::SkillExecution> handlers;
  handlers.start = [](const Goal& /*goal*/) {};
  other_action_ = transport::MakeActionServer<msg::SkillExecution>(*other_, "dog/skill_execution",
                                                                   std::move(handlers))
                      .value();
  network_.RunFor(std::chrono::seconds(1));
  const std::string id = GoalId();
  network_.Pause(*robot_);  // its reply is the last one
  skills_.Cancel("/dog/skill_execution", id, Collect());
  network_.RunFor(std::chrono::seconds(1));
  network_.Resume(*robot_);
  network_.RunFor(std::chrono::seconds(20));
  EXPECT_EQ(answers_.back(), "200 {}");
  EXPECT_EQ(cancelled_, 1);
}

TEST_F(SkillsOfAPage, OfNoActuatorAreAnsweredInTime) {
  Run("jump", "/cat/skill_execution");
  EXPECT_THAT(answers_, ElementsAre(StartsWith("504")));
}

TEST_F(SkillsOfAPage, WithAMalformedRequestAreRefused) {
  for (const std::string action : {"", "/", "/dog skill", "/dog\n", "/dög"}) Run("jump", action);
  skills_.Cancel("/dog/skill_execution", "17", Collect());
  EXPECT_THAT(answers_, ::testing::Each(StartsWith("400")));
  EXPECT_EQ(answers_.size(), 6U);
  EXPECT_THAT(running_, IsEmpty());
}

}  // namespace musher::view::skill_requests_test
