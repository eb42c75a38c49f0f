// An application as an actuator: when its machine is ticked, paused and ended, and how its
// exceptions are handled.

#include <future>

#include "musher/messages/musher_msgs/behavior.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/application/suspended_thread.hpp"
#include "musher/test/support/refusals.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::fsm_actuator_test {

using ::testing::ElementsAre;
using testing::Harness;
using ::testing::HasSubstr;
using testing::Show;

class AnFsmActuator : public testing::WithHarness {
 protected:
  bool Go(const State& state) { return harness_.controller().Switch(state).done(); }
  // By its service; "": it is not refused.
  std::string WhyRefused(const std::string& command) {
    std::unique_ptr<transport::Client<msg::SendCommand>> client;
    std::optional<std::string> reply;
    harness_.node().RunOnLoop([&] {
      client = transport::MakeClient<msg::SendCommand>(harness_.node().node(), "show/send_command")
                   .value();
      client->Call({command}, std::chrono::seconds(120), [&](const auto& answer) {
        reply = answer ? answer.value().message : answer.error().message;
      });
    });
    EXPECT_TRUE(testing::Until([&] {
      bool done = false;
      harness_.node().RunOnLoop([&] { done = reply.has_value(); });
      return done;
    }));
    harness_.node().RunOnLoop([&] { client.reset(); });
    return reply.value_or("no reply");
  }
};

TEST_F(AnFsmActuator, TicksItsMachineAtItsRateOfTheWorldsTimeWhileItIsActive) {
  ActuatorRunner<Show> show({.rate_hz = 50});
  harness_.Open(show);
  harness_.Tick(show, 3);
  EXPECT_EQ(show.Path(), "") << "not before";
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  EXPECT_EQ(show.Path(), "GREET");
  EXPECT_EQ(show.Ticks(), 0U);
  harness_.Tick(show, 4);
  EXPECT_EQ(show.Ticks(), 4U);
  EXPECT_EQ(show.Path(), "GREET");
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "PLAY") << "after 100 ms";
  EXPECT_THAT(show.TakeLog(),
              ElementsAre("resumes", "GREET enters", "GREET leaves", "PLAY enters"));
}

TEST_F(AnFsmActuator, TakesAStartThatFailsAsNotGiven) {
  ActuatorRunner<Show> show({.rate_hz = 50, .begin = musher::Begin::kOnCommand});
  harness_.Open(show);
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  show.RunOnLoop([&] { show.data().throws["resumes"] = "no curtain"; });
  EXPECT_FALSE(show.Of([](Show& s) { return s.Send("START"); }));
  EXPECT_THAT(show.TakeLog(), ElementsAre("resumes", "pauses")) << "its outputs are neutral";
  show.RunOnLoop([&] { show.data().throws.clear(); });
  ASSERT_TRUE(Go("Protected"));
  ASSERT_TRUE(Go("Active"));
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); })) << "nothing begins by itself";
  EXPECT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
  EXPECT_EQ(show.Path(), "GREET");
}

TEST_F(AnFsmActuator, WaitsForStartWhereItsMachineWasStoppedInAPause) {
  ActuatorRunner<Show> show({.rate_hz = 50});
  Begin(show);
  ASSERT_TRUE(Go("LowPower"));
  show.RunOnLoop([&] { ASSERT_TRUE(show.machine().Stop()); });
  ASSERT_TRUE(Go("Active"));
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); })) << "nothing begins by itself";
  EXPECT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
  EXPECT_EQ(show.Path(), "GREET");
}

// A show played on by itself when the computer was opened an hour later.
TEST_F(AnFsmActuator, BeginsAtItsStartAfterALongSuspension) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Show> show({.rate_hz = 50});
  harness_.Open(show, thread);
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(show, 6);
  ASSERT_EQ(show.Path(), "PLAY");
  thread->Suspend(std::chrono::seconds(50));
  harness_.Tick(show, 1);
  ASSERT_EQ(show.Path(), "PLAY") << "less than a minute";
  show.TakeLog();
  thread->Suspend(std::chrono::minutes(2));
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "GREET");
  EXPECT_THAT(show.TakeLog(), ElementsAre("PLAY leaves", "pauses", "resumes", "GREET enters"));
  EXPECT_TRUE(show.Of([](Show& s) { return s.ticking(); }));
}

TEST_F(AnFsmActuator, WaitsForStartAfterALongSuspensionInAPause) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Show> show({.rate_hz = 50, .begin = musher::Begin::kOnCommand});
  harness_.Open(show, thread);
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  ASSERT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
  ASSERT_TRUE(Go("LowPower"));
  thread->Suspend(std::chrono::minutes(2));
  ASSERT_TRUE(Go("Active"));
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); })) << "nothing begins by itself";
  EXPECT_EQ(show.Path(), "");
}

