// Each sentence that the decision code can record, with its event name: record_texts.expected has
// an example of each function of texts.hpp. With MUSHER_UPDATE_GOLDEN=1 in the environment the test
// writes the file instead, to be read before it is committed.

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/lifecycle/machine/report.hpp"
#include "musher/lifecycle/record/texts.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::record_texts_golden_test {

using ::testing::ElementsAreArray;

constexpr Duration kTime = Milliseconds(1500);

// By the name of the function; several for a function with several sentences.
using Examples = std::vector<std::pair<std::string, RecordText>>;

Examples OfTheMachine() {
  using namespace texts;
  return {
      {"ControllerStarted", ControllerStarted(3, 7)},
      {"TearDownResumed", TearDownResumed()},
      {"TearDownResumedBySupervisor", TearDownResumedBySupervisor()},
      {"StageStarted", StageStarted(2)},
      {"ActuatorsSetUp", ActuatorsSetUp(4)},
      {"WaitingForManager", WaitingForManager({"eyes was not set up within 1500 ms"})},
      {"StartUpFailed", StartUpFailed("SelfCheck", "critical legs: joint 7 is hot")},
      {"UnfinishedSwitchFound", UnfinishedSwitchFound("legs in Active", "Protected")},
      {"MixedStatesFound", MixedStatesFound("legs in Active", "Protected")},
      {"MachineUsable", MachineUsable("Active", "")},
      {"MachineUsable", MachineUsable("Active", "eyes: no camera")},
      {"MachineUsableWithoutActive", MachineUsableWithoutActive()},
      {"MachineAdopted", MachineAdopted("Protected")},
      {"InvariantBroken", InvariantBroken("legs: present without a report")},
      {"StopIntentLate", StopIntentLate()},
      {"MachineStopped", MachineStopped(kTime, std::nullopt)},
      {"MachineStopped", MachineStopped(kTime, "legs: its process 12 has not ended")},
      {"ControllerFenced", ControllerFenced(3, "another controller leads with epoch 4")},
      {"EpochRaised", EpochRaised(9, "legs")},
      {"SaveFailed", SaveFailed("epoch", "no space left on device")},
      {"SaveRecovered", SaveRecovered("epoch")},
      {"EmergencyStopEngaged", EmergencyStopEngaged("panel", "a person is near")},
      {"EmergencyStopEngaged", EmergencyStopEngaged("", "")},
      {"EmergencyStopReleased", EmergencyStopReleased("operator")},
      {"FallbackStarted", FallbackStarted("Protected")},
      {"FallbackRefused", FallbackRefused("Protected", "the machine is not set up yet")},
      {"ProcessFound", ProcessFound(12, "legs")},
      {"ProcessSignalled", ProcessSignalled("legs", 12, false)},
      {"ProcessSignalled", ProcessSignalled("legs", 12, true)},
      {"ProcessLeftBehind", ProcessLeftBehind(12, std::nullopt)},
      {"ProcessLeftBehind", ProcessLeftBehind(0, "process 77 of host here")},
      {"MayStillRun", MayStillRun("Active")},
      {"MayStillRun", MayStillRun(std::nullopt)},
      {"MayStillRunOn", MayStillRunOn("there")},
      {"MayStillRunOn", MayStillRunOn("")},
  };
}

