// Robots and injected events sampled from seeds, with every invariant checked after every event.
//
//   MUSHER_SEED=42 [MUSHER_ONLY=3,7] simulation_test --gtest_filter='*HoldEvery*/0'
//     runs one scenario, optionally with some of its injected events only, and prints its timeline
//   MUSHER_SEEDS=1000000 [MUSHER_FIRST=200000] …
//     runs that many, optionally from the given one on; the gate runs 1,400, scripts/test --nightly
//     10,000
//   MUSHER_BRIDGES=0 …
//     without bridges that repeat old samples of actuators

#include <gmock/gmock.h>

#include <cstdlib>
#include <iostream>
#include <sstream>

#include "musher/simulation/search.hpp"
#include "musher/simulation/timeline.hpp"
#include "musher/test/simulation/replay_check.hpp"
#include "musher/test/simulation/sampled_config.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::testing::scenario_test {

using simulation::Injections;
using simulation::Scenario;
using simulation::ScenarioEnd;
using simulation::ScenarioId;
using simulation::ScenarioOptions;
using simulation::Timeline;

std::string Environment(const char* name, const std::string& otherwise) {
  const char* value = std::getenv(name);
  return value == nullptr ? otherwise : value;
}

bool HasBridges() {
  return Environment("MUSHER_BRIDGES", "1") != "0";
}

ScenarioOptions OptionsFor(const MachineConfig& config) {
  ScenarioOptions options = simulation::UsualOptions(config);
  options.provided = false;  // a sampled robot may run without any of its actuators
  options.shared_processes = true;
  options.bridges = HasBridges();
  return options;
}

std::string TimelineOf(const MachineConfig& config, const ScenarioId& id) {
  Scenario scenario(config, id.seed, simulation::InjectionsOf(config, id).value(),
                    OptionsFor(config));
  Timeline timeline(scenario, config);
  timeline.End(scenario.Run());
  return timeline.Text();
}

std::string Command(const ScenarioId& id) {
  std::string only;
  for (const std::size_t number : id.only.value_or(std::vector<std::size_t>())) {
    only += (only.empty() ? " MUSHER_ONLY=" : ",") + std::to_string(number);
  }
  return std::string(id.bridges ? "" : "MUSHER_BRIDGES=0 ") +
         ("MUSHER_SEED=" + std::to_string(id.seed)) + only +
         " simulation_test --gtest_filter='*HoldEvery*/0'";
}

// Every thirtieth scenario is also replayed from its journal, except with profile lan: the journal
// does not record as inputs what a controller receives while it listens for others.
void ExpectInvariantsHold(std::uint64_t seed, simulation::Coverage& coverage) {
  const MachineConfig config = SampleConfig(seed);
  const ScenarioOptions options = OptionsFor(config);
  Scenario scenario(config, seed, simulation::SampleInjections(config, seed, options.bridges),
                    options);
  const ScenarioEnd ending = scenario.Run();
  coverage.Add(ending.coverage);
  if (ending.violation) {
    const ScenarioId id = Shrink(config, options, seed, ending.violation->invariant);
    ADD_FAILURE() << ending.violation->what << "\nreplay with: " << Command(id) << "\n"
                  << TimelineOf(config, id);
    return;
  }
  const bool whole = config.transport == TransportProfile::kLocal &&
                     !scenario.robot().disk(0).gap && scenario.robot().disk(1).recording.empty();
  if (seed % 30 == 0 && whole) ExpectReplaysTheSame(scenario.robot());
}

constexpr std::uint64_t kParts = 10;
// A long run ends after so many violations of a part.
constexpr int kMostFailures = 20;

int FailuresSoFar() {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const ::testing::TestResult& result = *test->result();
  int failures = 0;
  for (int k = 0; k < result.total_part_count(); ++k)
    failures += result.GetTestPartResult(k).failed();
  return failures;
}

