// Each sentence that the decision code can record, with its event name and arguments:
// record_texts.expected has an example of each function of texts.hpp. With MUSHER_UPDATE_GOLDEN=1
// in the environment the test writes the file instead, to be read before it is committed.

#include <gmock/gmock.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/code.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
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
      {"WaitingForManager", WaitingForManager({"eyes: was not set up within 1500 ms"})},
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
      {"OtherMachineSeen", OtherMachineSeen("cat (id 5982c7ee)", "process 7 of host cat", "")},
      {"OtherMachineSeen", OtherMachineSeen("cat", "process 7 of host cat", "fleet")},
      {"UnlistedActuatorFound", UnlistedActuatorFound("wheels", 12, "Active", "robot.toml")},
      {"EmergencyStopEngaged", EmergencyStopEngaged("panel", "a person is near")},
      {"EmergencyStopEngaged", EmergencyStopEngaged("", "")},
      {"EmergencyStopReleased", EmergencyStopReleased("operator")},
      {"StateNotWritable", StateNotWritable("No space left on device")},
      {"ReleaseUnconfirmed", ReleaseUnconfirmed({"legs", "eyes"})},
      {"RuleViolated", RuleViolated("never eyes Active while legs is not Active",
                                    "eyes is in Active, legs is exited")},
      {"RequestRefused", RequestRefused("restart of legs", "it may be late")},
      {"FallbackStarted", FallbackStarted("Protected")},
      {"FallbackRefused", FallbackRefused("Protected", "the machine is not set up yet")},
      {"ProcessFound", ProcessFound(12, "legs")},
      {"ProcessSignalled", ProcessSignalled("legs", 12, false)},
      {"ProcessSignalled", ProcessSignalled("legs", 12, true)},
      {"ProcessLeftBehind", ProcessLeftBehind(12, std::nullopt)},
      {"ProcessLeftBehind", ProcessLeftBehind(0, "process 77 of host here")},
      {"ProcessLeftBehind", ProcessLeftBehind(12, std::nullopt, "vision")},
      {"LeftToOther", LeftToOther(12, "vision", "it follows another machine now, cat")},
      {"HostUnreached", HostUnreached("vision", "no answer within 5 s")},
      {"HostUnreached", HostUnreached("", "eyes.service is about to start")},
      {"MayStillRun", MayStillRun("Active")},
      {"MayStillRun", MayStillRun(std::nullopt)},
      {"MayStillRunOn", MayStillRunOn("there")},
      {"MayStillRunOn", MayStillRunOn("")},
      {"KeepsRunning", KeepsRunning("Active")},
      {"LostWithoutTearDown", LostWithoutTearDown("Active")},
  };
}

Examples OfASwitch() {
  using namespace texts;
  return {
      {"SwitchRequested", SwitchRequested("to Active", "Active")},
      {"SwitchRequested", SwitchRequested("to Active", "Active", "alice@dog1")},
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
      {"ActuatorPresent", ActuatorPresent("legs", "Active", 12, "LowPower")},
      {"ActuatorDrifted", ActuatorDrifted("legs", "Error", std::nullopt)},
      {"ActuatorDrifted", ActuatorDrifted("legs", "Error", "joint 7 is hot")},
      {"ActuatorStarved", ActuatorStarved("legs", "no heartbeat for 300 ms")},
      {"ActuatorRecovered", ActuatorRecovered("legs", "heartbeat received again")},
      {"DuplicateActuator", DuplicateActuator("legs", 77, "there", 12)},
      {"TwoNodes", TwoNodes("two nodes /planner: process 7, which is driven, and process 8")},
      {"ConfigDiffers", ConfigDiffers("legs", "a1b2", "robot.toml", "c3d4")},
      {"Degraded", Degraded("legs", Killed())},
      {"DependencyDegraded", DependencyDegraded("legs", "it was killed")},
      {"DependencySuspended", DependencySuspended("legs")},
      {"NotUp", NotUp("legs")},
      {"SetUpFailed", SetUpFailed(3009, "joint 7 is hot")},
      {"SetUpTimeout", SetUpTimeout(kTime)},
      {"NodeNotDiscovered", NodeNotDiscovered("/planner", kTime, 0)},
      {"NodeNotDiscovered", NodeNotDiscovered("/planner", kTime, 12)},
      {"NotAnnounced",
       NotAnnounced("legs", {"walk", "--fast"}, kTime, 12, StartProgress::kUnknown)},
      {"NotAnnounced", NotAnnounced("legs", {"walk", "--fast"}, kTime, 12, StartProgress::kNamed)},
      {"NotAnnounced", NotAnnounced("legs", {"walk", "--fast"}, kTime, 12, StartProgress::kBusy)},
      {"NotAnnounced", NotAnnounced("legs", {"walk", "--fast"}, kTime, 12, StartProgress::kIdle)},
      {"NotAnnouncedBeside", NotAnnouncedBeside("legs", "eyes", kTime, 12)},
      {"TornDownAlone", TornDownAlone()},
      {"StartedBeside", StartedBeside("arm")},
      {"SelfCheckMissing", SelfCheckMissing("Error")},
      {"NoState", NoState("Walk")},
      {"HeldIn", HeldIn("Walk", "Active")},
      {"FoundBelow", FoundBelow("DeActive", "Active")},
      {"EpochOutOfRange", EpochOutOfRange(kLastEpoch)},
      {"ControlledByAnother", ControlledByAnother(6)},
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
      {"Disconnected", Disconnected("its services are lost")},
  };
}

