// Skills as an actuator: goals, their feedback and results, and what the states of the robot do to
// them.

#include "musher/application/skill_actuator.hpp"

#include <cstdlib>

#include "musher/base/host.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/skill_feedback.hpp"
#include "musher/test/application/skill_tasks.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/process.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::skill_actuator_test {

using ::testing::Contains;
using testing::Harness;
using testing::HasRefusal;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::StartsWith;
using testing::SuspendedThread;
using Tasks = testing::SkillTasks;

class ASkillActuator : public testing::SkillActuatorTest {};

TEST_F(ASkillActuator, ExecutesAGoalWithFeedbackAndItsResult) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "0.1"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 8);
  EXPECT_EQ(EndOf(sent), "succeeded true completed: Waited (100%)");
  EXPECT_EQ(sent->feedback.front(), "processing: Skill wait started (0%)");
  EXPECT_THAT(sent->feedback, Contains("processing: Waiting (60%)"));
}

TEST_F(ASkillActuator, PublishesItsSkillsAndEachChangeOfARun) {
  std::vector<msg::SkillFeedback> received;
  std::vector<msg::SkillOffers> offers;
  std::vector<std::unique_ptr<transport::Subscription>> subscriptions;
  harness_.node().RunOnLoop([&] {
    transport::Node& node = harness_.node().node();
    subscriptions.push_back(
        transport::MakeSubscription<msg::SkillFeedback>(
            node, "skill_feedback", [&](auto&& sample, const auto&) { received.push_back(sample); })
            .value());
    subscriptions.push_back(transport::MakeSubscription<msg::SkillOffers>(
                                node, "skills",
                                [&](auto&& sample, const auto&) { offers.push_back(sample); },
                                transport::kLatchedFromManyQos)
                                .value());
  });
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Await([&] { return !offers.empty() && subscriptions[0]->MatchedWriters() == 1; });
  EXPECT_EQ(offers[0].action, "/skill_execution");
  EXPECT_EQ(offers[0].skills.size(), 2U);
  const auto sent = Send("wait", {{"duration_s", "0.1"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 8);
  Await([&] { return !received.empty() && received.back().progress == 100; });
  EXPECT_EQ(received.front().state, "WAITING");
  EXPECT_EQ(received.back().goal_id.size(), 32U);
  EXPECT_EQ(received.back().goal_id, received.front().goal_id);
  EXPECT_EQ(received.back().status, msg::SkillFeedback::kStatusCompleted);
  EXPECT_GE(received.back().header.stamp.sec, 1'000);
  // A run without a goal has no id.
  ASSERT_TRUE(tasks.Of([](Tasks& t) { return t.manager().Start("wait").ok(); }));
  harness_.Tick(tasks, 2);
  Await([&] { return received.back().status == msg::SkillFeedback::kStatusProcessing; });
  EXPECT_EQ(received.back().goal_id, "");
  harness_.node().RunOnLoop([&] { subscriptions.clear(); });
}

TEST_F(ASkillActuator, ServesTheRunOfASkill) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  std::unique_ptr<transport::Client<msg::GetSkill>> client;
  std::optional<msg::GetSkill::Response> reply;
  harness_.node().RunOnLoop([&] {
    client = transport::MakeClient<msg::GetSkill>(harness_.node().node(), "show/get_skill").value();
    msg::GetSkill::Request request;
    request.skill = "wait";
    request.format = "dot";
    client->Call(request, std::chrono::seconds(120), [&](const auto& r) { reply = r.value(); });
  });
  Await([&] { return reply.has_value(); });
  EXPECT_EQ(reply->error, "");
  EXPECT_TRUE(reply->stepping);
  EXPECT_EQ(reply->feedback.state, "IDLE");
  EXPECT_THAT(reply->graph, HasSubstr("digraph"));
  harness_.node().RunOnLoop([&] { client.reset(); });
}

class APauseOfOneSkill : public ASkillActuator {
 protected:
  // "true WAITING", as the service answers.
  std::string Ask(const std::string& skill, bool pause) {
    std::unique_ptr<transport::Client<msg::PauseSkill>> client;
    std::optional<msg::PauseSkill::Response> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::PauseSkill>(harness_.node().node(), "show/pause_skill")
                   .value();
      msg::PauseSkill::Request request;
      request.skill = skill;
      request.pause = pause;
      client->Call(request, std::chrono::seconds(120), [&](const auto& r) { reply = r.value(); });
    });
    Await([&] { return reply.has_value(); });
    harness_.node().RunOnLoop([&] { client.reset(); });
    return (reply->success ? "true " : "false ") + reply->message;
  }
};