Examples OfASwitch() {
  using namespace texts;
  return {
      {"SwitchRequested", SwitchRequested("to Active", "Active")},
      {"SwitchWaiting", SwitchWaiting("to Active", kTime, "legs is busy with LowPower")},
      {"SwitchRefused", SwitchRefused("of eyes to Active", "eyes has no state 'Active'")},
      {"SwitchStarted", SwitchStarted(4, "", "Protected", "Active", 3)},
      {"SwitchStarted", SwitchStarted(4, "eyes", "Protected", "Active", 1)},
      {"SwitchEnded", SwitchEnded(4, SwitchOutcome::kDone, "")},
      {"SwitchEnded", SwitchEnded(4, SwitchOutcome::kDoneDegraded, "eyes: overdue")},
      {"SwitchEnded", SwitchEnded(4, SwitchOutcome::kUndone, "legs: failed")},
      {"SwitchEnded", SwitchEnded(4, SwitchOutcome::kSuperseded, "switch 5 took over")},
      {"RollbackStarted", RollbackStarted(4, 5, 2)},
      {"AnotherFailedFirst", AnotherFailedFirst()},
      {"NeededOneFailed", NeededOneFailed("legs")},
      {"NoLongerAvailable", NoLongerAvailable()},
      {"RefusedByEmergencyStop", RefusedByEmergencyStop()},
      {"RestartedUnchecked", RestartedUnchecked()},
      {"NoStateToGoBackTo", NoStateToGoBackTo()},
      {"NotDrivenBack", NotDrivenBack()},
      {"NoAnswerWithinBudget", NoAnswerWithinBudget()},
      {"BudgetUsedUp", BudgetUsedUp()},
      {"RollbackFailed", RollbackFailed("Protected", "joint 7 is hot")},
      {"RollbackFailed", RollbackFailed("", "has no state to go back to")},
      {"StoppedWhileBusy", StoppedWhileBusy("Walk", "Active")},
      {"StoppedIn", StoppedIn("Walk", "Active")},
  };
}

Examples OfACommand() {
  using namespace texts;
  using Outcome = ActuatorOutcome;
  return {
      {"CommandEnded", CommandEnded("legs", "Active", Outcome::kDone, kTime, "")},
      {"CommandEnded", CommandEnded("legs", "Active", Outcome::kRefused, kTime, "too hot")},
      {"CommandEnded", CommandEnded("legs", "Active", Outcome::kFailed, kTime, "too hot")},
      {"CommandEnded", CommandEnded("legs", "Active", Outcome::kOverdue, kTime, "still busy")},
      {"CommandEnded", CommandEnded("legs", "Active", Outcome::kLost, kTime, kOutOfReach)},
      {"CommandUnanswered", CommandUnanswered("legs", kTime, "Active", true)},
      {"CommandUnanswered", CommandUnanswered("legs", kTime, "Active", false)},
      {"Reported", Reported(Outcome::kFailed, "joint 7 is hot")},
      {"DoneDegraded", DoneDegraded("no camera")},
      {"StillBusy", StillBusy("Active", kTime)},
      {"HadNotStarted", HadNotStarted("Active", kTime)},
      {"ContradictedBy", ContradictedBy("Protected")},
      {"CommandNotDone", CommandNotDone("Active", Outcome::kFailed, "joint 7 is hot")},
      {"FailedLate", FailedLate("joint 7 is hot")},
      {"FoundBusy", FoundBusy("Active", kTime)},
  };
}

