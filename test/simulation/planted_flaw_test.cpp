// The invariants can be violated: each test plants a flaw in a simulated robot, and the checker
// must report it.

#include <gmock/gmock.h>

#include <algorithm>
#include <optional>
#include <string>

#include "musher/simulation/checker.hpp"
#include "musher/test/lifecycle/coordination/harness.hpp"
#include "musher/transport/service.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher::testing::planted_flaw_test {

using simulation::Act;
using simulation::Invariant;
using simulation::Layout;
using simulation::SimRobot;
using simulation::Starter;
using ::testing::HasSubstr;

class PlantedFlaw : public ::testing::Test {
 protected:
  static MachineConfig Started(int actuators) {
    MachineConfig config = MachineOf(actuators);
    for (ActuatorConfig& actuator : config.actuators) actuator.command = {"run", actuator.name};
    return config;
  }
  static MachineConfig Restarted(int actuators) {
    MachineConfig config = Started(actuators);
    for (ActuatorConfig& actuator : config.actuators) {
      actuator.restart.policy = RestartPolicy::kOnFailure;
    }
    return config;
  }
  // Each callback has 30 s.
  static MachineConfig WithLongTimes(MachineConfig config) {
    for (ActuatorConfig& actuator : config.actuators) {
      std::fill(actuator.times.begin(), actuator.times.end(), Duration(std::chrono::seconds(30)));
    }
    return config;
  }
  static Layout TwoHosts(std::size_t actuators) {
    Layout layout;
    layout.hosts = {"robot", "dock"};
    layout.host_of = PerActuator<std::size_t>(actuators, 0);
    layout.controllers = {0, 1};
    return layout;
  }

  void Make(MachineConfig config, Layout layout = {}) {
    robot_.emplace(
        1, std::move(config),
        [this](const std::string&, const State& state) {
          return state == slow_ ? Act{std::chrono::seconds(20)} : Act{};
        },
        std::move(layout));
    checker_.emplace(*robot_);
  }
  // Until `done`; the invariants are checked after every event.
  bool RunUntil(const std::function<bool()>& done, Duration limit) {
    return robot_->RunUntil(
        [&] {
          checker_->AfterEvent();
          return done();
        },
        limit);
  }
  void RunFor(Duration duration) {
    RunUntil([] { return false; }, duration);
  }
  void BringUp() {
    robot_->StartController();
    ASSERT_TRUE(RunUntil([&] { return robot_->machine().phase == Phase::kRunning; },
                         std::chrono::seconds(10)));
  }
  // Requests it without waiting.
  void Request(const State& target) {
    robot_->leader()->shell().SetState(target, std::nullopt, [](const SwitchResult&) {});
  }
  ActuatorCore& CoreOf(const std::string& name) {
    return const_cast<ActuatorCore&>(*robot_->processes().CoreOf(name, 0));
  }
  void ExpectFound(Invariant invariant, const std::string& what) {
    ASSERT_TRUE(checker_->violation());
    EXPECT_EQ(checker_->violation()->invariant, invariant) << checker_->violation()->what;
    EXPECT_THAT(checker_->violation()->what, HasSubstr(what));
  }
  void ExpectNone() { EXPECT_FALSE(checker_->violation()) << checker_->violation()->what; }
  Machine& machine() { return const_cast<Machine&>(robot_->machine()); }

  void BringUpOverLan(int actuators) {
    MachineConfig config = Started(actuators);
    config.transport = TransportProfile::kLan;
    Make(std::move(config));
    ASSERT_NO_FATAL_FAILURE(BringUp());
  }
  void SetThroughSelfCheck() {
    ASSERT_TRUE(robot_->Set(State(kSelfCheck))->done());
    ASSERT_TRUE(robot_->Set(State(kActive))->done());
  }
  // The link between hosts 0 and 1.
  void SetLinkOfHosts(bool up) {
    robot_->hosts().SetHostBlocked(0, 1, !up);
    robot_->hosts().SetHostBlocked(1, 0, !up);
  }
  void Stop() {
    checker_->OnStopEngaged(0, 7);
    robot_->EngageEmergencyStop(7);
    RunFor(std::chrono::seconds(1));
  }
  // Stops it while the callback of Active runs.
  void StopDuringActiveOfTheStart() {
    robot_->StartController();
    ASSERT_TRUE(RunUntil(
        [&] {
          const auto report = robot_->ReportOf("a");
          return report && report->target == kActive;
        },
        std::chrono::seconds(10)));
    robot_->EngageEmergencyStop(7);
  }
  void Release() {
    robot_->ReleaseEmergencyStop();
    RunFor(std::chrono::seconds(4));
  }
  void LoseStopOfA() {
    CoreOf("a").stops.clear();
    CoreOf("a").report.emergency_stop = 0;
  }
  // The controller takes what the stop has switched off for requested again.
  void ForgetTheStop() {
    for (KnownActuator& known : machine().actuators) known.set_again = true;
  }
  void ExpectFoundAfterForgettingTheFolder() {
    machine().emergency.unread.clear();
    RunFor(std::chrono::seconds(5));
    ExpectFound(Invariant::kNoUnrequestedActivation, "a start begins SelfCheck although");
  }

  State slow_;
  std::optional<SimRobot> robot_;
  std::optional<simulation::Checker> checker_;
};

TEST_F(PlantedFlaw, FindsAControllerThatStartsAnActuatorOfAnotherHostWithoutListening) {
  Make(Started(1), TwoHosts(1));
  robot_->processes().Launch("a", 1);
  RunFor(std::chrono::seconds(3));
  robot_->StartController();  // at once
  RunFor(std::chrono::seconds(1));
  ExpectFound(Invariant::kNoDuplicateActuator, "starts a, which runs on host dock");
}

TEST_F(PlantedFlaw, FindsAReleaseThatWasNotStoredAndIsUndoneByItsPanelAfterARestart) {
  Make(Started(2));
  BringUp();
  Stop();
  robot_->ReleaseEmergencyStop();
  RunFor(std::chrono::seconds(1));
  checker_->CheckRest(false);
  ExpectNone();
  robot_->CrashController();
  robot_->disk(0).stops = {};
  BringUp();
  RunFor(std::chrono::seconds(1));
  checker_->CheckRest(false);
  ExpectFound(Invariant::kEmergencyStopLatched, "although all stops are released");
}

TEST_F(PlantedFlaw, FindsAnActuatorThatLosesALatchedStop) {
  Make(Started(1));
  BringUp();
  Stop();
  LoseStopOfA();
  checker_->CheckRest(false);
  ASSERT_TRUE(checker_->violation());
}

TEST_F(PlantedFlaw, FindsAReleaseThatIsReportedBeforeItsActuatorHasConfirmedIt) {
  Make(Started(1));
  BringUp();
  Stop();
  robot_->ReleaseEmergencyStop();
  ASSERT_TRUE(machine().emergency.release);
  machine().emergency.release->last = 0;
  machine().actuators[0].report.emergency_stop = 0;
  robot_->ReleaseEmergencyStop();  // the next step of the controller
  ExpectFound(Invariant::kReleaseIsConfirmed, "a has latched one of them");
}