TEST_F(APauseOfOneSkill, StopsItsTimeAndKeepsItsGoalUntilItIsResumed) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "0.5"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 8);
  EXPECT_EQ(Ask("wait", true), "true WAITING");
  Await([&] { return sent->feedback.back().starts_with("processing: paused: Waiting"); });
  harness_.Tick(tasks, 100);
  EXPECT_FALSE(sent->outcome.has_value());
  EXPECT_EQ(Ask("wait", true), "false wait is paused already");
  EXPECT_EQ(Ask("wait", false), "true WAITING");
  harness_.Tick(tasks, 30);
  EXPECT_EQ(EndOf(sent), "succeeded true completed: Waited (100%)");
}

// A goal that waited in the kernel was executed when the robot's computer ran again.
TEST_F(APauseOfOneSkill, IsNotEndedAndNoGoalBegunByWhatWaitedWhileTheComputerWasSuspended) {
  const auto thread = std::make_shared<SuspendedThread>();
  ActuatorRunner<Tasks> tasks;
  Begin(tasks, thread);
  const auto sent = Send("wait", {{"duration_s", "0.5"}});
  AwaitAccepted(sent);
  thread->SuspendEachTime(std::chrono::seconds(9));
  EXPECT_EQ(Ask("wait", true), "true WAITING");
  EXPECT_THAT(Ask("wait", false), HasRefusal(ApplicationRefusal::kMayBeLate));
  EXPECT_THAT(EndOf(Send("fail")), HasRefusal(ApplicationRefusal::kMayBeLate));
  EXPECT_EQ(tasks.StateOf("fail"), "IDLE");
  const auto own = tasks.Of([](Tasks& t) { return t.CheckMayStart(); });
  EXPECT_THAT(own ? "" : own.error().message, HasRefusal(ApplicationRefusal::kMayBeLate))
      << "a request of the application's own";
  thread->SuspendEachTime({});
}

// A drive went on by itself when the robot's computer was opened an hour later.
TEST_F(APauseOfOneSkill, EndsAsCancelledByALongSuspension) {
  const auto thread = std::make_shared<SuspendedThread>();
  ActuatorRunner<Tasks> tasks;
  Begin(tasks, thread);
  const auto sent = Send("wait", {{"duration_s", "0.5"}});
  AwaitAccepted(sent);
  thread->SuspendEachTime(std::chrono::minutes(2));
  harness_.Tick(tasks, 2);
  EXPECT_THAT(EndOf(sent), HasSubstr("it does not go on: its process could not run for "));
  thread->SuspendEachTime({});
}

TEST_F(APauseOfOneSkill, LastsOverAPauseOfTheRobotAndIsResumedInActiveOnly) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "0.2"}});
  AwaitAccepted(sent);
  EXPECT_EQ(Ask("wait", true), "true WAITING");
  ASSERT_TRUE(Go("LowPower"));
  EXPECT_EQ(Ask("wait", false),
            "false " + Refused<ApplicationRefusal::kRunsNoSkills>("show", "LowPower").message);
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(tasks, 50);
  EXPECT_EQ(tasks.StateOf("wait"), "WAITING") << "it stays paused";
  EXPECT_EQ(Ask("wait", false), "true WAITING");
  harness_.Tick(tasks, 30);
  EXPECT_EQ(EndOf(sent), "succeeded true completed: Waited (100%)");
}

TEST_F(APauseOfOneSkill, IsRefusedWithTheReason) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  EXPECT_EQ(Ask("wait", true), "false wait does not run");
  EXPECT_EQ(Ask("wiat", true),
            "false there is no skill 'wiat'; did you mean 'wait'? There are fail and wait");
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  EXPECT_EQ(Ask("wait", false), "false wait is not paused by a request");
}