class Scenarios : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(Scenarios, HoldEveryInvariant) {
  simulation::Coverage coverage;
  const std::string only = Environment("MUSHER_SEED", "");
  if (!only.empty()) {
    if (GetParam() != 0) GTEST_SKIP();
    ScenarioId id{std::stoull(only), std::nullopt, HasBridges()};
    if (const std::string numbers = Environment("MUSHER_ONLY", ""); !numbers.empty()) {
      std::istringstream text(numbers);
      id.only.emplace();
      for (std::string number; std::getline(text, number, ',');) {
        id.only->push_back(std::stoul(number));
      }
    }
    const std::string run = TimelineOf(SampleConfig(id.seed), id);
    std::cout << run;
    EXPECT_EQ(run.find("✗"), std::string::npos) << "it still fails";
    if (!id.only) ExpectInvariantsHold(id.seed, coverage);
    return;
  }
  const std::uint64_t seeds = std::stoull(Environment("MUSHER_SEEDS", "800"));
  const std::uint64_t first = std::stoull(Environment("MUSHER_FIRST", "1"));
  for (std::uint64_t seed = 1 + GetParam(); seed <= seeds && FailuresSoFar() < kMostFailures;
       seed += kParts) {
    if (seed >= first) ExpectInvariantsHold(seed, coverage);
  }
  std::cout << coverage.Text();
}

INSTANTIATE_TEST_SUITE_P(Part, Scenarios, ::testing::Range(std::uint64_t{0}, kParts));

// Seeds above those of the gate that violated an invariant before the fault was fixed, when nothing
// was around the robot.
TEST(Scenario, OfASeedThatOnceViolatedAnInvariantHoldsEveryInvariant) {
  simulation::Coverage coverage;
  for (const std::uint64_t seed :
       {15818,  16692,  30533,  30544,  31932,  34665,  46300,   50162,  77468,  116243, 129518,
        132646, 152815, 166532, 215646, 228046, 228486, 229378,  236951, 239495, 328912, 329446,
        344904, 362153, 398324, 453812, 468754, 635457, 639374,  698082, 726124, 780187, 807327,
        892028, 916179, 933190, 123271, 128277, 132404, 146605,  268963, 325222, 594348, 706290,
        531519, 534068, 547531, 929300, 933738, 979865, 1008712, 1022288}) {
    const MachineConfig config = SampleConfig(seed);
    Injections injections = simulation::SampleInjections(config, seed);
    const std::size_t around = std::erase_if(injections, [](const simulation::Injection& one) {
      return simulation::IsAround(one.kind);
    });
    const ScenarioEnd ending = RunScenario(config, seed, injections, OptionsFor(config));
    EXPECT_FALSE(ending.violation) << seed << ": " << ending.violation->what;
    if (around != 0) ExpectInvariantsHold(seed, coverage);
  }
}

// The violation in the scenario of a seed, with some of its injected events; empty: none.
std::string ViolationOf(std::uint64_t seed, const std::vector<std::size_t>& only) {
  const MachineConfig config = SampleConfig(seed);
  ScenarioOptions options = OptionsFor(config);
  options.bridges = true;
  const auto injections = simulation::InjectionsOf(config, {seed, only, true});
  const ScenarioEnd ending = RunScenario(config, seed, injections.value(), options);
  return ending.violation ? ending.violation->what : "";
}

// Those of the first scenarios with bridges that violated an invariant.

TEST(InjectionText, HasAValueForEachNameOfEachKind) {
  MachineConfig config;
  config.actuators.resize(1);
  config.actuators[0].name = "audio";
  for (std::size_t kind = 0; kind < simulation::kInjectionKinds; ++kind) {
    simulation::Injection injection;
    injection.kind = static_cast<simulation::InjectionKind>(kind);
    const std::string text = simulation::Describe(config, injection);
    EXPECT_FALSE(text.empty()) << kind;
    EXPECT_EQ(text.find_first_of("{}"), std::string::npos) << text;
  }
}

TEST(FoundScenario, ACommandThatOnlyAppearedTooOldIsSentAgain) {
  EXPECT_EQ(ViolationOf(30544, {1, 4, 5}), "");
  EXPECT_EQ(ViolationOf(50162, {26, 30, 31}), "");
}