Examples OfAProcess() {
  using namespace texts;
  return {
      {"ProcessStarted", ProcessStarted("legs", 12)},
      {"ProcessStartedOn", ProcessStartedOn("vision", "legs", 12, false)},
      {"ProcessStartedOn", ProcessStartedOn("vision", "legs", 12, true)},
      {"ProcessExited", ProcessExited("legs", 12, "killed by SIGKILL")},
      {"ProcessExitAssumed", ProcessExitAssumed(12)},
      {"ProcessUnproven", ProcessUnproven("legs", 12, "it is of user 65534")},
      {"BacktraceStarted", BacktraceStarted("legs", 12)},
      {"BacktraceTaken", BacktraceTaken("legs")},
      {"RestartRequested", RestartRequested("legs", "")},
      {"RestartRequested", RestartRequested("legs", "alice@dog1")},
      {"RestartScheduled", RestartScheduled("legs", kTime, 1, 5)},
      {"ProcessNotStarted", ProcessNotStarted("no such file")},
      {"Exited", Exited(12, "exit code 0", true, false)},
      {"Exited", Exited(12, "killed by SIGSEGV", false, true)},
      {"RestartPrevented", RestartPrevented("exit code 2", 2, "legs")},
      {"RestartPrevented", RestartPrevented("exit code 7", 7, "legs")},
      {"GivenUp", GivenUp("legs", 5, "it was killed")},
      {"GivenUp", GivenUp("legs", 5, std::nullopt)},
      {"GivenUpBefore", GivenUpBefore("Active")},
      {"GivenUpBefore", GivenUpBefore("")},
      {"RestartedTooOften", RestartedTooOften(6, kTime)},
  };
}