TEST_F(PlantedFlaw, FindsAnActuatorThatDoesNotReportThatAStopHoldsIt) {
  Make(Started(1));
  BringUp();
  Stop();
  CoreOf("a").report.held_by_stop = false;
  robot_->ReleaseEmergencyStop();
  RunFor(std::chrono::seconds(1));
  ExpectFound(Invariant::kEmergencyStopReported, "a reports Active with its power off");
}

TEST_F(PlantedFlaw, FindsACallbackThatUndoesAnEmergencyStop) {
  slow_ = State(kActive);
  Make(Started(1));
  ASSERT_NO_FATAL_FAILURE(StopDuringActiveOfTheStart());
  RunFor(std::chrono::seconds(1));
  CoreOf("a").stopped_meanwhile = false;  // so that its end counts as it is
  RunFor(std::chrono::seconds(30));
  ExpectFound(Invariant::kEmergencyStopHolds, "although it has latched an emergency stop");
}

// A callback of the same rank, too, may switch on what the stop has switched off.
TEST_F(PlantedFlaw, FindsACallbackOfTheSameRankThatUndoesAnEmergencyStop) {
  slow_ = State("Dancing");
  Make(WithDancing(Started(1)));
  BringUp();
  Request(State("Dancing"));
  ASSERT_TRUE(RunUntil([&] { return robot_->ReportOf("a")->target == "Dancing"; },
                       std::chrono::seconds(1)));
  robot_->EngageEmergencyStop(7);
  RunFor(std::chrono::seconds(1));
  CoreOf("a").stopped_meanwhile = false;  // so that its end counts as it is
  RunFor(std::chrono::seconds(30));
  ExpectFound(Invariant::kEmergencyStopHolds, "although it has latched an emergency stop");
}

TEST_F(PlantedFlaw, FindsHardwareThatACallbackSwitchesOnDuringAStop) {
  slow_ = State(kActive);
  Make(Started(1));
  ASSERT_NO_FATAL_FAILURE(StopDuringActiveOfTheStart());
  // Its end has failed as it should, but the stop action does not run again.
  ASSERT_TRUE(RunUntil([&] { return robot_->ReportOf("a")->emergency_stop == 7; },
                       std::chrono::seconds(1)));
  robot_->RunUntil(
      [&] {
        if (robot_->processes().IsPowered("a", 0)) CoreOf("a").stopped_meanwhile = false;
        checker_->AfterEvent();
        return checker_->violation().has_value();
      },
      std::chrono::seconds(30));
  ASSERT_TRUE(checker_->violation());
  EXPECT_EQ(checker_->violation()->invariant, Invariant::kEmergencyStopHolds);
}

TEST_F(PlantedFlaw, FindsALostStopIntentThatBringsTheMachineUpAgain) {
  slow_ = State(kTearDown);
  Make(Restarted(2));
  BringUp();
  Request(State(kTearDown));
  RunFor(std::chrono::seconds(1));
  ASSERT_EQ(robot_->machine().phase, Phase::kStopping);
  robot_->CrashController();
  robot_->disk(0).stop_intent = false;
  for (const char* name : {"a", "b"}) robot_->CrashActuator(name);
  slow_ = {};
  robot_->LaunchController(0, true, {}, Starter::kSupervisor);
  RunFor(std::chrono::seconds(5));
  ExpectFound(Invariant::kNoStartAfterTearDown, "after an accepted TearDown");
}

// A process that was found ends while the start waits for another one.
TEST_F(PlantedFlaw, ARestartBySupervisorThatFinishesATearDownStartsNothing) {
  slow_ = State(kTearDown);
  MachineConfig config = WithLongTimes(Started(2));
  for (ActuatorConfig& actuator : config.actuators) {
    actuator.restart.policy = RestartPolicy::kOnFailure;
  }
  Make(std::move(config));
  BringUp();
  Request(State(kTearDown));
  RunFor(std::chrono::seconds(1));
  ASSERT_EQ(robot_->machine().phase, Phase::kStopping);
  robot_->CrashController();
  robot_->FreezeActuator("b");
  robot_->LaunchController(0, true, {}, Starter::kSupervisor);
  RunFor(Milliseconds(100));
  ASSERT_EQ(robot_->machine().phase, Phase::kStarting);
  robot_->CrashActuator("a");
  RunFor(std::chrono::seconds(20));
  ExpectNone();
  EXPECT_EQ(robot_->processes().PidOf("a", 0), 0);
}

TEST_F(PlantedFlaw, FindsATearDownReportedAsDoneWhileAnActuatorRuns) {
  Make(Started(2));
  BringUp();
  const std::uint64_t request = checker_->OnRequest(*robot_->leader(), State(kTearDown));
  SwitchResult done;
  done.target = State(kTearDown);
  done.outcome = SwitchOutcome::kDone;
  checker_->OnReply(request, done);
  ExpectFound(Invariant::kTearDownIsComplete, "a still runs in Active");
}