// The checker took an actuator for found in DeActive that had a command to Protected of the
// controller before in its queue, and was led back there when the one that it is bound to had been
// restarted.
TEST(FoundScenario, AControllerMayLeadBackToWhatAnEarlierCommandThatWaitedHasLedTo) {
  EXPECT_EQ(ViolationOf(1022288, {1, 2, 3, 5}), "");
}

// Its callback on the way down to DeActive failed after the controller had been restarted: it was
// found in Active. The checker took it for found in DeActive.
TEST(FoundScenario, AControllerMayLeadBackWhatHasFailedToFall) {
  EXPECT_EQ(ViolationOf(400866, {7, 8, 9, 10, 11, 12, 13}), "");
}

// Its work thread had hung before it was frozen: it stayed present for ever.
TEST(FoundScenario, AHungActuatorThatIsFrozenSinceIsLost) {
  EXPECT_EQ(ViolationOf(425338, {1, 9, 10}), "");
  EXPECT_EQ(ViolationOf(457457, {8, 13, 14, 15, 16, 17, 20}), "");
}

// `musher estop` returned 0 while all of them were being torn down, and nothing had latched the
// stop.
TEST(FoundScenario, AStopIsNotConfirmedByTornDownActuatorsAlone) {
  EXPECT_EQ(ViolationOf(46409, {2, 3, 4, 5, 8, 14, 23}), "");
}

// Its host was rebooted within a millisecond.
TEST(FoundScenario, AReleaseWaitsForAProcessThatStillCountsAsASecondOne) {
  EXPECT_EQ(ViolationOf(1008712, {2, 4, 10, 12}), "");
}

TEST(FoundScenario, AControllerStartsNoActuatorOfWhichOneOfTwoProcessesHasEnded) {
  EXPECT_EQ(ViolationOf(34665, {7, 10, 11, 12, 14, 15}), "");
}

// The process on this host had the same pid as the one on the other host, which is used since.
TEST(FoundScenario, AControllerStartsNoActuatorThatRunsOnAnotherHost) {
  EXPECT_EQ(ViolationOf(132404, {2, 4, 9, 11, 13, 14}), "");
  EXPECT_EQ(ViolationOf(594348, {6, 7, 9, 11}), "");
}

// A restart was requested of an actuator whose process on the other host is in use. The controller
// ended its own process, which waited, and forgot the request.
TEST(FoundScenario, ARestartOfAnActuatorOnAnotherHostEndsNoProcessThatWaitsHere) {
  EXPECT_EQ(ViolationOf(935251, {1, 5, 7, 9}), "");
}

// Beyond a cut link another controller had the actuator without which a person had gone on here.
// The checker took its loss for a new one.
TEST(FoundScenario, APersonGoesOnWithoutAnActuatorThatAnotherControllerHas) {
  EXPECT_EQ(ViolationOf(339152, {5, 6, 7, 8, 11}), "");
}

TEST(FoundScenario, AClientThatIsDiscoveredLateGetsItsOutcome) {
  EXPECT_EQ(ViolationOf(774361, {1, 2, 4, 6, 8, 11, 13, 14, 15, 16, 17, 18}), "");
}

// Another host had a frozen process, which the controller took for a crashed one.
TEST(FoundScenario, AStopIsNotConfirmedBesideASilentActuatorOfAnotherHost) {
  EXPECT_EQ(ViolationOf(1180096, {2, 4, 13}), "");
}

TEST(FoundScenario, ABatteryThatIsChargedDoesNotRaiseWhatAPersonHasTornDown) {
  EXPECT_EQ(ViolationOf(1124561, {5, 7, 9, 10, 19}), "");
}

// Between two of its reports it received a stop and its release, behind which its command waited.
// The checker took that for a dropped one.
TEST(FoundScenario, ACommandThatWaitedUnderAStopMayBeDroppedAfterItsRelease) {
  EXPECT_EQ(ViolationOf(20005, {3, 4, 8, 10, 16, 19, 20, 21, 24, 29}), "");
}