Examples OfThePolicy() {
  using namespace texts;
  return {
      {"PolicyRequested", PolicyRequested("wake-up", "")},
      {"PolicyRequested", PolicyRequested("switch to Active", "Active")},
      {"PolicyRequested", PolicyRequested("wake-up", "", "alice@dog1")},
      {"PolicyRefused", PolicyRefused("wake-up", "the machine is not in LowPower")},
      {"BatterySampleInvalid", BatterySampleInvalid(250)},
      {"BatteryJumped", BatteryJumped(80, 0)},
      {"BatteryDoubled", BatteryDoubled("bms_status", 2, 15, 80)},
      {"BatterySilent", BatterySilent(Milliseconds(10000), 18)},
      {"BatterySilent", BatterySilent(Milliseconds(10000), std::nullopt)},
      {"BatterySilent", BatterySilent(Milliseconds(10000), std::nullopt, true)},
      {"BatteryResumed", BatteryResumed()},
      {"BatteryLimitsStart", BatteryLimitsStart("the battery is at 15 %: …", "DeActive")},
      {"BatteryChanged",
       BatteryChanged(18, false, std::nullopt, BatteryLimit::kLimited, "Protected")},
      {"BatteryChanged",
       BatteryChanged(18, false, false, BatteryLimit::kNoSwitchAbove, "Protected")},
      {"BatteryChanged", BatteryChanged(18, false, std::nullopt, BatteryLimit::kLifted, "Active")},
      {"BatteryChanged", BatteryChanged(18, false, std::nullopt, BatteryLimit::kEmpty, "")},
      {"BatteryChanged", BatteryChanged(18, false, true, BatteryLimit::kAsBefore, "Active")},
      {"BatteryChanged", BatteryChanged(18, false, false, BatteryLimit::kAsBefore, "Active")},
      {"BatterySwitchDown", BatterySwitchDown(18, true, "Protected")},
      {"BatterySwitchUp", BatterySwitchUp(18, false, "Active")},
      {"LyingStill", LyingStill(Milliseconds(30000))},
      {"PolicySwitchRefused", PolicySwitchRefused(LyingStill(Milliseconds(30000)), "busy")},
      {"KeepEnded", KeepEnded("Active", "time expired")},
      {"PowerDownStarted", PowerDownStarted(false)},
      {"PowerDownStarted", PowerDownStarted(true)},
      {"PowerCommandGiven", PowerCommandGiven(false, true, {"systemctl", "poweroff"})},
      {"PowerCommandGiven", PowerCommandGiven(true, false, {})},
      {"PowerCommandFailed", PowerCommandFailed("reboot", "failed: exit code 1")},
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

// actuator = "legs", pid = 12
std::string ArgumentsOf(const RecordText& text) {
  std::string list;
  for (const Argument& argument : text.arguments) {
    const bool is_text = std::holds_alternative<std::string>(argument.value);
    const std::string value = ArgumentOf(text.arguments, argument.name);
    list += (list.empty() ? "" : ", ") + std::string(argument.name) + " = " +
            (is_text ? '"' + value + '"' : value);
  }
  return list;
}

TEST(RecordTexts, AreThoseOfTheGoldenFile) {
  std::string text;
  for (const auto& [function, example] : All()) {
    text +=
        function + "\n  " + std::string(NameOf(example.event)) + "\n  " + example.message + "\n";
    if (!example.arguments.empty()) text += "    " + ArgumentsOf(example) + "\n";
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

TEST(RecordTexts, HaveAnEventEachAndUseAll) {
  std::set<EventName> used = {EventName::kNone, EventName::kControllerRemark};
  for (const auto& [function, example] : All()) {
    EXPECT_NE(example.event, EventName::kNone) << function;
    used.insert(example.event);
  }
  for (std::size_t i = 0; i < kEventNames.size(); ++i) {
    EXPECT_TRUE(used.contains(static_cast<EventName>(i))) << kEventNames[i];
  }
}

// The rows of "## Events of records".
std::vector<std::string> EventRows() {
  std::vector<std::string> rows;
  std::ifstream file(SourceDir() + "/docs/reference.md");
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) inside = line == "## Events of records";
    if (inside && line.starts_with("| `")) rows.push_back(line);
  }
  return rows;
}

std::string FirstCode(const std::string& row) {
  return row.substr(3, row.find('`', 3) - 3);
}

TEST(EventNames, AreAllInTheReferenceOnce) {
  std::multiset<std::string> events;
  for (const std::string& row : EventRows()) events.insert(FirstCode(row));
  const std::multiset<std::string> all(kEventNames.begin() + 1, kEventNames.end());
  EXPECT_THAT(events, ElementsAreArray(all));
}

// The last column of these rows: the arguments of all sentences of the event.
std::map<std::string, std::set<std::string>> ArgumentsInTheReference() {
  std::map<std::string, std::set<std::string>> arguments;
  for (const std::string& row : EventRows()) {
    std::set<std::string>& names = arguments[FirstCode(row)];
    const std::string last = row.substr(row.rfind('|', row.size() - 2));
    for (std::size_t at = last.find('`'); at != std::string::npos;) {
      const std::size_t end = last.find('`', at + 1);
      names.insert(last.substr(at + 1, end - at - 1));
      at = last.find('`', end + 1);
    }
  }
  return arguments;
}

// Functions whose text is a part of another record, never a record of its own.
const std::set<std::string>& InsideOthers() {
  static const std::set<std::string> functions = {
      "AnotherFailedFirst", "BudgetUsedUp",      "ContradictedBy",       "DoneDegraded",
      "HadNotStarted",      "NeededOneFailed",   "NoAnswerWithinBudget", "NotDrivenBack",
      "Reported",           "RestartedUnchecked"};
  return functions;
}

TEST(EventNames, HaveTheirArgumentsInTheReference) {
  std::map<std::string, std::set<std::string>> all;
  for (const std::string_view event : kEventNames) all[std::string(event)];
  for (const auto& [function, example] : All()) {
    if (InsideOthers().contains(function)) continue;
    for (const Argument& argument : example.arguments) {
      if (argument.name != "actuator")
        all[std::string(NameOf(example.event))].emplace(argument.name);
    }
  }
  all.erase("");
  EXPECT_EQ(ArgumentsInTheReference(), all);
}

}  // namespace musher::record_texts_golden_test