TEST_F(APauseOfOneSkill, EndsWithTheCancellationOfItsGoal) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  EXPECT_EQ(Ask("wait", true), "true WAITING");
  bool cancelled = false;
  harness_.node().RunOnLoop([&] {
    client_->Cancel(sent->id, std::chrono::seconds(120), [&](const auto&) { cancelled = true; });
  });
  Await([&] { return cancelled; });
  harness_.Tick(tasks, 5);
  EXPECT_THAT(EndOf(sent), HasSubstr("canceled false cancelled: by its client"));
}

class ACancellationByHand : public ASkillActuator {
 protected:
  // "true cancelled: …", as the service answers at the end of the run.
  std::string Ask(ActuatorRunner<Tasks>& tasks, const std::string& skill, const std::string& by) {
    std::unique_ptr<transport::Client<msg::CancelSkill>> client;
    std::optional<msg::CancelSkill::Response> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::CancelSkill>(harness_.node().node(), "show/cancel_skill")
                   .value();
      msg::CancelSkill::Request request;
      request.skill = skill;
      request.by = by;
      client->Call(request, std::chrono::seconds(120), [&](const auto& r) { reply = r.value(); });
    });
    EXPECT_TRUE(testing::Until([&] {
      harness_.Tick(tasks, 1);
      bool has_reply = false;
      harness_.node().RunOnLoop([&] { has_reply = reply.has_value(); });
      return has_reply;
    }));
    harness_.node().RunOnLoop([&] { client.reset(); });
    return (reply->success ? "true " : "false ") + reply->message;
  }
};

TEST_F(ACancellationByHand, EndsARunWithoutAGoalAndNamesWhoHasCancelledIt) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  ASSERT_TRUE(tasks.Of([](Tasks& t) { return t.manager().Start("wait").ok(); }));
  EXPECT_THAT(Ask(tasks, "wait", "alice@dog1"), StartsWith("true cancelled: by alice@dog1"));
  EXPECT_EQ(tasks.StateOf("wait"), "CANCELLED");
  EXPECT_EQ(Ask(tasks, "wait", "alice@dog1"), "false wait does not run");
}

TEST_F(ACancellationByHand, EndsARunWithAGoalWhoseClientReadsWhoHasCancelledIt) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  EXPECT_THAT(Ask(tasks, "wait", ""), StartsWith("true cancelled: by a request"));
  EXPECT_THAT(EndOf(sent), StartsWith("aborted false cancelled: by a request"));
}

TEST_F(ACancellationByHand, EndsARunAtOnceWhileTheRobotIsNotActive) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  ASSERT_TRUE(tasks.Of([](Tasks& t) { return t.manager().Start("wait").ok(); }));
  ASSERT_TRUE(Go("LowPower"));
  EXPECT_THAT(Ask(tasks, "wait", "alice@dog1"), StartsWith("true cancelled: by alice@dog1"));
}

TEST_F(ASkillActuator, RunsSeveralSkillsAtOnce) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto waits = Send("wait", {{"duration_s", "0.1"}});
  const auto fails = Send("fail");
  AwaitAccepted(waits);
  AwaitAccepted(fails);
  harness_.Tick(tasks, 8);
  EXPECT_THAT(EndOf(waits), HasSubstr("succeeded true"));
  EXPECT_THAT(EndOf(fails), HasSubstr("aborted false failed: no path"));
}

// Runs the plain C client with a skill, while the clock runs; its output.
class APlainSkillClient : public ASkillActuator {
 protected:
  std::string Run(ActuatorRunner<Tasks>& tasks, std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {BinDir() + "/skill_client_peer", std::to_string(transport::TestDomain()),
                      "skill_execution"});
    testing::Process peer(arguments);
    std::atomic<bool> exited = false;
    testing::Ended ended;
    std::thread waiting([&] {
      ended = peer.Wait();
      exited = true;
    });
    while (!exited) harness_.Tick(tasks, 1);
    waiting.join();
    EXPECT_EQ(ended.exit, 0) << ended.err;
    return ended.out;
  }
};