// A person had led it out of Error to SelfCheck. The controller was restarted, beside an actuator
// that had been restarted too, and went on to Active.
TEST(FoundScenario, AMachineInSelfCheckIsLedOnByAPersonAlone) {
  EXPECT_EQ(ViolationOf(1857, {5, 11, 12, 15, 16}), "");
}

// The restarted controller went on in the state of an actuator that has no LowPower, and then led
// the one up that a person had put to sleep, which had announced itself late.
TEST(FoundScenario, ARestartedControllerLeadsNothingUpThatIsAnnouncedLate) {
  EXPECT_EQ(ViolationOf(2840, {4, 7, 9, 11}), "");
}

// Its controller was killed and started again, and knew no sample: it stayed in Active.
TEST(FoundScenario, ARobotWhoseBatteryWasLowAndIsSilentIsTakenDown) {
  EXPECT_EQ(ViolationOf(6561, {8, 9, 10, 11, 12, 14, 23}), "");
  EXPECT_EQ(ViolationOf(10581, {1, 2, 6, 7, 12}), "");
}

// After the release of a stop an actuator was lost, and the fallback switched another one up, from
// DeActive, to which it had gone without its controller.
TEST(FoundScenario, AFallbackAfterAReleasedStopSwitchesNothingOn) {
  EXPECT_EQ(ViolationOf(103263, {2, 4}), "");
}

// Behind the callback to DeActive a command to Protected waited, which had come during the stop.
TEST(FoundScenario, ACommandThatWaitedUnderAStopSwitchesNothingOnAfterItsRelease) {
  EXPECT_EQ(ViolationOf(84581, {1, 2, 4}), "");
}

// A wake-up, or the exit from OTA, leads as far as the battery permits. The checker took it for a
// request of that state alone, and the battery's raise to Active for one without a request.
TEST(FoundScenario, ABatteryThatIsChargedRaisesTheMachineToWhatAWakeUpHasRequested) {
  EXPECT_EQ(ViolationOf(45701, {1, 4, 5, 7}), "");
  EXPECT_EQ(ViolationOf(168891, {3, 5, 6, 18}), "");
}

// The checker forgot from where a start that the battery had limited was to be raised again, once
// the battery had taken it down further.
TEST(FoundScenario, ABatteryThatIsChargedRaisesAlsoWhatALimitedStartHasWithheld) {
  EXPECT_EQ(ViolationOf(3464, {1, 6, 9}), "");
}

// It was requested during the stop, or just before. Under the stop the actuators that would have to
// come up for it refuse; the release came before their turn.
TEST(FoundScenario, ASwitchDownThatAStopHasMetSwitchesNothingOnAfterTheRelease) {
  EXPECT_EQ(ViolationOf(99221, {1, 2, 3, 4}), "");
  EXPECT_EQ(ViolationOf(11853, {14, 17, 19}), "");
  EXPECT_EQ(ViolationOf(705946, {2, 6, 8, 9, 11, 13}), "");
}

// It lists no lower state, and had been in Active before the switch up that the stop ended.
TEST(FoundScenario, ARollbackSwitchesNothingOnAgainThatAStopHolds) {
  EXPECT_EQ(ViolationOf(706008, {9, 13, 14}), "");
}

// Lost messages are repeated, delayed ones come late: a command that was sent before a stop arrived
// after its release, within its budget.
TEST(FoundScenario, ACommandThatArrivesAfterAReleaseSwitchesNothingOnIfItWasSentBefore) {
  EXPECT_EQ(ViolationOf(38789, {1, 3, 5, 6, 7}), "");
  EXPECT_EQ(ViolationOf(389462, {1, 3, 4, 6, 7}), "");
  EXPECT_EQ(ViolationOf(864361, {5, 10, 12, 13, 14}), "");
}