TEST_F(PlantedFlaw, FindsATearDownReportedAsDoneBesideAnActuatorThatHasEndedWithoutItsOwn) {
  MachineConfig config = Started(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.restart.policy = RestartPolicy::kNo;
  Make(std::move(config));
  BringUp();
  robot_->CrashActuator("b");
  RunFor(std::chrono::seconds(2));
  for (KnownActuator& known : machine().actuators) known.lost_in = {};  // forgets it
  const std::uint64_t request = checker_->OnRequest(*robot_->leader(), State(kTearDown));
  robot_->leader()->shell().SetState(
      State(kTearDown), std::nullopt,
      [&](const SwitchResult& result) { checker_->OnReply(request, result); });
  RunFor(std::chrono::seconds(5));
  ExpectFound(Invariant::kTearDownIsComplete, "b has ended in Active without its own");
}

TEST_F(PlantedFlaw, FindsAStopThatIsReportedBesideAnActuatorThatHasEndedWhileItWasOn) {
  MachineConfig config = Started(2);
  for (ActuatorConfig& actuator : config.actuators) actuator.restart.policy = RestartPolicy::kNo;
  Make(std::move(config));
  BringUp();
  robot_->CrashActuator("b");
  RunFor(std::chrono::seconds(2));
  checker_->OnStopEngaged(0, 7);
  robot_->EngageEmergencyStop(7);
  RunFor(std::chrono::seconds(1));
  checker_->OnStopConfirmed(7);
  ExpectFound(Invariant::kStopIsConfirmed, "b has ended in Active");
}

TEST_F(PlantedFlaw, FindsAStartOfAnActuatorThatAPersonHasTornDownAlone) {
  Make(Started(2));
  BringUp();
  const std::uint64_t request = checker_->OnRequest(*robot_->leader(), State(kTearDown));
  robot_->leader()->shell().SetState(State(kTearDown), "b", [&](const SwitchResult& result) {
    checker_->OnReply(request, result);
  });
  RunFor(std::chrono::seconds(2));
  ASSERT_FALSE(robot_->IsAlive("b"));
  robot_->CrashController();
  ASSERT_EQ(robot_->disk(0).actuators.size(), 1U);
  robot_->disk(0).actuators.clear();
  robot_->LaunchController(0, true, {}, Starter::kSupervisor);
  RunFor(std::chrono::seconds(5));
  ExpectFound(Invariant::kStaysDown, "a controller starts b");
}

TEST_F(PlantedFlaw, FindsARiseOfAnActuatorThatAPersonHolds) {
  for (const char* state : {"LowPower", "Error"}) {
    Make(Restarted(2));
    BringUp();
    const std::uint64_t request = checker_->OnRequest(*robot_->leader(), State(state));
    robot_->leader()->shell().SetState(
        State(state), "b", [&](const SwitchResult& result) { checker_->OnReply(request, result); });
    RunFor(std::chrono::seconds(2));
    robot_->CrashController();
    robot_->CrashActuator("b");
    ASSERT_EQ(robot_->disk(0).actuators.size(), 1U);
    robot_->disk(0).actuators.clear();
    robot_->LaunchController(0, true, {}, Starter::kSupervisor);
    RunFor(std::chrono::seconds(5));
    ExpectFound(Invariant::kHoldStays, "b is led to Active, and a person holds it in");
  }
}

TEST_F(PlantedFlaw, FindsATearDownReportedAsDoneWithoutARemoteActuatorThatAnEarlierOneKnew) {
  Layout layout = TwoHosts(1);
  layout.host_of = {1};
  Make(MachineOf(1), layout);
  robot_->StartActuator("a");
  BringUp();
  SetLinkOfHosts(false);
  robot_->CrashController();
  ASSERT_FALSE(robot_->disk(0).remote.empty());
  robot_->disk(0).remote.clear();
  robot_->StartController();
  RunFor(std::chrono::seconds(10));
  const std::uint64_t request = checker_->OnRequest(*robot_->leader(), State(kTearDown));
  robot_->leader()->shell().SetState(
      State(kTearDown), std::nullopt,
      [&](const SwitchResult& result) { checker_->OnReply(request, result); });
  RunFor(std::chrono::seconds(5));
  ExpectFound(Invariant::kTearDownIsComplete, "a still runs in Active on host dock");
}

TEST_F(PlantedFlaw, FindsAWaitingCommandThatIsDropped) {
  slow_ = State(kLowPower);
  Make(WithLongTimes(Started(1)));
  BringUp();
  Request(State(kLowPower));
  RunFor(std::chrono::seconds(1));
  Request(State(kError));  // takes over, and waits behind the callback
  ASSERT_TRUE(RunUntil([&] { return CoreOf("a").waiting.has_value(); }, std::chrono::seconds(1)));
  CoreOf("a").waiting.reset();
  RunFor(std::chrono::seconds(40));
  ExpectFound(Invariant::kNoCommandDropped, "a drops the accepted command to Error");
}

TEST_F(PlantedFlaw, FindsAControllerThatRepliesWhileItListens) {
  Make(Started(1), TwoHosts(1));
  BringUp();
  robot_->StartRival(false);
  transport::Node& node =
      const_cast<simulation::SimulatedController*>(robot_->controller(1))->node();
  const auto server =
      transport::MakeServer<msg::GetStatus>(
          node, transport::MachineService("", "get_status"),
          [](const auto&, const transport::Server<msg::GetStatus>::Reply& reply) { reply({}); })
          .value();
  const auto node_of_caller = robot_->network().MakeNode("caller");
  const auto caller = transport::MakeClient<msg::GetStatus>(
                          *node_of_caller, transport::MachineService("", "get_status"))
                          .value();
  RunFor(Milliseconds(400));
  caller->Call({}, std::chrono::seconds(1), [](const auto&) {});
  RunFor(Milliseconds(400));
  ExpectFound(Invariant::kOnlyLeaderReplies, "a controller that does not lead replies");
}

TEST_F(PlantedFlaw, FindsAClientThatIsNotNotifiedOfTheEndOfItsController) {
  slow_ = State(kLowPower);
  Make(WithLongTimes(Started(1)));
  BringUp();
  robot_->ClientOn(0).SetState(State(kLowPower), "");
  RunFor(Milliseconds(500));
  robot_->ClientOn(0)
      .OnControllerKilled();  // it is not killed: the client still receives its heartbeats
  RunFor(std::chrono::seconds(5));
  ExpectFound(Invariant::kClientGetsOutcome, "is not notified that the controller has ended");
}

// The controller forgets an actuator that ends its callback after the rollback.
TEST_F(PlantedFlaw, FindsAnActuatorThatStaysActiveAfterAFailedStart) {
  slow_ = State(kActive);
  MachineConfig config = MachineOf(1);
  config.actuators[0].critical = true;
  Make(config);
  robot_->StartActuator("a");
  robot_->StartController();
  ASSERT_TRUE(RunUntil([&] { return robot_->machine().phase == Phase::kFailed; },
                       std::chrono::seconds(10)));
  KnownActuator& known = machine().actuators[0];
  known.due = known.checked = false;
  RunFor(std::chrono::seconds(30));
  EXPECT_EQ(robot_->ReportOf("a")->state, "Active");
  ExpectNone();
  checker_->CheckRest(false);
  ExpectFound(Invariant::kStatesAgree, "a stays in Active while the machine is in SelfCheck");
}

class FlawOfThePolicy : public PlantedFlaw {
 protected:
  void BringUpWithBattery(int percent) {
    MachineConfig config = Started(2);
    config.policy.emplace().battery.emplace();
    Make(std::move(config));
    robot_->on_record = [this](const action::Record& record) { checker_->OnRecord(record); };
    robot_->SetBattery(percent, false);
    BringUp();
    RunFor(std::chrono::seconds(5));
  }
  PolicyState& policy() { return machine().policy; }
  void ExpectFoundOnceTheBatteryCountsAsSilent() {
    ASSERT_NO_FATAL_FAILURE(BringUp());
    Request(State(kActive));
    RunFor(std::chrono::seconds(15));
    ExpectFound(Invariant::kWithinBattery, "nothing publishes the battery, which was at 15 %");
  }
};

TEST_F(FlawOfThePolicy, FindsAPowerOffAfterOneEmptySample) {
  BringUpWithBattery(80);
  for (int glitches = 0; glitches < 2; ++glitches) {  // a good sample is between them
    RunFor(std::chrono::seconds(60));                 // the machine is up again
    robot_->GlitchBattery(0, false);
    ASSERT_TRUE(RunUntil([&] { return policy().emptying.has_value(); }, std::chrono::seconds(1)));
  }
  policy().emptying->samples = kConfirmingSamples;
  policy().emptying->since = Time{};
  RunFor(std::chrono::seconds(3));
  ExpectFound(Invariant::kNotOffByOneSample, "powered off after 1 samples in a row");
}

TEST_F(FlawOfThePolicy, FindsARaiseBeforeTheTimeOfQuiet) {
  BringUpWithBattery(15);
  ASSERT_EQ(robot_->machine().state, "Protected");
  robot_->SetBattery(80, false);
  ASSERT_TRUE(RunUntil([&] { return policy().lifting.has_value(); }, std::chrono::seconds(2)));
  policy().lifting->since = Time{};
  RunFor(std::chrono::seconds(4));
  ExpectFound(Invariant::kRaisedAfterQuiet, "ms after a sample that permits Protected");
}

// Below 7 %, where the level of 5 % is left.
TEST_F(FlawOfThePolicy, FindsARaiseToALevelThatIsNotLeft) {
  BringUpWithBattery(4);
  ASSERT_EQ(robot_->machine().state, "LowPower");
  robot_->SetBattery(6, false);
  RunFor(std::chrono::seconds(10));
  ASSERT_EQ(robot_->machine().state, "LowPower");
  policy().level = BatteryLevel::kProtected;
  robot_->SetOtherBattery(6);  // for the next step
  RunFor(std::chrono::seconds(3));
  ExpectFound(Invariant::kNoFlapping, "the policy has raised the machine to Protected at 6 %");
}

TEST_F(FlawOfThePolicy, FindsAControllerThatForgetsASecondPublisher) {
  BringUpWithBattery(80);
  robot_->SetOtherBattery(15);
  ASSERT_TRUE(
      RunUntil([&] { return robot_->machine().state == "Protected"; }, std::chrono::seconds(4)));
  RunFor(std::chrono::seconds(1));
  robot_->SetOtherBattery(std::nullopt);
  std::erase_if(policy().batteries, [](const BatterySource& b) { return b.percent == 15; });
  policy().level = BatteryLevel::kFree;
  robot_->GlitchBattery(81, false);
  RunFor(std::chrono::seconds(1));
  ExpectFound(Invariant::kRaisedAfterQuiet, "ms after a sample that permits Protected");
}

TEST_F(FlawOfThePolicy, FindsAControllerThatForgetsALowBatteryWhichIsSilentAfterItsRestart) {
  BringUpWithBattery(15);
  ASSERT_EQ(robot_->machine().state, "Protected");
  robot_->SetBatterySilent(true);
  robot_->CrashController();
  BringUp();
  RunFor(std::chrono::seconds(30));
  ExpectNone();
  robot_->CrashController();
  robot_->disk(0).policy = {};
  ExpectFoundOnceTheBatteryCountsAsSilent();
}

TEST_F(FlawOfThePolicy, FindsANextStartByAnotherUserThatHasForgottenALowBattery) {
  BringUpWithBattery(15);
  ASSERT_EQ(robot_->machine().state, "Protected");
  robot_->SetBatterySilent(true);
  robot_->ChangeUser();
  robot_->RebootHost(0);
  BringUp();
  RunFor(std::chrono::seconds(30));
  EXPECT_NE(robot_->machine().state, kActive);
  ExpectNone();
  robot_->ChangeUser();
  robot_->RebootHost(0);
  robot_->disk(0).policy = {};
  robot_->disk(0).other = {};
  ExpectFoundOnceTheBatteryCountsAsSilent();
}

// Its config follows /clock, and the robot lies still.
class FlawOfThePolicysTime : public FlawOfThePolicy {
 protected:
  void BringUpLyingStill(Duration lying_still) {
    MachineConfig config = Started(2);
    LowPowerPolicy& low_power = config.policy.emplace().low_power.emplace();
    low_power.enabled = true;
    low_power.motion_ids = {0};
    low_power.lying_still = lying_still;
    config.clock = ClockSource::kTopic;
    Make(std::move(config));
    robot_->on_record = [this](const action::Record& record) { checker_->OnRecord(record); };
    robot_->StartClock();
    robot_->SetMotion(0);
    BringUp();
  }
  void RequestKeepOfTenSeconds() {
    robot_->leader()->shell().SendPolicyRequest(
        {0, PolicyRequest::kKeep, State(kProtected), 10, false}, [](const Result<>&) {});
  }
  bool IsDown() { return robot_->machine().state == kLowPower; }
  void NextStep() {
    robot_->ReleaseEmergencyStop();  // is refused
  }
};

TEST_F(FlawOfThePolicysTime, APolicyWaitsItsTimeOnAClockThatPausesJumpsAndRunsSlowlyOrFast) {
  BringUpLyingStill(std::chrono::seconds(8));
  RunFor(std::chrono::seconds(4));
  robot_->clock()->SetPaused(true);
  RunFor(std::chrono::seconds(20));
  EXPECT_FALSE(IsDown());
  robot_->clock()->SetPaused(false);
  robot_->clock()->Jump(std::chrono::seconds(60));
  RunFor(std::chrono::seconds(1));
  robot_->clock()->Restart();
  RunFor(std::chrono::seconds(1));
  EXPECT_FALSE(IsDown());
  robot_->clock()->SetRate(5000);
  EXPECT_TRUE(RunUntil([&] { return IsDown(); }, std::chrono::seconds(1)));
  ASSERT_TRUE(robot_->Set(State(kActive)));
  robot_->clock()->SetRate(100);
  RunFor(std::chrono::seconds(70));
  EXPECT_FALSE(IsDown());
  EXPECT_TRUE(RunUntil([&] { return IsDown(); }, std::chrono::seconds(12)));
  ExpectNone();
}

// Of a keep of 10 s, 6 s have passed before the world was started again.
TEST_F(FlawOfThePolicysTime, AJumpOfTheClockNeitherEndsNorLengthensAKeep) {
  BringUpLyingStill(std::chrono::seconds(60));
  RunFor(std::chrono::seconds(2));
  RequestKeepOfTenSeconds();
  RunFor(std::chrono::seconds(6));
  robot_->clock()->Restart();
  RunFor(std::chrono::seconds(3));
  EXPECT_TRUE(policy().keep);
  RunFor(std::chrono::seconds(3));
  EXPECT_FALSE(policy().keep);
  ExpectNone();
}

TEST_F(FlawOfThePolicysTime, FindsAMachineThatGoesToLowPowerBeforeTheTimeOfItsClock) {
  BringUpLyingStill(std::chrono::seconds(8));
  ASSERT_TRUE(RunUntil([&] { return policy().still_since.has_value(); }, std::chrono::seconds(5)));
  *policy().still_since -= std::chrono::seconds(5);
  RunFor(std::chrono::seconds(4));
  NextStep();
  RunFor(std::chrono::seconds(1));
  EXPECT_TRUE(IsDown());
  ExpectFound(Invariant::kNotBeforeItsTime, "takes the machine to LowPower after");
}

// It has walked for longer than it has to lie still.
TEST_F(FlawOfThePolicysTime, FindsAMachineThatGoesToLowPowerTooEarlyAfterItHasWalked) {
  BringUpLyingStill(std::chrono::seconds(8));
  robot_->SetMotion(303);
  RunFor(std::chrono::seconds(12));
  robot_->SetMotion(0);
  ASSERT_TRUE(RunUntil([&] { return policy().still_since.has_value(); }, std::chrono::seconds(5)));
  RunFor(std::chrono::seconds(2));
  *policy().still_since -= std::chrono::seconds(5);
  RunFor(std::chrono::seconds(2));
  NextStep();
  RunFor(std::chrono::seconds(1));
  EXPECT_TRUE(IsDown());
  ExpectFound(Invariant::kNotBeforeItsTime, "takes the machine to LowPower after");
}

TEST_F(FlawOfThePolicysTime, AMachineThatHasWalkedGoesToLowPowerAfterItsTime) {
  BringUpLyingStill(std::chrono::seconds(8));
  robot_->SetMotion(303);
  RunFor(std::chrono::seconds(12));
  robot_->SetMotion(0);
  RunFor(std::chrono::seconds(7));
  EXPECT_FALSE(IsDown());
  RunFor(std::chrono::seconds(3));
  EXPECT_TRUE(IsDown());
  ExpectNone();
}

TEST_F(FlawOfThePolicysTime, FindsAKeepThatEndsBeforeTheTimeOfItsClock) {
  BringUpLyingStill(std::chrono::seconds(60));
  RunFor(std::chrono::seconds(2));
  RequestKeepOfTenSeconds();
  RunFor(std::chrono::seconds(4));
  ASSERT_TRUE(policy().keep);
  policy().keep->until -= std::chrono::seconds(9);
  NextStep();
  RunFor(Milliseconds(100));
  EXPECT_FALSE(policy().keep);
  ExpectFound(Invariant::kNotBeforeItsTime, "ends what keeps the machine after");
}

// Until its console is killed, a machine is permitted to move.
class FlawOfPermits : public PlantedFlaw {
 protected:
  void BringUpWithPermits() {
    MachineConfig config = Started(2);
    config.permit = Milliseconds(500);
    Make(std::move(config));
    robot_->StartPermits(0);
    BringUp();
    RunFor(std::chrono::seconds(10));
    ASSERT_FALSE(checker_->violation()) << checker_->violation()->what;
    ASSERT_EQ(robot_->machine().state, kActive);
  }
};

TEST_F(FlawOfPermits, AMachineStopsWithoutPermitsAndStaysStoppedUntilItIsReleasedAndSet) {
  BringUpWithPermits();
  robot_->EndPermits();
  RunFor(Milliseconds(600));
  EXPECT_NE(robot_->ReportOf("a")->emergency_stop, StopId(0));
  robot_->StartPermits(0);
  RunFor(std::chrono::seconds(10));
  checker_->CheckRest(false);
  robot_->ReleaseEmergencyStop();
  RunFor(std::chrono::seconds(10));
  checker_->CheckRest(false);
  EXPECT_FALSE(robot_->processes().IsPowered("a", 0));
  Request(State(kActive));
  RunFor(std::chrono::seconds(1));
  EXPECT_TRUE(robot_->processes().IsPowered("a", 0));
  ExpectNone();
}

TEST_F(FlawOfPermits, FindsAnActuatorThatMovesOnWithoutAPermit) {
  BringUpWithPermits();
  for (const char* name : {"a", "b"}) CoreOf(name).permit.until += std::chrono::hours(1);
  robot_->EndPermits();
  RunFor(std::chrono::seconds(2));
  ExpectFound(Invariant::kStopsWithoutPermit, "ms after the last permit to move");
}

TEST_F(FlawOfPermits, FindsAnActuatorWhoseStopEndsWhenPermitsArriveAgain) {
  BringUpWithPermits();
  robot_->EndPermits();
  RunFor(std::chrono::seconds(2));
  robot_->StartPermits(0);
  LoseStopOfA();
  RunFor(Milliseconds(200));
  ExpectFound(Invariant::kEmergencyStopLatched, "a is not stopped any more");
}

// After the release of a stop an actuator is restarted.
class FlawAfterARelease : public PlantedFlaw {
 protected:
  void BringUpAndRelease() {
    MachineConfig config = Started(2);
    config.actuators[0].restart.policy = RestartPolicy::kAlways;
    Make(std::move(config));
    BringUp();
    RunFor(std::chrono::seconds(1));
    Stop();
    Release();
  }
  void RestartA() {
    robot_->CrashActuator("a");
    RunFor(std::chrono::seconds(5));
    ASSERT_TRUE(robot_->IsAlive("a"));
  }
};

TEST_F(FlawAfterARelease, ARestartedActuatorIsSwitchedOnByARequestOnly) {
  BringUpAndRelease();
  RestartA();
  EXPECT_NE(robot_->ReportOf("a")->state, kActive);
  Request(State(kActive));
  RunFor(std::chrono::seconds(1));
  EXPECT_EQ(robot_->ReportOf("a")->state, kActive);
  RestartA();
  EXPECT_EQ(robot_->ReportOf("a")->state, kActive);
  ExpectNone();
}

TEST_F(FlawAfterARelease, FindsARestartedActuatorThatIsSwitchedOnWithoutARequest) {
  BringUpAndRelease();
  ForgetTheStop();
  RestartA();
  ExpectFound(Invariant::kReleaseSwitchesNothingOn, "a begins Active");
}

TEST_F(FlawAfterARelease, FindsANextControllerThatSwitchesARestartedActuatorOn) {
  BringUpAndRelease();
  robot_->CrashController();
  robot_->LaunchController(0, true, {}, Starter::kSupervisor);
  RunFor(std::chrono::seconds(2));
  EXPECT_TRUE(robot_->machine().emergency.awaits_request);
  ForgetTheStop();
  RestartA();
  ExpectFound(Invariant::kReleaseSwitchesNothingOn, "a begins Active");
}

// A stop holds it in Protected, and a fallback of the machine to Protected commands it there again.
TEST_F(PlantedFlaw, FindsAFallbackThatSwitchesOnAgainWhatAReleasedStopHolds) {
  MachineConfig config = Started(2);
  config.actuators[1].on_lost = State(kProtected);
  config.actuators[1].critical = true;
  Make(std::move(config));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  ASSERT_TRUE(robot_->Set(State(kProtected), "a")->done());
  Stop();
  Release();
  ASSERT_TRUE(robot_->ReportOf("a")->held_by_stop);
  ForgetTheStop();
  robot_->CrashActuator("b");
  RunFor(std::chrono::seconds(5));
  ASSERT_EQ(robot_->machine().state, kProtected);
  ExpectFound(Invariant::kReleaseSwitchesNothingOn, "a begins Protected in Protected");
}

// A stop is engaged and released while its SelfCheck runs.
class FlawOfAStart : public PlantedFlaw {
 protected:
  void StopAndReleaseDuringTheStart() {
    slow_ = State(kSelfCheck);
    Make(WithLongTimes(Started(1)));
    robot_->StartController();
    ASSERT_TRUE(
        RunUntil([&] { return robot_->machine().current.has_value(); }, std::chrono::seconds(10)));
    Stop();
    Release();
    ASSERT_FALSE(robot_->machine().emergency.stop);
    ASSERT_TRUE(robot_->machine().current);
  }
};

TEST_F(FlawOfAStart, AStartThatAStopHasMetWaitsForARequest) {
  ASSERT_NO_FATAL_FAILURE(StopAndReleaseDuringTheStart());
  RunFor(std::chrono::seconds(30));
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  EXPECT_NE(robot_->ReportOf("a")->state, kActive);
  slow_ = {};
  ASSERT_NO_FATAL_FAILURE(SetThroughSelfCheck());
  ExpectNone();
}

TEST_F(FlawOfAStart, FindsAStartThatGoesOnAfterAReleasedStop) {
  ASSERT_NO_FATAL_FAILURE(StopAndReleaseDuringTheStart());
  machine().emergency.awaits_request = false;
  RunFor(std::chrono::seconds(30));
  ExpectFound(Invariant::kReleaseSwitchesNothingOn, "a begins Active");
}

TEST_F(PlantedFlaw, AStartThatMayNotReadAFolderWaitsForARequest) {
  Make(Started(1));
  robot_->AddUnreadFolder(7);
  robot_->StartController();
  RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  ASSERT_NO_FATAL_FAILURE(SetThroughSelfCheck());
  robot_->CrashController();
  BringUp();
  EXPECT_EQ(robot_->machine().state, kActive);
  ExpectNone();
}

TEST_F(PlantedFlaw, FindsAStartThatForgetsAFolderThatItMayNotRead) {
  Make(Started(1));
  robot_->AddUnreadFolder(7);
  robot_->StartController();
  ExpectFoundAfterForgettingTheFolder();
}

// The power is cut, and the next start finds the state folder otherwise. The program that engaged
// the stop has ended, so nothing but a disk has it.
class NextStart : public PlantedFlaw {
 protected:
  void StopAndCutPower() {
    Make(Started(2));
    ASSERT_NO_FATAL_FAILURE(BringUp());
    robot_->on_stop_withdrawn = [this](StopId stop) { checker_->OnStopWithdrawn(stop); };
    checker_->OnStopEngaged(100, 7);
    robot_->EngageByProgram(7, 0, {}, false);
    RunFor(std::chrono::seconds(2));
    ASSERT_TRUE(robot_->machine().emergency.stop);
    CutPower();
  }
  void CutPower() {
    robot_->CrashController();
    robot_->RebootHost(0);
    robot_->EndStopPrograms();
  }
  void Start() {
    robot_->StartController();
    RunFor(std::chrono::seconds(10));
    checker_->CheckRest(false);
  }
};

TEST_F(NextStart, ByAnotherUserHasTheStop) {
  ASSERT_NO_FATAL_FAILURE(StopAndCutPower());
  robot_->ChangeUser();
  Start();
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  EXPECT_EQ(robot_->machine().emergency.stop->id, StopId(7));
  ExpectNone();
}

TEST_F(NextStart, FindsOneByAnotherUserThatHasForgottenTheStop) {
  ASSERT_NO_FATAL_FAILURE(StopAndCutPower());
  robot_->ChangeUser();
  robot_->disk(0).other = {};
  Start();
  ExpectFound(Invariant::kEmergencyStopLatched, "no emergency stop although one is engaged");
}

// The panel publishes its stop for ever, and the release is in the first user's folder. The second
// user's start has engaged it again, and the first user's next one takes over its processes.
class NextStartAfterARelease : public NextStart {
 protected:
  void StartByTheOtherUser() {
    Make(Started(2));
    ASSERT_NO_FATAL_FAILURE(BringUp());
    Stop();
    robot_->ReleaseEmergencyStop();
    RunFor(std::chrono::seconds(1));
    ASSERT_TRUE(robot_->Set(State(kActive))->done());
    CutPower();
    robot_->ChangeUser();
    Start();
    ASSERT_TRUE(robot_->machine().emergency.stop);
    robot_->ChangeUser();
  }
};

TEST_F(NextStartAfterARelease, WaitsForOneRequestIfAnotherUsersStartHasEngagedTheStopAgain) {
  ASSERT_NO_FATAL_FAILURE(StartByTheOtherUser());
  Start();
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  EXPECT_FALSE(robot_->machine().emergency.stop);
  ASSERT_NO_FATAL_FAILURE(SetThroughSelfCheck());
  robot_->CrashController();
  BringUp();
  EXPECT_EQ(robot_->machine().state, kActive);
  ExpectNone();
}

TEST_F(NextStartAfterARelease, FindsOneThatForgetsThatAnotherUsersStartHasEngagedTheStopAgain) {
  ASSERT_NO_FATAL_FAILURE(StartByTheOtherUser());
  robot_->disk(0).other.stops = {};
  Start();
  ExpectFound(Invariant::kReleaseSwitchesNothingOn, "begins Active in SelfCheck, which was not");
}

TEST_F(NextStart, WithAFolderThatIsOpenForReadingOnlyHasTheStop) {
  ASSERT_NO_FATAL_FAILURE(StopAndCutPower());
  robot_->SetFolderOpens(simulation::FolderOpens::kForReading);
  Start();
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  EXPECT_EQ(robot_->machine().emergency.stop->id, StopId(7));
  ExpectNone();
}

TEST_F(NextStart, FindsOneThatReadsNothingOfAFolderThatIsOpenForReadingOnly) {
  ASSERT_NO_FATAL_FAILURE(StopAndCutPower());
  robot_->SetFolderOpens(simulation::FolderOpens::kForReading);
  robot_->disk(0).stops = {};
  Start();
  ExpectFound(Invariant::kEmergencyStopLatched, "no emergency stop although one is engaged");
}

TEST_F(NextStart, WithAFolderThatCannotBeReadWaitsForARequest) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  CutPower();
  robot_->SetFolderOpens(simulation::FolderOpens::kNo);
  robot_->StartController();
  RunFor(std::chrono::seconds(5));
  EXPECT_EQ(robot_->machine().phase, Phase::kFailed);
  ExpectNone();
  ASSERT_NO_FATAL_FAILURE(SetThroughSelfCheck());
  CutPower();
  robot_->StartController();
  ExpectFoundAfterForgettingTheFolder();
}