TEST_F(APlainSkillClient, RunsASkill) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  // Feedback is volatile: the server's writer may find the client's reader after its first one.
  EXPECT_THAT(Run(tasks, {"wait", "duration_s", "0.5"}),
              MatchesRegex("offered by show on /skill_execution: fail wait\n"
                           "accepted\n"
                           "feedback: processing: (Skill wait started|Waiting) .[0-9]+%.\n"
                           "result of status 4: true completed: Waited .100%.\n"));
}

TEST_F(APlainSkillClient, IsNamedAsTheRequesterOfItsRun) {
  std::vector<std::string> requesters;
  std::unique_ptr<transport::Subscription> feedback;
  harness_.node().RunOnLoop([&] {
    feedback = transport::MakeSubscription<msg::SkillFeedback>(
                   harness_.node().node(), "skill_feedback",
                   [&](const msg::SkillFeedback& sample, const auto&) {
                     EXPECT_EQ(sample.details.back().key, "requested_by");
                     requesters.push_back(sample.details.back().value);
                   })
                   .value();
  });
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  Await([&] { return feedback->MatchedWriters() == 1; });
  Run(tasks, {"wait", "duration_s", "0.5"});
  Await([&] { return !requesters.empty(); });
  const std::string process = requesters.back();
  EXPECT_THAT(process, MatchesRegex("process [0-9]+ of " + HostName()));
  setenv("PEER_NAME", "alice@desk", 1);  // NOLINT(concurrency-mt-unsafe)
  Run(tasks, {"wait", "duration_s", "0.5"});
  unsetenv("PEER_NAME");  // NOLINT(concurrency-mt-unsafe)
  Await([&] { return requesters.back() != process; });
  EXPECT_EQ(requesters.back(), "alice@desk");
  harness_.node().RunOnLoop([&] { feedback.reset(); });
}

TEST_F(APlainSkillClient, CancelsASkill) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const std::string output = Run(tasks, {"wait", "duration_s", "9999", "cancel"});
  EXPECT_THAT(output, HasSubstr("cancel: code 0\n"));
  EXPECT_THAT(output, HasSubstr("result of status 5: false cancelled: by its client"));
}

TEST_F(APlainSkillClient, GetsTheReasonOfARefusal) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  EXPECT_THAT(Run(tasks, {"wait", "duration", "1"}),
              HasSubstr("result of status 6: false wait: there is no parameter duration; did you "
                        "mean 'duration_s'?"));
}

TEST_F(ASkillActuator, ReportsAFailureAsAFailure) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("fail");
  AwaitAccepted(sent);
  harness_.Tick(tasks, 2);
  EXPECT_EQ(EndOf(sent), "aborted false failed: no path (0%)");
}

TEST_F(ASkillActuator, RefusesWhatItCannotStartWithTheReason) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  EXPECT_EQ(EndOf(Send("wiat")),
            "aborted false there is no skill 'wiat'; did you mean 'wait'? There are fail and wait");
  EXPECT_THAT(EndOf(Send("wait", {{"duration", "1"}})), HasSubstr("did you mean 'duration_s'?"));
  EXPECT_THAT(EndOf(SendGoal({})), HasRefusal(ApplicationRefusal::kNotOneSkill));
  const auto first = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(first);
  EXPECT_EQ(EndOf(Send("wait")), "aborted false wait is running already");
  EXPECT_EQ(tasks.StateOf("wait"), "WAITING");
  ASSERT_TRUE(Go("Protected"));
  EXPECT_THAT(EndOf(Send("fail")), HasRefusal(ApplicationRefusal::kRunsNoSkills));
}

TEST_F(ASkillActuator, RefusesAGoalOfAnotherRobot) {
  ActuatorRunner<Tasks> tasks({.rate_hz = 50, .robot = "robot_0"});
  Begin(tasks);
  msg::SkillExecution::Goal goal;
  goal.skill_request.robot_id = "robot_7";
  goal.skill_request.skill_list.resize(1);
  goal.skill_request.skill_list[0].skill = "fail";
  EXPECT_THAT(EndOf(SendGoal(goal)), HasRefusal(ApplicationRefusal::kOtherRobot));
  goal.skill_request.robot_id = "robot_0";
  AwaitAccepted(SendGoal(goal));
}