// The actuator was frozen. The checker took the stop for one that is engaged when it arrives.
TEST(FoundScenario, ACommandAfterAReleaseBeginsWhereTheStopAndTheReleaseArriveLate) {
  EXPECT_EQ(ViolationOf(329342, {1, 4, 5, 6, 7}), "");
}

// The checker took more than a hundred samples in one instant for a deadline that is passed over.
TEST(FoundScenario, StopsByTheHundredComeBeforeTheTimerOfTheirInstant) {
  EXPECT_EQ(ViolationOf(409971, {3, 4}), "");
  EXPECT_EQ(ViolationOf(542343, {3, 9}), "");
}

// Without what it is bound to, the actuator was on its way to DeActive when the fallback came.
TEST(FoundScenario, AFallbackSwitchesNothingOnThatIsOnItsWayDown) {
  EXPECT_EQ(ViolationOf(11904, {3, 5, 6}), "");
}

// The checker held a confirmation of the other machine for one of this machine: the program had
// named both by their name.
TEST(FoundScenario, AStopOfANameThatTwoMachinesHaveMayReachTheOtherOneOnly) {
  EXPECT_EQ(ViolationOf(502801, {2, 3, 4}), "");
}

// A callback that a stop had met switched on at its end, and the stop action ran again at once.
TEST(FoundScenario, ACallbackUnderAStopMaySwitchOnUntilItsEndIsKnown) {
  EXPECT_EQ(ViolationOf(185871, {1, 3}), "");
}

// It was torn down, while another actuator of its process ran on beyond the cut link.
TEST(FoundScenario, AControllerMayStartAProcessOfWhichOneActuatorIsTornDownBeyondACutLink) {
  EXPECT_EQ(ViolationOf(417281, {11, 12, 14, 18, 19}), "");
}

// Its heartbeat had reported the hang of a callback that ended on the way of that heartbeat.
TEST(FoundScenario, AProcessThatHasReportedAHangMayBeKilledAlsoJustAfterIt) {
  EXPECT_EQ(ViolationOf(716501, {2, 3, 5, 9, 11, 12}), "");
}

// Both had the same pid, and their statuses came in turn while the controller had neither.
TEST(FoundScenario, AControllerRemembersTheSecondProcessAlsoOfAnActuatorThatIsStarting) {
  EXPECT_EQ(ViolationOf(662601, {2, 3, 4, 5, 7}), "");
}

// Beyond a cut link two controllers each led a part of the machine. The checker took the policy's
// switch of one for ended when the other changed its state.
TEST(FoundScenario, ThePolicyOfEachOfTwoControllersRaisesWhatItLeads) {
  EXPECT_EQ(ViolationOf(92217, {7, 8, 12, 13, 17, 19, 20, 21}), "");
  EXPECT_EQ(ViolationOf(187286, {4, 7, 16, 20, 26, 27, 28, 31, 33}), "");
  EXPECT_EQ(ViolationOf(590686, {3, 4, 6, 7, 10, 12, 14, 15}), "");
  EXPECT_EQ(ViolationOf(817804, {4, 8, 9}), "");
}

// The level was one of another host, or in a file that was lost. The checker held it against the
// controller that had not seen it.
TEST(FoundScenario, ABatteryLevelThatAControllerCannotKnowHoldsBackNoRaise) {
  EXPECT_EQ(ViolationOf(337987, {1, 3, 8, 9, 16}), "");
  EXPECT_EQ(ViolationOf(641015, {7, 11, 17, 19, 20}), "");
}

// Its epoch was lost with its disk. While it waited for the heartbeat of the controller that leads
// its actuators, a person's takeover beyond the cut link became complete; it raised its epoch
// above.
TEST(FoundScenario, ASupervisorUndoesNoTakeoverThatBecomesCompleteMeanwhile) {
  EXPECT_EQ(ViolationOf(121823, {5, 7, 11, 16, 17, 18, 19}), "");
  EXPECT_EQ(ViolationOf(369878, {3, 4, 5, 9}), "");
  EXPECT_EQ(ViolationOf(566195, {1, 10, 14, 16, 17, 18}), "");
}