TEST_F(PlantedFlaw, FindsASignalToAProcessThatIsNotTheActuators) {
  Make(MachineOf(2));
  robot_->StartActuator("a");
  robot_->StartController();
  RunFor(Milliseconds(100));
  robot_->network().Block("b", "controller");
  robot_->StartActuator("b");  // without the controller
  robot_->on_signal(*robot_->leader(), robot_->processes().PidOf("b"));
  ExpectFound(Invariant::kOnlyOwnProcessesSignalled, "is not the process of that actuator");
}

// Two controllers that do not receive each other, and an actuator that both reach.
class TwoLinks : public PlantedFlaw {
 protected:
  void TakeOverBeyondACutLink() {
    Layout layout;
    layout.hosts = {"robot", "dock", "arm"};
    layout.host_of = {0, 2};
    layout.controllers = {0, 1};
    Make(MachineOf(2), layout);
    robot_->StartActuator("a");
    robot_->StartActuator("b");
    robot_->disk(0).epoch = 4;
    ASSERT_NO_FATAL_FAILURE(BringUp());
    SetLinkOfHosts(false);
    RunFor(std::chrono::seconds(5));
  }
  ActuatorCore& CoreOfB() { return const_cast<ActuatorCore&>(*robot_->processes().CoreOf("b", 2)); }
  Machine& MachineOfController(std::size_t which) {
    return const_cast<Machine&>(robot_->controller(which)->shell().machine());
  }
};