// A door opened by a command that had waited in the kernel while the computer was suspended.
TEST_F(AnFsmActuator, RefusesACommandThatMayBeLate) {
  const auto thread = std::make_shared<testing::SuspendedThread>();
  ActuatorRunner<Show> show({.rate_hz = 50});
  harness_.Open(show, thread);
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(show, 6);
  ASSERT_EQ(show.Path(), "PLAY");
  thread->SuspendEachTime(std::chrono::seconds(9));
  EXPECT_THAT(WhyRefused("again"), testing::HasRefusal(ApplicationRefusal::kMayBeLate));
  thread->SuspendEachTime({});
}

TEST_F(AnFsmActuator, StampsWithTheTimeOfItsMachine) {
  ActuatorRunner<Show> show;
  harness_.Open(show);
  const auto stamp = show.Of([](Show& s) { return s.Stamp(); });
  EXPECT_EQ(msg::FromStamp(stamp), show.Of([](Show& s) { return s.Now(); }).time_since_epoch());
}

// A callback of its own would replace the one that pauses the machine.
template <class Actuator>
concept TakesStateCallbacks = requires(Actuator& actuator) {
  actuator.RegisterStateCallback("LowPower", [] { return kCodeOk; });
};

static_assert(TakesStateCallbacks<MachineActuator>);
static_assert(!TakesStateCallbacks<Show>);

TEST_F(AnFsmActuator, IsPausedInEveryOtherStateAndResumesInItsState) {
  ActuatorRunner<Show> show;
  Begin(show);
  harness_.Tick(show, 3);
  for (const BuiltInState state : {kProtected, kDeActive, kLowPower, kOta}) {
    show.TakeLog();
    ASSERT_TRUE(Go(state)) << state;
    EXPECT_THAT(show.TakeLog(), ElementsAre("pauses")) << state;
    const std::uint64_t ticks = show.Ticks();
    harness_.Advance(show, std::chrono::hours(1));
    EXPECT_EQ(show.Ticks(), ticks) << state;
    ASSERT_TRUE(Go("Active"));
    EXPECT_THAT(show.TakeLog(), ElementsAre("resumes")) << state;
    harness_.Tick(show, 1);
    EXPECT_EQ(show.Ticks(), ticks + 1);
    EXPECT_EQ(show.Path(), "GREET") << "the hour does not count";
  }
  EXPECT_EQ(show.Of([](Show& s) { return s.machine().time(); }), Milliseconds(60));
}

// It was handled after the pause, which may have lasted hours.
TEST_F(AnFsmActuator, DropsACommandThatIsQueuedWhenItIsPaused) {
  ActuatorRunner<Show> show;
  Begin(show);
  harness_.Tick(show, 5);
  ASSERT_EQ(show.Path(), "PLAY");
  EXPECT_TRUE(show.Of([](Show& s) { return s.Send("again"); }));
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(show, 3);
  EXPECT_EQ(show.Path(), "PLAY");
}

TEST_F(AnFsmActuator, StartsFromTheBeginningWithThatOption) {
  ActuatorRunner<Show> show({.resume = FsmActuator::Resume::kFromStart});
  Begin(show);
  harness_.Tick(show, 5);
  ASSERT_EQ(show.Path(), "PLAY");
  ASSERT_TRUE(Go("LowPower"));
  EXPECT_EQ(show.Path(), "PLAY");
  ASSERT_TRUE(Go("Active"));
  EXPECT_EQ(show.Path(), "GREET");
}

TEST_F(AnFsmActuator, LeavesItsStateAtTearDown) {
  ActuatorRunner<Show> show;
  Begin(show);
  show.TakeLog();
  ASSERT_TRUE(Go("TearDown"));
  EXPECT_EQ(show.Wait(), 0);
  EXPECT_THAT(show.TakeLog(), ElementsAre("GREET leaves", "pauses"));
  EXPECT_EQ(show.Path(), "");
}