// After the other controller had ended, the actuator went to the machine's state by itself, and
// counted as well, although it refused each command.
TEST(FoundScenario, AnActuatorThatAnotherControllerHadStaysDegradedUntilItIsRestarted) {
  EXPECT_EQ(ViolationOf(153414, {2, 3, 4, 5}), "");
}

TEST(FoundScenario, ATearDownThatWaitsRefusesTheSwitchThatWaitedBeforeIt) {
  EXPECT_EQ(ViolationOf(642188, {2, 3, 5}), "");
}

// The last samples of /clock before its pause were lost. The checker counted them.
TEST(FoundScenario, AKeepMayCountTheTimeOfSamplesThatWereLostBeforeAPause) {
  EXPECT_EQ(ViolationOf(613754, {1, 2, 6, 7, 8, 10, 11, 12}), "");
}

// It hangs in its TearDown on a host where no controller can kill it, and each start finishes the
// TearDown that it finds. The operator did not end it.
TEST(FoundScenario, AnOperatorEndsAProcessOfAnotherHostThatHangsInItsTearDown) {
  EXPECT_EQ(ViolationOf(719211, {1, 17, 18, 21}), "");
}

// The checker took an epoch for a raise that the disk of a restarted controller had.
TEST(FoundScenario, AControllerThatItsSupervisorRestartsMayHaveAnEpochThatNoPersonHasSeen) {
  EXPECT_EQ(ViolationOf(46300, {2, 7, 9, 10, 11, 12}), "");
}

// The epoch was not on the disk. Of an actuator that had published a false state the latched sample
// of that arrived last, with an older epoch: the denial of the first query was taken for a newer
// controller.
TEST(FoundScenario, AnOlderSampleBeforeTheStartMakesNoControllerReleaseControl) {
  EXPECT_EQ(ViolationOf(715917, {1, 4, 7, 9, 10}), "");
}

// The same at a start by a person: the older sample arrived first, and the denial of the query by
// it was taken for a newer controller. No controller led, and none tore the machine down.
TEST(FoundScenario, AnOlderSampleOfAnActuatorOfItsHostMakesNoStartReleaseControl) {
  EXPECT_EQ(ViolationOf(979865, {2, 4, 13, 15}), "");
}

TEST(FoundScenario, WithAStopThatWasLostOrDidNotHoldHoldsEveryInvariant) {
  simulation::Coverage coverage;
  for (const std::uint64_t seed :
       {190350, 194128, 702025, 224520, 258508, 589031, 694096, 258136}) {
    ExpectInvariantsHold(seed, coverage);
  }
}

// Its host was rebooted while the program published its stop, and the disk had lost that. The
// simulated host named its boot where a real one names its pid namespace.
TEST(FoundScenario, AStopIsNotConfirmedByTheStatusOfAProcessFromBeforeTheReboot) {
  EXPECT_EQ(ViolationOf(190350, {1, 3, 6, 8, 9, 10, 11}), "");
}

// The only actuator that had latched it was killed meanwhile. The program believed its last status
// where the controller, which had an earlier stop, had lost it. The simulated one also believed the
// controller's status from a bridge, and ended before the time of discovery was over.
TEST(FoundScenario, AStopIsNotConfirmedByAnActuatorThatHasEnded) {
  EXPECT_EQ(ViolationOf(702025, {10, 11, 12, 19, 21}), "");
  EXPECT_EQ(ViolationOf(702025, {1, 3, 5, 6, 8, 9, 10, 11, 12, 19, 21, 22}), "");
  EXPECT_EQ(ViolationOf(194128, {2, 3, 5, 6, 7, 9, 10, 12, 13, 14, 15, 17, 19}), "");
}

// The link was cut: it went to DeActive by itself. Then came the fallback's command to Protected.
TEST(FoundScenario, ACommandFromBeforeAnActuatorWentToItsSafeStateSwitchesNothingOn) {
  EXPECT_EQ(ViolationOf(258508, {2, 3}), "");
  EXPECT_EQ(ViolationOf(589031, {3, 4, 5}), "");
}

