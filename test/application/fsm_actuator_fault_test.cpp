// Faults of the base class of applications that were found and fixed.

#include <algorithm>
#include <future>

#include "musher/behavior/fsm/nested.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::fsm_actuator_fault_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Show;

class AFaultyFsmActuator : public testing::WithHarness {
 protected:
  // The log of the actuator meanwhile.
  static std::string Logged(const std::function<void()>& work) {
    ::testing::internal::CaptureStderr();
    work();
    return ::testing::internal::GetCapturedStderr();
  }
};

TEST_F(AFaultyFsmActuator, FailsToBecomeActiveWhenItsResumeThrows) {
  ActuatorRunner<Show> show;
  show.data().throws = {{"resumes", "no"}};
  harness_.Open(show);
  ASSERT_TRUE(harness_.controller().Switch("SelfCheck").done());
  const SwitchResult result = harness_.controller().Switch("Active");
  ASSERT_EQ(result.actuators.size(), 1U);
  EXPECT_THAT(result.actuators[0].message, HasSubstr("OnResume: no"));
  EXPECT_EQ(show.TakeLog().back(), "pauses");
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
}

TEST_F(AFaultyFsmActuator, EndsTheProgramByAFaultAlsoOfAMachineWithoutHistory) {
  ActuatorRunner<Show> show({.machine = {.history = 0}});
  show.data().throws = {{"GREET runs", "no"}, {"STOP enters", "no, neither"}};
  Begin(show);
  harness_.Tick(show, 2);
  auto ended = std::async(std::launch::async, [&] { return show.Wait(); });
  const bool in_time = ended.wait_for(std::chrono::seconds(120)) == std::future_status::ready;
  show.Shutdown();
  EXPECT_TRUE(in_time);
  EXPECT_EQ(ended.get(), 1);
}

TEST_F(AFaultyFsmActuator, RunsItsSafeStateWhileTheHookBeforeTheTickThrows) {
  ActuatorRunner<Show> show;
  Begin(show);
  show.RunOnLoop([&] { show.data().throws["before"] = "the camera is gone"; });
  for (int i = 0; i < 20; ++i) {
    harness_.Tick(show, 1);
    EXPECT_EQ(show.Path(), "STOP") << i;
  }
  EXPECT_EQ(show.Ticks(), 20U);
  EXPECT_GT(show.Of([](Show& s) { return s.data().runs["STOP"]; }), 10);
  EXPECT_EQ(show.Of([](Show& s) { return s.data().runs["GREET"]; }), 0);
}

TEST_F(AFaultyFsmActuator, LogsAFaultOfAHookOnceAndAgainWhenItComesBack) {
  ActuatorRunner<Show> show;
  Begin(show);
  for (const std::string hook : {"before", "after"}) {
    for (int i = 0; i < 3; ++i) {
      const std::string log = Logged([&] {
        show.RunOnLoop([&] { show.data().throws[hook] = "the camera is gone"; });
        harness_.Tick(show, 3);
        show.RunOnLoop([&] { show.data().throws.clear(); });
        harness_.Tick(show, 1);
      });
      const auto first = log.find("the camera is gone");
      ASSERT_NE(first, std::string::npos) << hook << " " << i;
      EXPECT_EQ(log.find("the camera is gone", first + 1), std::string::npos) << log;
    }
  }
}

TEST_F(AFaultyFsmActuator, LogsAnUnhandledCommandRateLimited) {
  ActuatorRunner<Show> show;
  Begin(show);
  show.RunOnLoop([&] { show.data().unsafe = true; });
  harness_.Tick(show, 1);
  const auto log = Logged([&] {
    for (int i = 0; i < 40; ++i) {
      show.RunOnLoop([&] { EXPECT_TRUE(show.machine().Send("again")); });
      harness_.Tick(show, 1);
    }
  });
  EXPECT_THAT(log, HasSubstr("command again is not handled in STOP"));
  EXPECT_EQ(show.Of([](Show& s) { return s.machine().counts().unhandled; }), 40U);
  EXPECT_LE(std::count(log.begin(), log.end(), '\n'), 23) << "in 0.8 s";
}

TEST_F(AFaultyFsmActuator, QueuesNoCommandFromATopicWhileItIsPaused) {
  ActuatorRunner<Show> show;
  Begin(show);
  harness_.Tick(show, 6);
  ASSERT_TRUE(harness_.controller().Switch("LowPower").done());
  show.RunOnLoop([&] {
    const Result<> sent = show.Send("again");
    ASSERT_FALSE(sent);
    EXPECT_EQ(sent.error(), Refused<ApplicationRefusal::kPaused>("show", "LowPower"));
  });
  ASSERT_TRUE(harness_.controller().Switch("Active").done());
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "PLAY");
  show.RunOnLoop([&] { EXPECT_TRUE(show.Send("again")); });
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "GREET");
}