Examples OfAnActuator() {
  using namespace texts;
  return {
      {"ActuatorPresent", ActuatorPresent("legs", "SetUp", 12)},
      {"ActuatorPresent", ActuatorPresent("legs", "SetUp", 0)},
      {"ActuatorDrifted", ActuatorDrifted("legs", "Error", std::nullopt)},
      {"ActuatorDrifted", ActuatorDrifted("legs", "Error", "joint 7 is hot")},
      {"ActuatorStarved", ActuatorStarved("legs", "no heartbeat for 300 ms")},
      {"ActuatorRecovered", ActuatorRecovered("legs", "heartbeat received again")},
      {"DuplicateActuator", DuplicateActuator("legs", 77, "there", 12)},
      {"Degraded", Degraded("legs", Killed())},
      {"DependencyDegraded", DependencyDegraded("legs", "it was killed")},
      {"DependencySuspended", DependencySuspended("legs")},
      {"NotUp", NotUp("legs")},
      {"SetUpFailed", SetUpFailed(3009, "joint 7 is hot")},
      {"SetUpTimeout", SetUpTimeout(kTime)},
      {"NodeNotDiscovered", NodeNotDiscovered("/planner", kTime, 0)},
      {"NodeNotDiscovered", NodeNotDiscovered("/planner", kTime, 12)},
      {"NotAnnounced", NotAnnounced("legs", {"walk", "--fast"}, kTime, 12)},
      {"NotAnnouncedBeside", NotAnnouncedBeside("legs", "eyes", kTime, 12)},
      {"TornDownAlone", TornDownAlone()},
      {"SelfCheckMissing", SelfCheckMissing("Error")},
      {"NoState", NoState("Walk")},
      {"HeldIn", HeldIn("Walk", "Active")},
      {"EpochOutOfRange", EpochOutOfRange(kLastEpoch)},
      {"Unhealthy", Unhealthy(Health::kHung, "no heartbeat for 300 ms")},
      {"Unhealthy", Unhealthy(Health::kCrashed, "no heartbeat for 300 ms")},
      {"Unhealthy", Unhealthy(Health::kPartitioned, "no heartbeat for 300 ms")},
      {"HungIn", HungIn("Active", kTime)},
      {"StillHung", StillHung()},
      {"Crashed", Crashed("its process 12 ended")},
      {"Killed", Killed()},
      {"Replaced", Replaced()},
      {"PidUnknown", PidUnknown()},
      {"QueryUnanswered", QueryUnanswered("Active")},
      {"Disconnected", Disconnected(kOutOfReach)},
      {"Disconnected", Disconnected("its node is gone from the graph")},
  };
}

Examples OfAProcess() {
  using namespace texts;
  return {
      {"ProcessStarted", ProcessStarted("legs", 12)},
      {"ProcessExited", ProcessExited("legs", 12, "killed by SIGKILL")},
      {"ProcessExitAssumed", ProcessExitAssumed(12)},
      {"BacktraceStarted", BacktraceStarted("legs", 12)},
      {"BacktraceTaken", BacktraceTaken("legs")},
      {"RestartRequested", RestartRequested("legs")},
      {"RestartScheduled", RestartScheduled("legs", kTime, 1, 5)},
      {"ProcessNotStarted", ProcessNotStarted("no such file")},
      {"Exited", Exited(12, "exit code 0", true, false)},
      {"Exited", Exited(12, "killed by SIGSEGV", false, true)},
      {"RestartPrevented", RestartPrevented("exit code 2", 2, "legs")},
      {"RestartPrevented", RestartPrevented("exit code 7", 7, "legs")},
      {"GivenUp", GivenUp(5, "it was killed")},
      {"GivenUp", GivenUp(5, std::nullopt)},
      {"RestartedTooOften", RestartedTooOften(6, kTime)},
  };
}

Examples OfThePolicy() {
  using namespace texts;
  const std::string battery = "the battery is at 18 %";
  return {
      {"PolicyRequested", PolicyRequested("wake-up", "")},
      {"PolicyRefused", PolicyRefused("wake-up", "the machine is not in LowPower")},
      {"BatterySampleInvalid", BatterySampleInvalid(250)},
      {"BatterySilent", BatterySilent(Milliseconds(10000), 18)},
      {"BatterySilent", BatterySilent(Milliseconds(10000), std::nullopt)},
      {"BatteryResumed", BatteryResumed()},
      {"BatteryChanged",
       BatteryChanged(battery, std::nullopt, BatteryLimit::kLimited, "Protected")},
      {"BatteryChanged", BatteryChanged(battery, false, BatteryLimit::kNoSwitchAbove, "Protected")},
      {"BatteryChanged", BatteryChanged(battery, std::nullopt, BatteryLimit::kLifted, "Active")},
      {"BatteryChanged", BatteryChanged(battery, std::nullopt, BatteryLimit::kEmpty, "")},
      {"BatteryChanged", BatteryChanged(battery, true, BatteryLimit::kAsBefore, "Active")},
      {"BatteryChanged", BatteryChanged(battery, false, BatteryLimit::kAsBefore, "Active")},
      {"BatterySwitchDown", BatterySwitchDown(battery, "Protected")},
      {"BatterySwitchUp", BatterySwitchUp(battery, "Active")},
      {"LyingStill", LyingStill(Milliseconds(30000))},
      {"PolicySwitchRefused", PolicySwitchRefused(LyingStill(Milliseconds(30000)), "busy")},
      {"KeepEnded", KeepEnded("Active", "time expired")},
      {"PowerDownStarted", PowerDownStarted(false)},
      {"PowerDownStarted", PowerDownStarted(true)},
      {"PowerCommandGiven", PowerCommandGiven(false, true, {"systemctl", "poweroff"})},
      {"PowerCommandGiven", PowerCommandGiven(true, false, {})},
      {"PowerTearDownRefused", PowerTearDownRefused("the machine is not set up yet")},
  };
}