// The link worked again. The fallback's command came late, and the same one again behind it.
TEST(FoundScenario, ACommandThatWasGivenUpWithItsActuatorDoesNotBeginBesideTheNextOne) {
  EXPECT_EQ(ViolationOf(694096, {2, 3, 4}), "");
}

// It was requested down to Protected, where a stop had left each actuator below. The checker took
// that for a request that switches nothing on, and a start after it for one without a request.
TEST(FoundScenario, ASwitchDownThatSwitchesEachActuatorOnEndsWhatAStopHasLeft) {
  EXPECT_EQ(ViolationOf(224520, {1, 2, 3, 7}), "");
}

// The link repeated or reordered samples: the controller's "engaged" came behind its release.
TEST(FoundScenario, AReleasedStopIsNotEngagedAgainByAnOlderSampleOfItsController) {
  EXPECT_EQ(ViolationOf(873610, {1, 2, 4, 5, 6, 8, 9, 11}), "");
  EXPECT_EQ(ViolationOf(889193, {2, 4, 6, 7, 8}), "");
}

// Its panel still published it, and a start of another user, which believes no release in the first
// one's folder, engaged it again. The first one's next start took over and went to Active.
TEST(FoundScenario, AStopThatAStartOfAnotherUserEngagesAgainWaitsForARequest) {
  EXPECT_EQ(ViolationOf(933738, {3, 7, 8, 14, 15, 31}), "");
}

// A sample of 1 % came during the switch up to Protected, which had begun at 3 %. The checker took
// its level for the one of the decision.
TEST(FoundScenario, ARaiseIsDecidedByTheSamplesBeforeIt) {
  EXPECT_EQ(ViolationOf(929300, {1, 2, 3}), "");
}

// Its process was frozen, and four seconds of permits came at one instant.
TEST(FoundScenario, OfThePermitsThatComeTogetherTheLastOneCounts) {
  EXPECT_EQ(ViolationOf(258136, {2, 3, 5, 6, 7, 10}), "");
}

// It was taken for the second one of a host that had just been rebooted, and was never ended.
TEST(FoundScenario, AFrozenActuatorIsEndedBeforeASecondOneIsTaken) {
  EXPECT_EQ(ViolationOf(735219, {12, 14, 15, 16, 18, 19}), "");
}

// Its Active was superseded by Error, and then its link was cut.
TEST(FoundScenario, AnActuatorThatIsEndedAfterASupersededCommandMakesNoTearDownDone) {
  EXPECT_EQ(ViolationOf(789459, {2, 4, 5}), "");
}

// A fallback to LowPower superseded its switch to Error, after a stop: it would have raised it.
TEST(FoundScenario, AFallbackRaisesNoActuatorOutOfTheStateOfASupersededCommand) {
  EXPECT_EQ(ViolationOf(876412, {7, 8, 9}), "");
}

// It had been about to join when a person set it to Error, and joined without a check afterwards.
TEST(FoundScenario, AnActuatorThatWasSetAloneJoinsNotWithoutItsCheck) {
  EXPECT_EQ(ViolationOf(901546, {3, 4, 8, 11}), "");
}

// The operator of the scenario saw no reason to restart it.
TEST(FoundScenario, AnActuatorWhoseLastStatusIsFalseIsRestartedByThePersonWhoRepairs) {
  EXPECT_EQ(ViolationOf(724248, {20, 22, 23}), "");
}

TEST(FoundScenario, AReleasedStopThatAnActuatorReportsDuringAnotherReleaseIsOver) {
  simulation::Coverage coverage;
  ExpectInvariantsHold(61999, coverage);
}

TEST(Scenario, IsReproducibleToTheByteFromItsSeed) {
  for (const std::uint64_t seed : {3, 14, 159, 265, 358, 979}) {
    const MachineConfig config = SampleConfig(seed);
    const ScenarioId id{seed, std::nullopt};
    EXPECT_EQ(TimelineOf(config, id), TimelineOf(config, id));
  }
}