// Its hooks would use what SetUp is just building, on another thread.
TEST_F(AFaultyFsmActuator, IsNotPausedByAnEmergencyStopWhileItIsSetUp) {
  class Early : public FsmActuator {
   public:
    Early() : FsmActuator("show") {}
    bool stop_seen = false;
    bool paused_early = false;

   private:
    Result<> BuildMachine(fsm::Machine& machine) override {
      testing::Until([this] { return EmergencyStopped(); });
      RunOnLoop([this] { paused_early = paused_; });
      stop_seen = EmergencyStopped();
      machine.Add("A", std::make_unique<fsm::State>());
      return machine.Build("A");
    }
    void OnPause() override { paused_ = true; }

    bool paused_ = false;
  };
  harness_.PressEmergencyStop();
  ActuatorRunner<Early> show;
  ASSERT_TRUE(show.Prepare(harness_.path()).ok());
  EXPECT_TRUE(show.Start().ok());
  EXPECT_TRUE(show.stop_seen);
  EXPECT_FALSE(show.paused_early);
}

TEST_F(AFaultyFsmActuator, LogsAFaultOfTearDownOnce) {
  ActuatorRunner<Show> show;
  Begin(show);
  show.RunOnLoop([&] { show.data().throws["GREET leaves"] = "no hinge"; });
  const std::string log =
      Logged([&] { EXPECT_TRUE(harness_.controller().Switch("TearDown").done()); });
  const auto first = log.find("no hinge");
  ASSERT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("no hinge", first + 1), std::string::npos) << log;
}

// A state that holds a machine, and one that does not.
class Nest : public FsmActuator {
 public:
  Nest() : FsmActuator("show") {}
  void Force(std::string_view state) {
    RunOnLoop([&] { EXPECT_TRUE(machine().Force(state)); });
  }

 private:
  class Idle : public fsm::State {
    void Declare(fsm::Transitions& transitions) override { transitions.To("SHOW", "never"); }
  };
  class Scenes : public fsm::Nested {
   public:
    using Nested::Nested;
    void Declare(fsm::Transitions& transitions) override {
      Nested::Declare(transitions);
      transitions.To("IDLE", "never");
    }
  };
  Result<> BuildMachine(fsm::Machine& machine) override {
    auto inner = std::make_unique<fsm::Machine>(fsm::Machine::Options{.name = "scenes"});
    inner->Add("A", std::make_unique<fsm::State>());
    machine.Add("IDLE", std::make_unique<Idle>());
    machine.Add("SHOW", std::make_unique<Scenes>(std::move(inner), "A"));
    return machine.Build("IDLE");
  }
};

TEST_F(AFaultyFsmActuator, PublishesTheWholePathOfAForcedStateWhileItIsPaused) {
  ActuatorRunner<Nest> show;
  ASSERT_TRUE(show.Prepare(harness_.path()).ok());
  ASSERT_TRUE(show.Start().ok());
  ASSERT_TRUE(harness_.controller().Init(harness_.path()).ok());
  ASSERT_TRUE(harness_.controller().AwaitSetUp().ok());
  for (const BuiltInState state : {kSelfCheck, kActive, kLowPower}) {
    ASSERT_TRUE(harness_.controller().Switch(state).done()) << state;
  }
  std::vector<std::string> published;
  std::unique_ptr<transport::Subscription> topic;
  const auto await = [&](const std::string& path) {
    testing::Until([&] {
      bool there = false;
      harness_.node().RunOnLoop([&] { there = !published.empty() && published.back() == path; });
      return there;
    });
  };
  harness_.node().RunOnLoop([&] {
    topic = transport::MakeSubscription<msg::String>(
                harness_.node().node(), "show/behavior_state",
                [&](const msg::String& state, const auto&) { published.push_back(state.data); },
                transport::kLatchedQos)
                .value();
  });
  await("IDLE");
  show.Force("SHOW");
  await("SHOW/A");
  harness_.node().RunOnLoop([&] { topic.reset(); });
  EXPECT_THAT(published, ElementsAre("IDLE", "SHOW/A"));
}

}  // namespace musher::fsm_actuator_fault_test