TEST_F(AnFsmActuator, IsPausedByAnEmergencyStopUntilActiveIsSetAgainAfterTheRelease) {
  ActuatorRunner<Show> show;
  Begin(show);
  harness_.PressEmergencyStop();
  ASSERT_TRUE(testing::Until([&] { return !show.Of([](Show& s) { return s.ticking(); }); }));
  EXPECT_EQ(show.TakeLog().back(), "pauses");
  std::unique_ptr<transport::Client<msg::ReleaseEmergencyStop>> release;
  std::promise<Result<msg::ReleaseEmergencyStop::Response>> released;
  harness_.node().RunOnLoop([&] {
    release = transport::MakeClient<msg::ReleaseEmergencyStop>(
                  harness_.node().node(), transport::MachineService("", "release_emergency_stop"))
                  .value();
    release->Call({"a test"}, std::chrono::seconds(120),
                  [&](auto answer) { released.set_value(std::move(answer)); });
  });
  const auto answer = released.get_future().get();
  ASSERT_TRUE(answer && answer.value().code == kCodeOk);
  harness_.Tick(show, 2);
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); })) << "the release moves nothing";
  const auto sent = show.Of([](Show& s) { return s.Send("go"); });
  ASSERT_FALSE(sent);
  EXPECT_NE(sent.error().message.find("held by the emergency stop"), std::string::npos);
  ASSERT_TRUE(Go("Active"));
  EXPECT_TRUE(show.Of([](Show& s) { return s.ticking(); }));
  harness_.node().RunOnLoop([&] { release.reset(); });
}

TEST_F(AnFsmActuator, StandsInActiveUntilItIsCommandedWithThatOption) {
  ActuatorRunner<Show> show({.rate_hz = 50, .begin = musher::Begin::kOnCommand});
  Begin(show);
  harness_.Tick(show, 3);
  EXPECT_THAT(show.TakeLog(), ElementsAre());
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
  const auto early = show.Of([](Show& s) { return s.Send("again"); });
  ASSERT_FALSE(early);
  EXPECT_THAT(early.error(), testing::IsRefused(ApplicationRefusal::kWaitsForStart));
  ASSERT_TRUE(Go("LowPower"));
  EXPECT_FALSE(show.Of([](Show& s) { return s.Send("START"); })) << "in Active only";
  ASSERT_TRUE(Go("Active"));
  EXPECT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "GREET");
  ASSERT_TRUE(Go("LowPower"));
  ASSERT_TRUE(Go("Active"));
  EXPECT_TRUE(show.Of([](Show& s) { return s.ticking(); })) << "a pause is no restart";
}

TEST_F(AnFsmActuator, FailsItsSelfCheckWithTheReasonOfTheApplication) {
  ActuatorRunner<Show> show;
  show.data().unsafe = true;
  harness_.Open(show);
  const SwitchResult checked = harness_.controller().Switch("SelfCheck");
  ASSERT_EQ(checked.actuators.size(), 1U);
  EXPECT_EQ(checked.actuators[0].code, 5109);
}

TEST_F(AnFsmActuator, FailsItsSetUpWithEveryFaultOfItsMachine) {
  class Faulty : public FsmActuator {
   public:
    Faulty() : FsmActuator("show") {}
    Result<> BuildMachine(fsm::Machine& machine) override { return machine.Build("NOWHERE"); }
  };
  ActuatorRunner<Faulty> show;
  ASSERT_TRUE(show.Prepare(harness_.path()).ok());
  const Result<> started = show.Start();
  ASSERT_FALSE(started.ok());
  EXPECT_THAT(started.error().message, HasSubstr("no states are registered"));
}

TEST_F(AnFsmActuator, FailsItsSetUpWhenTheMachineIsNotBuilt) {
  class Empty : public FsmActuator {
   public:
    Empty() : FsmActuator("show") {}
    Result<> BuildMachine(fsm::Machine& /*machine*/) override { return Ok(); }
  };
  ActuatorRunner<Empty> show;
  ASSERT_TRUE(show.Prepare(harness_.path()).ok());
  EXPECT_THAT(show.Start().error().message, HasSubstr("Build()"));
}

TEST_F(AnFsmActuator, GoesToItsSafeStateWhenAHookAroundTheTickThrowsAndOutOfItAfter) {
  for (const std::string hook : {"before", "after"}) {
    Harness harness;
    ActuatorRunner<Show> show;
    harness.Open(show);
    ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    show.RunOnLoop([&] { show.data().throws[hook] = "the camera is gone"; });
    harness.Tick(show, 10);
    EXPECT_EQ(show.Path(), "STOP") << hook << ": for as long as it throws";
    show.RunOnLoop([&] { show.data().throws.clear(); });
    harness.Tick(show, 10);
    EXPECT_NE(show.Path(), "STOP") << hook;
  }
}

TEST_F(AnFsmActuator, EndsTheProgramWhenItsMachineStopsByAFault) {
  ActuatorRunner<Show> show;
  show.data().throws = {{"GREET runs", "no"}, {"STOP enters", "no, neither"}};
  Begin(show);
  harness_.Tick(show, 2);
  EXPECT_EQ(show.Wait(), 1);
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
  EXPECT_EQ(show.TakeLog().back(), "pauses");
}