TEST_F(TwoLinks, TheTakeoverLastsAlsoAfterHealing) {
  ASSERT_NO_FATAL_FAILURE(TakeOverBeyondACutLink());
  robot_->StartRival(true);
  RunFor(std::chrono::seconds(20));
  EXPECT_EQ(robot_->controller(0), nullptr) << "the first one is replaced, and has exited";
  ASSERT_NE(robot_->controller(1), nullptr);
  EXPECT_EQ(CoreOfB().report.epoch, MachineOfController(1).epoch);
  SetLinkOfHosts(true);
  RunFor(std::chrono::seconds(10));
  EXPECT_EQ(CoreOf("a").report.epoch, MachineOfController(1).epoch);
  EXPECT_EQ(robot_->leaders(), 1U);
  ExpectNone();
}

TEST_F(TwoLinks, FindsARunningControllerThatRaisesItsEpoch) {
  ASSERT_NO_FATAL_FAILURE(TakeOverBeyondACutLink());
  MachineOfController(0).epoch = MachineOfController(0).epoch + 2;
  Request(State(kLowPower));
  RunFor(Milliseconds(100));
  ExpectFound(Invariant::kEpochRaisedOnce, "goes from epoch 5 to 7");
}

TEST_F(TwoLinks, FindsAnActuatorThatReturnsToAReplacedController) {
  ASSERT_NO_FATAL_FAILURE(TakeOverBeyondACutLink());
  robot_->network().Block("b", "controller");  // the first one does not notice
  robot_->StartRival(true);
  RunFor(std::chrono::seconds(10));
  ExpectNone();
  ASSERT_EQ(robot_->leaders(), 2U);
  CoreOfB().controller = Sender(robot_->controller(0)->participant().value());
  robot_->EngageEmergencyStop(7);  // so that it publishes its status
  RunFor(Milliseconds(200));
  ExpectFound(Invariant::kTakeoverLasts, "b returns to the controller on host robot");
}

