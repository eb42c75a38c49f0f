// What people see, to the letter.

#include "musher/cli/render/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <ctime>
#include <functional>

#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts
#include "musher/test/cli/robot.hpp"

namespace musher::cli::text_test {

class Text : public ::testing::Test {
 protected:
  Text() {
    setenv("TZ", "UTC", 1);
    tzset();
  }
};

TEST_F(Text, ShowsTheStatusAsATable) {
  EXPECT_EQ(
      StatusText(RobotStatus(), false),
      "dog  Active → LowPower  (running)  namespace pack  controller 100, epoch 3, switch 12\n"
      "degraded: eyes\n"
      "ACTUATOR  STATE   STAGE  PID  NOTE\n"
      "legs*     Active  1      101  → LowPower\n"
      "eyes      SetUp   2      -    held; restarting, 2nd time; crashed: gone  "
      "(107 Robot: Timeout)\n");
}

TEST_F(Text, SaysSinceWhenAndWhatItsMarksMean) {
  const msg::MachineStatus status = RobotStatus();
  EXPECT_EQ(StatusText(status, false, {75.0, 7200.0}).substr(0, 85),
            "dog  Active → LowPower  (running)  for 75 s  namespace pack  controller 100 up 2 h,");
  EXPECT_EQ(StatusLegend(status, false),
            "* critical: without it the machine does not become Active\n"
            "held: switched alone, until the next switch of all\n");
  EXPECT_EQ(StatusLegend({}, false), "");
}

TEST_F(Text, IsCalmAboutAMachineThatIsWell) {
  msg::MachineStatus status = RobotStatus();
  status.target.clear();
  status.degraded.clear();
  status.actuators.pop_back();
  status.actuators[0].target.clear();
  EXPECT_EQ(StatusText(status, false),
            "dog  Active  (running)  namespace pack  controller 100, epoch 3, switch 12\n"
            "ACTUATOR  STATE   STAGE  PID  NOTE\n"
            "legs*     Active  1      101\n");
}

// `musher status --failed` printed the head of a table without a row.
TEST_F(Text, SaysThatNoActuatorHasFailed) {
  msg::MachineStatus status = RobotStatus();
  status.actuators.clear();
  EXPECT_TRUE(StatusText(status, false).ends_with("\nall actuators are present and well\n"));
}

TEST_F(Text, NamesTheProcessesOfAnotherDdsWithTheCure) {
  msg::MachineStatus status = RobotStatus();
  status.other_vendors = {"process 812 of host dog1 runs Fast DDS"};
  EXPECT_THAT(
      StatusText(status, false),
      ::testing::HasSubstr("process 812 of host dog1 runs Fast DDS: its topics work, its services, "
                           "actions and parameters do not; start it with "
                           "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp\n"));
}

TEST_F(Text, NamesTheRulesThatAreViolated) {
  msg::MachineStatus status = RobotStatus();
  status.violated_rules = {"never eyes Active while legs is exited"};
  EXPECT_THAT(StatusText(status, false),
              ::testing::HasSubstr("\na rule of yours is violated: never eyes Active while legs is "
                                   "exited\n"));
  EXPECT_THAT(StatusLine(status, 0),
              ::testing::HasSubstr("  rule violated: never eyes Active while legs is exited"));
}

// The note of its row was "held by the stop", as if it stood.
TEST_F(Text, NamesTheActuatorsThatHaveNotStopped) {
  msg::MachineStatus status = RobotStatus();
  status.emergency_stop = true;
  status.not_stopped = {"legs: the brake does not answer"};
  EXPECT_THAT(StatusText(status, false),
              ::testing::HasSubstr("\nNOT STOPPED: legs: the brake does not answer\n"));
  EXPECT_THAT(StatusLine(status, 0),
              ::testing::HasSubstr("  NOT STOPPED: legs: the brake does not answer"));
}

TEST_F(Text, ShowsThePolicyOnOneLine) {
  msg::MachineStatus status = RobotStatus();
  status.policy.active = true;
  EXPECT_EQ(StatusText(status, false).find("battery"), std::string::npos) << "not known yet";
  status.policy.battery = 80;
  status.policy.charging = true;
  status.policy.low_power_switch = true;
  EXPECT_NE(
      StatusText(status, false)
          .find(
              "\nthe battery is at 80 %, being charged; automatic LowPower when lying still: on\n"),
      std::string::npos);
  status.policy.ceiling = "Protected";
  status.policy.ceiling_reason = "the battery is at 15 %: the machine is limited to Protected";
  status.policy.battery_silent = true;
  status.policy.kept = "Active";
  status.policy.keep_s = 60;
  status.policy.low_power_switch = false;
  status.policy.power = "power-off";
  const std::string line =
      "the battery is at 15 %: the machine is limited to Protected; no battery status received; "
      "kept in Active for 60 s; power-off is under way";
  EXPECT_NE(StatusText(status, false).find("\n" + line + "\n"), std::string::npos);
  EXPECT_NE(StatusLine(status, 0).find("  " + line), std::string::npos);
}

class Note : public Text {
 protected:
  // What is said about the legs, if they are so.
  static std::string Of(const std::function<void(msg::ActuatorInfo&)>& change) {
    msg::MachineStatus status;
    msg::ActuatorInfo legs = RobotStatus().actuators[0];
    legs.target.clear();
    change(legs);
    status.actuators = {legs};
    const std::string text = StatusText(status, false);
    const std::string line = text.substr(text.find("\nlegs") + 1);
    return line.substr(line.find("101") + 3);
  }
};

TEST_F(Note, BeginsWithTheHealthOfAnActuatorThatIsNotWell) {
  EXPECT_EQ(Of([](auto& legs) { legs.health = "starved"; }), "  starved\n");
  EXPECT_EQ(Of([](auto& legs) {
              legs.health = "hung";
              legs.presence = "lost";
              legs.degraded = true;
              legs.code = 105;
              legs.message = "hung: it is silent";
            }),
            "  hung: it is silent (105 Robot: NetError)\n");
  EXPECT_EQ(Of([](auto& legs) {
              legs.degraded = true;
              legs.code = 105;
              legs.message = "no";
            }),
            "  degraded: no (105 Robot: NetError)\n");
}

TEST_F(Note, CountsRestarts) {
  EXPECT_EQ(Of([](auto& legs) { legs.restarts = 1; }), "  1 restart\n");
  EXPECT_EQ(Of([](auto& legs) { legs.restarts = 12; }), "  12 restarts\n");
  const auto restarting = [](int times) {
    return Of([times](auto& legs) {
      legs.restarting = true;
      legs.presence = "starting";
      legs.restarts = times;
    });
  };
  EXPECT_EQ(restarting(0), "  restarting\n");
  EXPECT_EQ(restarting(1), "  restarting\n");
  EXPECT_EQ(restarting(2), "  restarting, 2nd time\n");
  EXPECT_EQ(restarting(3), "  restarting, 3rd time\n");
  EXPECT_EQ(restarting(11), "  restarting, 11th time\n");
  EXPECT_EQ(restarting(21), "  restarting, 21st time\n");
}

TEST_F(Text, PutsAnEmergencyStopBeforeEverythingElse) {
  msg::MachineStatus status = RobotStatus();
  status.emergency_stop = true;
  status.emergency_stop_by = "alice@desk";
  status.emergency_stop_reason = "smoke\n";
  EXPECT_NE(StatusText(status, false)
                .find("switch 12\nEMERGENCY STOP by alice@desk: smoke ; no upward switch until "
                      "`musher estop --release`\ndegraded: eyes\n"),
            std::string::npos);
  EXPECT_NE(StatusLine(status, 0).find("  EMERGENCY STOP by alice@desk: smoke "),
            std::string::npos);
}

TEST_F(Text, ShowsTheActuatorsHeldByAStopAlsoAfterItsRelease) {
  msg::MachineStatus status = RobotStatus();
  status.held_by_stop = {"legs"};
  EXPECT_NE(StatusText(status, false)
                .find("\nstill held by the released emergency stop: legs; `musher set Active` "
                      "ends that\n"),
            std::string::npos);
  EXPECT_NE(StatusText(status, false).find("held by the stop"), std::string::npos);
  EXPECT_NE(StatusLine(status, 0).find("  still held by the released emergency stop: legs"),
            std::string::npos);
  status.emergency_stop = true;
  EXPECT_EQ(StatusText(status, false).find("released emergency stop"), std::string::npos);
  EXPECT_NE(StatusText(status, false).find("held by the stop"), std::string::npos);
}

TEST_F(Text, ReportsWhatIsNotOnDiskYet) {
  msg::MachineStatus status = RobotStatus();
  status.not_on_disk = {"emergency stop (4 s)", "policy (1 s): no space"};
  EXPECT_NE(StatusText(status, false)
                .find("\nnot on disk yet: emergency stop (4 s), policy (1 s): no space\n"),
            std::string::npos);
  EXPECT_NE(StatusLine(status, 0).find("  not on disk yet: emergency stop (4 s), "),
            std::string::npos);
}

TEST_F(Text, ShowsAfterAReleaseTheMachinesStateAndTheNextStep) {
  msg::MachineStatus status = RobotStatus();
  status.degraded.clear();
  EXPECT_EQ(ReleaseText(status, false),
            "emergency stop released; states are unchanged\n"
            "dog is in Active (running); `musher set STATE` switches it\n");
  status.degraded = {"eyes"};
  EXPECT_NE(
      ReleaseText(status, false).find("`musher set Active` recovers the degraded actuators: eyes"),
      std::string::npos);
  status.held_by_stop = {"legs", "eyes"};
  EXPECT_NE(ReleaseText(status, false)
                .find("held by the stop until `musher set Active`: legs, "
                      "eyes\n"),
            std::string::npos);
  status.phase = "failed";
  EXPECT_NE(ReleaseText(status, false).find("`musher set SelfCheck`, then `musher set Active`"),
            std::string::npos);
}

TEST_F(Text, ReportsAnActuatorThatIsPresentAgain) {
  msg::ActuatorInfo legs = RobotStatus().actuators[0];
  EXPECT_EQ(RestartText(legs, false), "legs is back in Active (pid 101)\n");
  legs.pid = 0;  // not known, as of a process on a host that is not reached
  EXPECT_EQ(RestartText(legs, false), "legs is back in Active\n");
}

TEST_F(Text, ColoursStates) {
  const std::string text = StatusText(RobotStatus(), true);
  EXPECT_NE(text.find("\x1b[32mActive\x1b[0m"), std::string::npos) << text;
  EXPECT_NE(text.find("\x1b[31mdegraded: eyes\x1b[0m"), std::string::npos) << text;
}

TEST_F(Text, ShowsTheStatusOnALineForLogs) {
  EXPECT_EQ(StatusLine(RobotStatus(), 0),
            "00:00:00.000  dog  Active → LowPower  (running, switch 12)  busy: legs: LowPower  "
            "degraded: eyes (restarting)");
}

TEST_F(Text, ShowsASwitchAndWhyItIsNotDone) {
  msg::SetState::Response result{12,
                                 "Active",
                                 "",
                                 "undone",
                                 107,
                                 "eyes: no",
                                 "LowPower",
                                 {},
                                 {{"legs", "undone", 0, "is back in LowPower", 12.34, "LowPower"},
                                  {"eyes", "refused", 3003, "", 0, "LowPower"}}};
  EXPECT_EQ(SwitchText(result, false),
            "undone: the machine is in LowPower (switch 12)\n"
            "ACTUATOR  OUTCOME  TOOK     STATE     NOTE\n"
            "legs      undone   12.3 ms  LowPower  is back in LowPower\n"
            "eyes      refused  -        LowPower  (3003 MotionManager: StateInvalid)\n");
  EXPECT_EQ(SwitchError(result), "Active is undone: eyes: no");
}

TEST_F(Text, ShowsARefusedSwitchOfOneActuator) {
  msg::SetState::Response refusal;
  refusal.target = "Active";
  refusal.actuator = "eyes";
  refusal.outcome = "refused";
  refusal.code = 111;
  refusal.state = "SetUp";
  EXPECT_EQ(SwitchText(refusal, false), "refused: eyes is in SetUp\n");
  refusal.state.clear();  // there is no such actuator
  EXPECT_EQ(SwitchText(refusal, false), "refused: nothing switched\n");
  EXPECT_EQ(SwitchError(refusal), "eyes to Active is refused: 111 (Robot: TargetBusy)");
}

TEST_F(Text, ShowsAPlanInTheOrderOfItsWaves) {
  msg::GetPlan::Response plan{"LowPower",
                              "",
                              true,
                              0,
                              "",
                              "down",
                              "Active",
                              {{"voice", 0, "Active", "", 0, "does not list it"},
                               {"legs", 2, "Active", "LowPower", 500, ""},
                               {"eyes", 1, "Active", "LowPower", 50, ""}}};
  EXPECT_EQ(PlanText(plan, false),
            "Active → LowPower  (down)\n"
            "WAVE  ACTUATOR  FROM    TO        DEADLINE  NOTE\n"
            "1     eyes      Active  LowPower  0.05 s\n"
            "2     legs      Active  LowPower  0.5 s\n"
            "-     voice     Active                      does not list it\n");
}

TEST_F(Text, ShowsWhatTheRobotCanDoAndWhyNot) {
  const msg::Capability walk{"walk", "", true, 0, "", {"legs"}, {"Active", "Protected"}};
  const msg::Capability flip{"back_flip",
                             "a somersault backwards",
                             false,
                             113,
                             "back_flip runs in Active only; legs is in Protected",
                             {"legs", "eyes"},
                             {"Active"}};
  EXPECT_EQ(CapabilitiesText({{walk, flip}}, false),
            "CAPABILITY  ALLOWED  RUNS IN            REASON\n"
            "walk        yes      Active, Protected\n"
            "back_flip   no       Active             back_flip runs in Active only; legs is in "
            "Protected (113 Robot: ProtectedError)\n");
  EXPECT_EQ(CapabilityText(flip, false),
            "back_flip  refused: back_flip runs in Active only; legs is in Protected (113 Robot: "
            "ProtectedError)\n"
            "  a somersault backwards\n"
            "  actuators: legs, eyes; runs in: Active\n");
  EXPECT_EQ(CapabilityText(walk, false),
            "walk  allowed\n  actuators: legs; runs in: Active, Protected\n");
  EXPECT_EQ(CapabilitiesText({}, false), "the config declares no capabilities\n");
}

TEST_F(Text, NamesTheEmptyStateAndTheUnknownActuatorThatAPersonGave) {
  msg::SetState::Response refusal;
  refusal.outcome = "refused";
  refusal.reason = "unknown state ''";
  EXPECT_EQ(SwitchError(refusal), "'' is refused: unknown state ''");
  msg::GetPlan::Response plan;
  plan.target = "Active";
  plan.actuator = "nix";
  plan.reason = "no actuator 'nix'";
  EXPECT_EQ(PlanText(plan, false), "nix: Active  would be refused: no actuator 'nix'\n");
  EXPECT_EQ(PlanError(plan), "nix to Active would be refused: no actuator 'nix'");
}

TEST_F(Text, ShowsTheRestartsOfAnActuatorThatIsGivenUpOnce) {
  msg::MachineStatus status = RobotStatus();
  status.actuators[1] = {};
  status.actuators[1].name = "eyes";
  status.actuators[1].presence = "absent";
  status.actuators[1].degraded = true;
  status.actuators[1].health = "crashed";
  status.actuators[1].restarts = 5;
  status.actuators[1].message =
      "given up after 5 restarts, until `musher restart eyes`; crashed: its process 7 ended: exit "
      "code 1";
  EXPECT_THAT(StatusText(status, false),
              ::testing::HasSubstr("  given up after 5 restarts, until `musher restart eyes`; "
                                   "crashed: its process 7 ended: exit code 1\n"));
}

TEST_F(Text, ShowsWhyAPlanWouldBeRefused) {
  msg::GetPlan::Response plan;
  plan.target = "OTA";
  plan.actuator = "eyes";
  plan.code = 103;
  plan.reason = "no way";
  plan.state = "Error";
  EXPECT_EQ(PlanText(plan, false),
            "eyes: Error → OTA  would be refused: no way (103 Robot: StateInvalid)\n");
}

TEST_F(Text, ShowsABacktraceBelowItsSentenceAndNoJson) {
  msg::HistoryEntry hung{1, 0, 3, 0, "process", "legs", 0, "backtrace of legs:"};
  hung.data = "TID 7:\n#0  read\n";
  EXPECT_EQ(HistoryText({hung}, false),
            "1970-01-01 00:00:00.000  process  backtrace of legs:\n"
            "    TID 7:\n"
            "    #0  read\n");
  hung.data = R"({"lost":1})";
  EXPECT_EQ(HistoryText({hung}, false), "1970-01-01 00:00:00.000  process  backtrace of legs:\n");
}

TEST_F(Text, ShowsHistoryAndProgressALineEach) {
  EXPECT_EQ(HistoryText({{1, 1'000'000, 3, 0, "machine", "", 0, "begins"},
                         {2, 2'000'000, 3, 1, "switch", "", 107, "ends\n"}},
                        false),
            "1970-01-01 00:00:00.001  machine  begins\n"
            "1970-01-01 00:00:00.002  switch   ends  (107 Robot: Timeout)\n");
  EXPECT_EQ(ProgressText({3'000'000, "process", "legs", 0, 0, "started"}, false),
            "00:00:00.003  started\n");
}

TEST_F(Text, DoesNothingToATerminalWhateverNamesAndStatesSay) {
  constexpr const char* kWindowTitle = "\x1b]0;gone\a";
  msg::MachineStatus status = RobotStatus();
  status.machine = status.state = status.target = status.phase = kWindowTitle;
  status.degraded = {kWindowTitle};
  status.actuators[0].name = status.actuators[0].state = kWindowTitle;
  msg::SetState::Response result;
  result.outcome = result.state = kWindowTitle;
  msg::GetPlan::Response plan;
  plan.state = plan.target = plan.direction = kWindowTitle;
  msg::HistoryEntry entry;
  entry.kind = kWindowTitle;
  for (const std::string& text :
       {StatusText(status, false), StatusLine(status, 0), ReleaseText(status, false),
        RestartText(status.actuators[0], false), SwitchText(result, false), PlanText(plan, false),
        HistoryText({entry}, false)}) {
    EXPECT_EQ(text.find_first_of("\x1b\a"), std::string::npos) << text;
  }
}

TEST_F(Text, CountsWhatAConfigHas) {
  EXPECT_EQ(ConfigSummary(RobotConfig()), "2 actuators, 6 states, 2 stages");
  MachineConfig one = RobotConfig();
  one.actuators.resize(1);
  EXPECT_EQ(ConfigSummary(one), "1 actuator, 6 states, 1 stage");
}

}  // namespace musher::cli::text_test