TEST_F(AnFsmActuator, EndsTheProgramWhenAHookThrowsAndThereIsNoSafeState) {
  ActuatorRunner<Show> show;
  show.data().safe_state = false;
  Begin(show);
  show.RunOnLoop([&] { show.data().throws["before"] = "no"; });
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Wait(), 1);
}

// It has ended by itself: a pause, which may be an emergency stop, does not begin it again.
TEST_F(AnFsmActuator, WaitsForStartOnceItsApplicationHasStoppedTheMachine) {
  for (const musher::Begin begin : {musher::Begin::kAtActive, musher::Begin::kOnCommand}) {
    Harness harness;
    ActuatorRunner<Show> show({.rate_hz = 50, .begin = begin});
    harness.Open(show);
    ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    if (begin == musher::Begin::kOnCommand) {
      ASSERT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
    }
    const auto end = [&] {
      show.RunOnLoop([&] { show.data().left_early = true; });
      harness.Tick(show, 2);
      EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
      show.RunOnLoop([&] { show.data().left_early = false; });
    };
    end();
    ASSERT_TRUE(harness.controller().Switch("Protected").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    harness.Tick(show, 2);
    EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); })) << "nothing begins by itself";
    const auto sent = show.Of([](Show& s) { return s.Send("again"); });
    ASSERT_FALSE(sent);
    EXPECT_THAT(sent.error(), testing::IsRefused(ApplicationRefusal::kWaitsForStart));
    EXPECT_TRUE(show.Of([](Show& s) { return s.Send("START"); }));
    EXPECT_EQ(show.Path(), "GREET");
    end();
    EXPECT_TRUE(show.Of([](Show& s) { return s.Send("START"); })) << "also without a pause";
    EXPECT_EQ(show.Path(), "GREET");
    ASSERT_TRUE(harness.controller().Switch("Protected").done());
    ASSERT_TRUE(harness.controller().Switch("Active").done());
    EXPECT_TRUE(show.Of([](Show& s) { return s.ticking(); })) << "it has not ended again";
  }
}

TEST_F(AnFsmActuator, FailsToBecomeActiveWhenItsMachineStopsAsItBegins) {
  ActuatorRunner<Show> show;
  show.data().throws = {{"GREET enters", "no"}, {"STOP enters", "no, neither"}};
  harness_.Open(show);
  ASSERT_TRUE(Go("SelfCheck"));
  const SwitchResult result = harness_.controller().Switch("Active");
  ASSERT_EQ(result.actuators.size(), 1U);
  EXPECT_THAT(result.actuators[0].message, HasSubstr("STOP: OnEnter: no, neither"));
}

TEST_F(AnFsmActuator, ContinuesInItsSafeStateWhenOnlyTheStartStateFails) {
  ActuatorRunner<Show> show;
  show.data().throws = {{"GREET enters", "no"}};
  Begin(show);
  EXPECT_EQ(show.Path(), "STOP");
  EXPECT_TRUE(show.Of([](Show& s) { return s.ticking(); }));
}

TEST_F(AnFsmActuator, SurvivesAPauseThatThrows) {
  ActuatorRunner<Show> show;
  show.data().throws = {{"pauses", "no"}};
  Begin(show);
  EXPECT_TRUE(Go("Protected"));
  EXPECT_FALSE(show.Of([](Show& s) { return s.ticking(); }));
}

TEST_F(AnFsmActuator, ContinuesWhenTheWorldIsRestarted) {
  ActuatorRunner<Show> show;
  Begin(show);
  harness_.Tick(show, 3);
  harness_.Advance(show, -std::chrono::seconds(900));
  harness_.Tick(show, 1);
  EXPECT_EQ(show.Path(), "GREET") << "time that runs back is no time";
  harness_.Tick(show, 3);
  EXPECT_EQ(show.Path(), "PLAY");
}

TEST_F(AnFsmActuator, DoesNotUseTheFirstClockSampleAsTheLengthOfATick) {
  ActuatorRunner<Show> show;
  ASSERT_TRUE(show.Prepare(harness_.path()).ok());
  ASSERT_TRUE(show.Start().ok());
  ASSERT_TRUE(harness_.controller().Init(harness_.path()).ok());
  ASSERT_TRUE(harness_.controller().AwaitSetUp().ok());
  ASSERT_TRUE(Go("SelfCheck"));
  ASSERT_TRUE(Go("Active"));
  harness_.Tick(show, 4);
  EXPECT_EQ(show.Path(), "GREET") << "1000 s are not 100 ms of it";
}

}  // namespace musher::fsm_actuator_test