TEST_F(TwoLinks, FindsAStateThatRisesWithoutARecord) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  ASSERT_TRUE(robot_->Set(State(kLowPower))->done());
  RunFor(std::chrono::seconds(1));
  MachineOfController(0).state = MachineOfController(0).recorded_state = State(kActive);
  robot_->ReleaseEmergencyStop();  // the next step of the controller
  RunFor(Milliseconds(10));
  ExpectFound(Invariant::kRisesAreRecorded, "went from LowPower to Active");
}

// A command upward for which nothing was recorded.
TEST_F(TwoLinks, FindsAnActuatorThatRisesWithoutARecord) {
  Make(Started(1));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  ASSERT_TRUE(robot_->Set(State(kLowPower))->done());
  RunFor(std::chrono::seconds(1));
  robot_->on_record_of = {};  // the journal loses the request
  Request(State(kActive));
  RunFor(std::chrono::seconds(1));
  ExpectFound(Invariant::kRisesAreRecorded, "for which its controller has recorded no reason");
}

TEST_F(PlantedFlaw, FindsAHealthyProcessThatIsKilledForAFaultOfTheNetwork) {
  MachineConfig config = Started(1);
  config.actuators[0].restart.policy = RestartPolicy::kAlways;
  Make(std::move(config));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  RunFor(std::chrono::seconds(1));
  // As if processes of one host reached each other by the outer interface, which is gone.
  robot_->network().Partition("a", "controller");
  RunFor(std::chrono::seconds(30));
  ExpectFound(Invariant::kNoKillForTheNetwork, "ends the process of a, which is well");
}

