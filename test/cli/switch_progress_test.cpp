// The table of a switch, and when it is on the terminal.

#include "musher/cli/commands/switch_progress.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "musher/test/cli/robot.hpp"
#include "musher/transport/sim/sim_loop.hpp"

namespace musher::cli::switch_progress_test {

using std::chrono::seconds;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

msg::ActuatorInfo Actuator(const std::string& name, const std::string& presence,
                           const std::string& state, const std::string& target = "") {
  msg::ActuatorInfo actuator;
  actuator.name = name;
  actuator.presence = presence;
  actuator.state = state;
  actuator.target = target;
  return actuator;
}

msg::MachineStatus OnItsWayToLowPower() {
  msg::MachineStatus machine;
  machine.machine = "dog";
  machine.phase = "running";
  machine.target = "LowPower";
  machine.actuators = {Actuator("legs", "present", "Active", "LowPower"),
                       Actuator("voice", "present", "LowPower"), Actuator("eyes", "lost", "SetUp")};
  return machine;
}

TEST(ProgressTable, ShowsEachActuatorWithItsStateItsTimeAndItsLimit) {
  const ProgressView view{
      OnItsWayToLowPower(), seconds(4), {{"legs", {seconds(3), Milliseconds(5500)}}}};
  EXPECT_EQ(ProgressTable(view, 24, false),
            "LowPower, 4 s: 1 of 3 done\n"
            "ACTUATOR  STATE              TIME\n"
            "legs      Active → LowPower  3 s of 5.5 s\n"
            "voice     LowPower\n"
            "eyes      lost\n");
}

TEST(ProgressTable, ShowsWhichActuatorsArePresentBeforeTheFirstSwitch) {
  msg::MachineStatus machine = OnItsWayToLowPower();
  machine.phase = "starting";
  machine.target.clear();
  machine.actuators = {Actuator("legs", "starting", ""), Actuator("voice", "present", "SetUp"),
                       Actuator("eyes", "absent", "")};
  const ProgressView view{machine, seconds(2), {{"legs", {seconds(2), std::nullopt}}}};
  EXPECT_EQ(ProgressTable(view, 24, false),
            "dog starting, 2 s: 1 of 3 present\n"
            "ACTUATOR  STATE     TIME\n"
            "legs      starting  2 s\n"
            "voice     SetUp\n"
            "eyes      absent\n");
}

TEST(ProgressTable, ShowsOnlyWhatIsUnderWayIfTheTerminalHasNoRoom) {
  msg::MachineStatus machine = OnItsWayToLowPower();
  const std::string two = ProgressTable({machine, {}, {}}, 4, false);
  EXPECT_THAT(two, HasSubstr("\nlegs "));
  EXPECT_THAT(two, Not(HasSubstr("voice")));
  for (int i = 0; i < 9; ++i) machine.actuators.push_back(machine.actuators[0]);
  const std::string many = ProgressTable({machine, {}, {}}, 6, false);
  EXPECT_THAT(many, EndsWith("\nand 7 more\n"));
  EXPECT_EQ(std::count(many.begin(), many.end(), '\n'), 6);
  EXPECT_EQ(ProgressTable({machine, {}, {}}, 3, false), "LowPower, 0 s: 1 of 12 done\n");
}

TEST(ProgressTable, LetsNoNameDriveTheTerminal) {
  msg::MachineStatus machine = OnItsWayToLowPower();
  machine.target = machine.actuators[0].name = "a\x1b[2J\n";
  machine.actuators[1].state = machine.actuators[2].presence = "b\x1b[2J\n";
  EXPECT_THAT(ProgressTable({machine, {}, {}}, 24, false), Not(HasSubstr("\x1b")));
}

class ProgressOfASwitch : public ::testing::Test {
 protected:
  explicit ProgressOfASwitch(Console::Mode mode = {.terminal = true})
      : console_(out_, err_, mode) {}

  // What is printed while this time passes.
  std::string Passes(Duration time) {
    out_.str("");
    loop_.RunUntil([] { return false; }, loop_.Now() + time);
    return out_.str();
  }