TEST_F(ASkillActuator, CancelsTheSkillOfAGoal) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 1);
  bool replied = false;
  harness_.node().RunOnLoop([&] {
    client_->Cancel(sent->id, std::chrono::seconds(120), [&](const auto&) { replied = true; });
  });
  Await([&] { return replied; });
  harness_.Tick(tasks, 2);
  EXPECT_EQ(EndOf(sent), "canceled false cancelled: by its client (0%)");
}

TEST_F(ASkillActuator, PausesItsSkillsInLowPowerAndContinuesThem) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "0.1"}});
  AwaitAccepted(sent);
  harness_.Tick(tasks, 2);
  for (const BuiltInState state : {kProtected, kDeActive, kLowPower}) {
    const int pauses = tasks.Of([](Tasks& t) { return t.pauses; });
    tasks.RunOnLoop([&] { tasks.throws_when_paused = state == "DeActive"; });
    ASSERT_TRUE(Go(state));
    EXPECT_EQ(tasks.Of([](Tasks& t) { return t.pauses; }), pauses + 1) << state;
    harness_.Advance(tasks, std::chrono::hours(1));
    EXPECT_EQ(tasks.StateOf("wait"), "WAITING") << state;
    Await([&] { return sent->feedback.back().starts_with("processing: paused"); });
    ASSERT_TRUE(Go("Active"));
  }
  harness_.Tick(tasks, 8);
  EXPECT_THAT(EndOf(sent), HasSubstr("succeeded true"));
}

TEST_F(ASkillActuator, CancelsItsSkillsInOtaAndErrorAndWithThatOptionInLowPower) {
  for (const BuiltInState state : {kOta, kError, kLowPower}) {
    Harness harness;
    ActuatorRunner<Tasks> tasks(
        SkillActuator::Options{.rate_hz = 50, .cancels_when_paused = state == "LowPower"});
    harness.Open(tasks);
    ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    ASSERT_TRUE(tasks.Of([](Tasks& t) { return t.manager().Start("wait").ok(); }));
    ASSERT_TRUE(harness.controller().Switch(state).done());
    EXPECT_EQ(tasks.StateOf("wait"), "CANCELLED") << state;
  }
}

TEST_F(ASkillActuator, CancelsItsSkillsAtOnceByAnEmergencyStop) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  harness_.PressEmergencyStop();
  EXPECT_EQ(EndOf(sent), "aborted false cancelled: emergency stop (0%)");
  EXPECT_FALSE(tasks.Of([](Tasks& t) { return t.ticking(); }));
}

TEST_F(ASkillActuator, DoesNotConfirmAnEmergencyStopAtWhichTheEndOfASkillThrows) {
  ActuatorRunner<Tasks> tasks;
  tasks.grips = true;
  Begin(tasks);
  const auto sent = Send("grip");
  AwaitAccepted(sent);
  harness_.PressEmergencyStop();
  EXPECT_TRUE(harness_.AwaitStop("grip: OnEnd: the hand does not reply"));
  EXPECT_EQ(EndOf(sent), "aborted false cancelled: emergency stop (0%)");
}

TEST_F(ASkillActuator, CancelsItsSkillsWhenAHookThrows) {
  ActuatorRunner<Tasks> tasks;
  Begin(tasks);
  const auto sent = Send("wait", {{"duration_s", "9"}});
  AwaitAccepted(sent);
  tasks.RunOnLoop([&] { tasks.throws = "no camera"; });
  harness_.Tick(tasks, 1);
  EXPECT_EQ(EndOf(sent), "aborted false cancelled: BeforeTick: no camera (0%)");
}

TEST_F(ASkillActuator, FailsItsSetUpWithoutASkill) {
  ActuatorRunner<Tasks> tasks;
  tasks.registers = false;
  ASSERT_TRUE(tasks.Init(harness_.path()).ok());
  EXPECT_THAT(tasks.Start().error().message, HasSubstr("has not added a skill"));
}

}  // namespace musher::skill_actuator_test