// b is torn down before a, which it follows.
TEST_F(PlantedFlaw, FindsAProcessThatIsSignalledBeforeItsTearDown) {
  MachineConfig config = Started(2);
  config.actuators[1].after = {"a"};
  Make(std::move(config));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  slow_ = State(kTearDown);
  Request(State(kTearDown));
  RunFor(Milliseconds(1));
  ASSERT_EQ(robot_->machine().phase, Phase::kStopping);
  robot_->on_signal(*robot_->leader(), robot_->processes().PidOf("b"));
  ASSERT_FALSE(checker_->violation()) << "its TearDown runs";
  robot_->on_signal(*robot_->leader(), robot_->processes().PidOf("a"));
  ExpectFound(Invariant::kTornDownBeforeSignals, "the process of a, which is in Active");
}

TEST_F(PlantedFlaw, AHostWithoutItsOuterNetworkKeepsItsProcesses) {
  MachineConfig config = Started(2);
  config.actuators[1].command.clear();
  Layout layout = TwoHosts(2);
  layout.host_of = {0, 1};
  Make(std::move(config), layout);
  robot_->StartActuator("b");
  ASSERT_NO_FATAL_FAILURE(BringUp());
  const std::int32_t pid = robot_->processes().PidOf("a");
  robot_->hosts().SetCutOff(0, true);
  RunFor(std::chrono::seconds(30));
  EXPECT_TRUE(robot_->Set(State(kLowPower)));
  robot_->hosts().SetCutOff(0, false);
  RunFor(std::chrono::seconds(30));
  EXPECT_EQ(robot_->processes().PidOf("a"), pid);
  ExpectNone();
}

TEST_F(PlantedFlaw, FindsAStopThatIsReportedBeforeEveryActuatorIsStopped) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  RunFor(std::chrono::seconds(1));
  checker_->OnStopEngaged(100, 7);
  checker_->OnStopConfirmed(7);
  ExpectFound(Invariant::kStopIsConfirmed, "a is on in Active");
}

// Beside an earlier stop every actuator is stopped, also where this one was lost.
TEST_F(PlantedFlaw, FindsAStopThatIsReportedAndHasArrivedNowhere) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  checker_->OnStopEngaged(0, 5);
  robot_->EngageEmergencyStop(5);
  RunFor(std::chrono::seconds(1));
  checker_->OnStopEngaged(100, 7);
  checker_->OnStopConfirmed(7);
  ExpectFound(Invariant::kStopIsConfirmed, "the stop has arrived nowhere");
}

// A program engages a stop over links that delay, lose and discover late.
class StopProgram : public PlantedFlaw {
 protected:
  void Engage(StopId id, const SimRobot::StopLinks& links) {
    robot_->on_stop_program = [this](StopId stop, bool confirmed) {
      confirmed_ = confirmed;
      if (confirmed) checker_->OnStopConfirmed(stop);
    };
    robot_->on_stop_withdrawn = [this](StopId stop) { checker_->OnStopWithdrawn(stop); };
    checker_->OnStopEngaged(100, id);
    robot_->EngageByProgram(id, 0, links, false);
  }
  void EngageAHundred() {
    for (std::uint64_t id = 1; id <= 100; ++id) {
      checker_->OnStopEngaged(0, StopId(id));
      robot_->EngageEmergencyStop(StopId(id), 0, "person " + std::to_string(id));
      RunFor(Milliseconds(3));
    }
  }
  std::optional<bool> confirmed_;
};

TEST_F(StopProgram, EndsWithExitCodeZeroOnceEveryActuatorIsStopped) {
  ASSERT_NO_FATAL_FAILURE(BringUpOverLan(3));
  Engage(7, {Milliseconds(300), 0.2, std::chrono::seconds(4)});
  ASSERT_TRUE(RunUntil([&] { return confirmed_.has_value(); }, std::chrono::seconds(11)));
  EXPECT_TRUE(*confirmed_);
  RunFor(std::chrono::seconds(5));
  checker_->CheckRest(false);
  ExpectNone();
}