  transport::sim::Scheduler scheduler_;
  transport::sim::Links links_;
  transport::sim::SimLoop loop_{scheduler_, scheduler_.AddProcess(), links_, links_.Host("robot")};
  std::ostringstream out_;
  std::ostringstream err_;
  Console console_;
  SwitchProgress progress_{loop_, console_, [](const auto& actuator, const auto& state) {
                             return actuator == "legs" && state == "LowPower"
                                        ? std::optional<Duration>(seconds(5))
                                        : std::nullopt;
                           }};
};

TEST_F(ProgressOfASwitch, IsShownFromHalfASecondOnAndCounts) {
  progress_.Show(OnItsWayToLowPower());
  EXPECT_EQ(Passes(Milliseconds(490)), "");
  EXPECT_THAT(Passes(Milliseconds(20)), HasSubstr("legs      Active → LowPower  0 s of 5 s\n"));
  EXPECT_THAT(Passes(seconds(2)), HasSubstr("legs      Active → LowPower  2 s of 5 s\n"));
}

TEST_F(ProgressOfASwitch, OfHalfASecondIsNotShown) {
  progress_.Show(OnItsWayToLowPower());
  Passes(Milliseconds(490));
  progress_.Show(msg::MachineStatus{});
  EXPECT_EQ(Passes(seconds(9)), "");
}

TEST_F(ProgressOfASwitch, CountsFromTheStartForAnActuatorThatHasReachedItsState) {
  msg::MachineStatus machine = OnItsWayToLowPower();
  progress_.Show(machine);
  Passes(seconds(3));
  machine.actuators[0] = Actuator("legs", "present", "LowPower");
  machine.actuators[1] = Actuator("voice", "present", "Active", "LowPower");
  progress_.Show(machine);
  const std::string text = Passes(seconds(2));
  EXPECT_THAT(text, HasSubstr("LowPower, 5 s: 1 of 3 done\n"));
  EXPECT_THAT(text, HasSubstr("legs      LowPower\n"));
  EXPECT_THAT(text, HasSubstr("voice     Active → LowPower  2 s\n"));
}

TEST_F(ProgressOfASwitch, StaysBelowWhatIsPrintedAndIsErasedAtTheEnd) {
  progress_.Show(OnItsWayToLowPower());
  Passes(seconds(1));
  constexpr const char* kErased = "\r\x1b[K\x1b[A\x1b[K\x1b[A\x1b[K\x1b[A\x1b[K\x1b[A\x1b[K";
  out_.str("");
  console_.Print("legs: a line");
  EXPECT_THAT(out_.str(), ::testing::StartsWith(kErased + std::string("legs: a line\n\x1b[?7l")));
  EXPECT_THAT(out_.str(), EndsWith("eyes      lost\x1b[?7h"));
  out_.str("");
  console_.PrintError("an error");
  EXPECT_THAT(out_.str(), ::testing::StartsWith(kErased));
  EXPECT_EQ(err_.str(), "musher: an error\n");
  out_.str("");
  progress_.Show(std::nullopt);  // its controller is lost
  EXPECT_EQ(out_.str(), kErased);
  console_.Print("the end");
  EXPECT_THAT(out_.str(), EndsWith("\x1b[Kthe end\n"));
}

class ProgressInAPipe : public ProgressOfASwitch {
 protected:
  ProgressInAPipe() : ProgressOfASwitch(Console::Mode{}) {}
};

TEST_F(ProgressInAPipe, IsNotShown) {
  progress_.Show(OnItsWayToLowPower());
  EXPECT_EQ(Passes(seconds(9)), "");
}

class ProgressWithJson : public ProgressOfASwitch {
 protected:
  ProgressWithJson() : ProgressOfASwitch({.json = true, .terminal = true}) {}
};

TEST_F(ProgressWithJson, IsNotPartOfTheDocuments) {
  progress_.Show(OnItsWayToLowPower());
  EXPECT_EQ(Passes(seconds(9)), "");
}

}  // namespace musher::cli::switch_progress_test