// A regression: a keep timed by /clock never ended, since nothing publishes /clock.
TEST(Scenario, OfARobotThatUsesTheClockTopicHasASteadyClock) {
  MachineConfig config = SampleConfig(0);
  config.policy.emplace();
  config.clock = ClockSource::kTopic;
  simulation::Injection keep;
  keep.kind = simulation::InjectionKind::kKeep;
  keep.at = std::chrono::seconds(5);
  keep.state = kActive;
  keep.random = 7;  // seconds
  const ScenarioEnd ending = simulation::RunScenario(config, 1, {keep}, OptionsFor(config));
  EXPECT_FALSE(ending.violation) << ending.violation->what;
}

TEST(Scenario, KeepsTheOtherInjectionsUnchangedWhenSomeAreRemoved) {
  const MachineConfig config = SampleConfig(12);
  const Injections all = simulation::SampleInjections(config, 12);
  ASSERT_GE(all.size(), 3U);
  const auto some = simulation::InjectionsOf(config, {12, std::vector<std::size_t>{1, 3}});
  EXPECT_THAT(some.value(), ::testing::ElementsAre(all[0], all[2]));
  EXPECT_FALSE(simulation::InjectionsOf(config, {12, std::vector<std::size_t>{all.size() + 1}}));
}

TEST(Scenarios, DoNotDependOnTheNumberOfThreads) {
  const MachineConfig config = SampleConfig(5);
  const auto one = RunMany(config, OptionsFor(config), 1, 100, 1, {});
  const auto two = RunMany(config, OptionsFor(config), 1, 100, 2, {});
  EXPECT_EQ(one.coverage.Text(), two.coverage.Text());
  EXPECT_EQ(one.rests, two.rests);
  EXPECT_EQ(one.steps, two.steps);
}

TEST(Scenarios, CoverEveryInjectionAndEveryMachinePhase) {
  simulation::Coverage coverage;
  std::array<std::uint64_t, 3> client_ends{};
  std::array<std::uint64_t, 2> client_calls{};
  std::array<std::uint64_t, 2> stop_programs{};
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const MachineConfig config = SampleConfig(seed);
    const ScenarioOptions options = OptionsFor(config);
    const ScenarioEnd ending = RunScenario(
        config, seed, simulation::SampleInjections(config, seed, options.bridges), options);
    coverage.Add(ending.coverage);
    for (std::size_t i = 0; i < 3; ++i) client_ends[i] += ending.client_ends[i];
    for (std::size_t i = 0; i < 2; ++i) client_calls[i] += ending.client_calls[i];
    for (std::size_t i = 0; i < 2; ++i) stop_programs[i] += ending.stop_programs[i];
  }
  // Clients get a reply, one from a successor, one that the outcome is unknown, or none.
  EXPECT_THAT(client_ends, ::testing::Each(::testing::Gt(0U)));
  EXPECT_THAT(client_calls, ::testing::Each(::testing::Gt(0U)));
  EXPECT_THAT(stop_programs, ::testing::Each(::testing::Gt(0U)));
  for (std::size_t kind = 0; kind < simulation::kInjectionKinds; ++kind) {
    const bool of_bridges =
        static_cast<simulation::InjectionKind>(kind) == simulation::InjectionKind::kBridge;
    if (of_bridges && !HasBridges()) continue;
    EXPECT_GT(coverage.Of(static_cast<simulation::InjectionKind>(kind)), 0U)
        << KindName(static_cast<simulation::InjectionKind>(kind));
  }
  for (std::size_t phase = 0; phase < simulation::kMachinePhases; ++phase) {
    EXPECT_GT(
        coverage.Of(simulation::InjectionKind::kSet, static_cast<simulation::MachinePhase>(phase)),
        0U)
        << MachinePhaseName(static_cast<simulation::MachinePhase>(phase));
  }
}

}  // namespace musher::testing::scenario_test