TEST_F(StopProgram, KeepsAStopPublishedThatIsNotConfirmedInTime) {
  ASSERT_NO_FATAL_FAILURE(BringUpOverLan(3));
  robot_->network().Block("estop-7", "b");
  Engage(7, {Milliseconds(1), 0, Milliseconds(5)});
  robot_->network().Block("controller", "b");
  ASSERT_TRUE(RunUntil([&] { return confirmed_.has_value(); }, std::chrono::seconds(11)));
  EXPECT_FALSE(*confirmed_);
  robot_->network().Free("estop-7", "b");
  RunFor(std::chrono::seconds(1));
  EXPECT_EQ(robot_->ReportOf("b")->emergency_stop, StopId(7));
}

TEST_F(StopProgram, AHundredStopsOfAsManySourcesAreReleasedTogether) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  EngageAHundred();
  RunFor(std::chrono::seconds(1));
  checker_->CheckRest(false);
  Release();
  checker_->CheckRest(false);
  ExpectNone();
  EXPECT_EQ(robot_->ReportOf("a")->emergency_stop, StopId(0));
}

TEST_F(StopProgram, IsNotConfirmedWhileANewControllerHasNotTakenControlOfAnActuator) {
  ASSERT_NO_FATAL_FAILURE(BringUpOverLan(2));
  robot_->CrashController();
  RunFor(std::chrono::seconds(1));
  robot_->network().Block("controller", "a");
  robot_->network().Block("estop-7", "a");
  robot_->network().Block("a", "estop-7");
  robot_->LaunchController(0, true, std::chrono::seconds(1));
  RunFor(Milliseconds(1050));
  ASSERT_TRUE(robot_->has_controller());
  EXPECT_EQ(robot_->machine().actuators[0].presence, Presence::kAbsent) << "found by its name";
  Engage(7, {});
  ASSERT_TRUE(RunUntil([&] { return confirmed_.has_value(); }, std::chrono::seconds(11)));
  EXPECT_FALSE(*confirmed_);
  ExpectNone();
}

TEST_F(StopProgram, OneReleaseEndsAHundredStopsThatCameWhileNoControllerRan) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  robot_->CrashController();
  EngageAHundred();
  ASSERT_NO_FATAL_FAILURE(BringUp());
  RunFor(std::chrono::seconds(1));
  Release();
  EXPECT_FALSE(robot_->machine().emergency.stop);
  EXPECT_EQ(robot_->ReportOf("a")->emergency_stop, StopId(0));
}

TEST_F(StopProgram, AStopWithoutAnIdStopsAgainAfterItsRelease) {
  Make(Started(2));
  ASSERT_NO_FATAL_FAILURE(BringUp());
  for (int i = 0; i < 2; ++i) {
    const StopId id = robot_->EngageEmergencyStop(0);
    checker_->OnStopEngaged(0, id);
    RunFor(std::chrono::seconds(1));
    EXPECT_EQ(robot_->ReportOf("a")->emergency_stop, id);
    checker_->CheckRest(false);
    Release();
    checker_->CheckRest(false);
  }
  ExpectNone();
}

// Two machines with the same actuators in one network, each with a checker.
class TwoMachines : public PlantedFlaw {
 protected:
  static constexpr const char* kOurs = "11111111";

  // `theirs`: the id of the other machine; the same one: as if machines had none.
  void MakeBoth(const std::string& theirs) {
    Layout layout;
    layout.hosts = {"robot", "other"};
    layout.host_of = PerActuator<std::size_t>(2, 0);
    layout.machine_id = kOurs;
    Make(Started(2), layout);
    layout.host_of = PerActuator<std::size_t>(2, 1);
    layout.controllers = {1, 1};
    layout.machine_id = theirs;
    layout.prefix = "other/";
    other_.emplace(*robot_, robot_->config(), simulation::Script(), layout);
    other_checker_.emplace(*other_);
    checker_->SetOther(*other_);
    other_checker_->SetOther(*robot_);
    SetLinkOfHosts(false);
    other_->disk(0).epoch = 100;
    other_->LaunchController(0, true, {});
    ASSERT_NO_FATAL_FAILURE(BringUp());
    RunFor(std::chrono::seconds(2));
    ASSERT_EQ(other_->machine().phase, Phase::kRunning);
  }
  void TearDown() override {
    other_.reset();  // its network is the robot's
  }

  std::optional<SimRobot> other_;
  std::optional<simulation::Checker> other_checker_;
};

TEST_F(TwoMachines, ThatMeetChangeNothingOfEachOther) {
  ASSERT_NO_FATAL_FAILURE(MakeBoth("22222222"));
  SetLinkOfHosts(true);
  RunFor(std::chrono::seconds(10));
  robot_->ClientOn(0).SetState(State(kLowPower), "");
  RunFor(std::chrono::seconds(2));
  EXPECT_EQ(robot_->machine().state, kLowPower);
  EXPECT_EQ(other_->machine().state, kActive);
  other_->ClientOn(1).SetState(State(kTearDown), "");
  RunFor(std::chrono::seconds(5));
  EXPECT_EQ(other_->machine().phase, Phase::kStopped);
  EXPECT_EQ(robot_->ReportOf("a")->state, kLowPower);
  EXPECT_EQ(robot_->leaders(), 1U);
  ExpectNone();
  EXPECT_FALSE(other_checker_->violation()) << other_checker_->violation()->what;
}

TEST_F(TwoMachines, FindsAControllerThatAHeartbeatOfAnotherMachineFences) {
  ASSERT_NO_FATAL_FAILURE(MakeBoth(kOurs));
  SetLinkOfHosts(true);
  RunFor(std::chrono::seconds(3));
  ExpectFound(Invariant::kOtherMachineNeverFences, "the only controller of machine 11111111");
}

TEST_F(TwoMachines, FindsAnActuatorThatObeysAnotherMachine) {
  ASSERT_NO_FATAL_FAILURE(MakeBoth("22222222"));
  CoreOf("a").controller = Sender(other_->controller(0)->participant().value());
  robot_->EngageEmergencyStop(7);  // so that it publishes its status
  RunFor(Milliseconds(200));
  ExpectFound(Invariant::kReachesMeantMachine, "a obeys a controller of machine 22222222");
}

TEST_F(TwoMachines, FindsARequestThatDoesNotSayWhichMachineIsMeant) {
  ASSERT_NO_FATAL_FAILURE(MakeBoth("22222222"));
  SetLinkOfHosts(true);
  RunFor(std::chrono::seconds(5));
  const auto node = robot_->network().MakeNode("caller");
  const auto caller =
      transport::MakeClient<msg::SetState>(*node, transport::MachineService("", "set_state"))
          .value();
  RunFor(std::chrono::seconds(1));
  msg::SetState::Request request;
  request.target = kLowPower;
  request.by = simulation::Client::Name("22222222");
  caller->Call(request, std::chrono::seconds(5), [](const auto&) {});
  RunFor(std::chrono::seconds(2));
  ExpectFound(Invariant::kReachesMeantMachine, "acts on a request of another");
}

TEST_F(TwoMachines, FindsAStopThatDoesNotSayWhichMachineIsMeant) {
  ASSERT_NO_FATAL_FAILURE(MakeBoth("22222222"));
  checker_->OnStopOfOther(7);
  other_->EngageEmergencyStop(7);
  RunFor(std::chrono::seconds(1));
  ExpectFound(Invariant::kReachesMeantMachine, "is meant for another machine");
}

}  // namespace musher::testing::planted_flaw_test