Examples All() {
  Examples all;
  for (const auto& some :
       {OfTheMachine(), OfASwitch(), OfACommand(), OfAnActuator(), OfAProcess(), OfThePolicy()}) {
    all.insert(all.end(), some.begin(), some.end());
  }
  return all;
}

std::string ReadText(const std::string& path) {
  std::ifstream file(SourceDir() + "/" + path, std::ios::binary);
  EXPECT_TRUE(file) << path << " cannot be read";
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(RecordTexts, AreThoseOfTheGoldenFile) {
  std::string text;
  for (const auto& [function, example] : All()) {
    text +=
        function + "\n  " + std::string(NameOf(example.event)) + "\n  " + example.message + "\n";
  }
  const std::string file = "test/golden/record_texts.expected";
  if (std::getenv("MUSHER_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(SourceDir() + "/" + file, std::ios::binary) << text;
  }
  EXPECT_EQ(text, ReadText(file));
}

TEST(RecordTexts, HaveAnExampleOfEachFunction) {
  std::set<std::string> functions;
  const std::string header = ReadText("lifecycle/record/texts.hpp");
  const std::string type = "\nRecordText ";
  for (std::size_t at = header.find(type); at != std::string::npos;
       at = header.find(type, at + 1)) {
    const std::size_t begin = at + type.size();
    functions.insert(header.substr(begin, header.find('(', begin) - begin));
  }
  std::set<std::string> examples;
  for (const auto& [function, example] : All()) examples.insert(function);
  EXPECT_THAT(examples, ElementsAreArray(functions));
  EXPECT_GT(functions.size(), 100U);
}

TEST(RecordTexts, HaveAnEventEachAndUseAllThatTheShellDoesNot) {
  std::set<EventName> used = {
      EventName::kNone,          EventName::kUnlistedActuator, EventName::kControllerRemark,
      EventName::kConfigDiffers, EventName::kProcessUnproven,  EventName::kPowerCommandFailed};
  for (const auto& [function, example] : All()) {
    EXPECT_NE(example.event, EventName::kNone) << function;
    used.insert(example.event);
  }
  for (std::size_t i = 0; i < kEventNames.size(); ++i) {
    EXPECT_TRUE(used.contains(static_cast<EventName>(i))) << kEventNames[i];
  }
}

// The rows of "## Events of records".
std::multiset<std::string> EventsInTheReference() {
  std::multiset<std::string> events;
  std::ifstream file(SourceDir() + "/docs/reference.md");
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) inside = line == "## Events of records";
    if (inside && line.starts_with("| `")) events.insert(line.substr(3, line.find('`', 3) - 3));
  }
  return events;
}

TEST(EventNames, AreAllInTheReferenceOnce) {
  const std::multiset<std::string> all(kEventNames.begin() + 1, kEventNames.end());
  EXPECT_THAT(EventsInTheReference(), ElementsAreArray(all));
}

}  // namespace musher::record_texts_golden_test
