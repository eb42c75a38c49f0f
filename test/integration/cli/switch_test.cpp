// Switching a machine from the command line: outcomes, exit codes, and what --json says.

#include <signal.h>

#include "musher/test/integration/cli/machine.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::testing::switch_test {

using ::testing::HasSubstr;

class Set : public MachineByCli {
 protected:
  // Starts the machine and waits until its second stage is started, too.
  void Start() {
    up_ = std::make_unique<Process>(Command({"up", config_}));
    ASSERT_NE(up_->LineWith("eyes: Active done"), "");
  }
  std::unique_ptr<Process> up_;
};

TEST_F(Set, SwitchesTheMachineAndReportsEachActuatorsOutcome) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPower", "--json"});
  EXPECT_EQ(set.exit, 0) << set.err;
  EXPECT_EQ(set.err, "");
  const auto result = Json(set.out);
  EXPECT_EQ(result["target"], "LowPower");
  EXPECT_EQ(result["outcome"], "done");
  EXPECT_EQ(result["code"], 0);
  EXPECT_EQ(result["state"], "LowPower");
  EXPECT_GT(result["switch"], 0);
  for (const char* actuator : {"legs", "voice", "eyes"}) {
    EXPECT_EQ(result["actuators"][actuator]["outcome"], "done") << actuator;
    EXPECT_EQ(result["actuators"][actuator]["state"], "LowPower") << actuator;
    EXPECT_GT(result["actuators"][actuator]["duration_ms"], 0) << actuator;
  }
}

// Also when it is restarted before the slow actuator has switched.
TEST_F(Set, IsNotDoneWhenAnActuatorExitsAfterItsSwitchWhileASlowOneStillSwitches) {
  Blocks("voice", "LowPower");
  ASSERT_NO_FATAL_FAILURE(Start());
  Process set(Command({"set", "LowPower", "--json"}));
  const auto part_done = AwaitStatus([](const nlohmann::json& status) {
    return status["actuators"]["legs"]["state"] == "LowPower";
  });
  kill(part_done["actuators"]["legs"]["pid"].get<pid_t>(), SIGKILL);
  AwaitStatus([](const nlohmann::json& status) {
    const auto& legs = status["actuators"]["legs"];
    return legs["restarts"] == 1 && legs["presence"] == "present";
  });
  Release();
  const Ended ended = set.Wait();
  EXPECT_EQ(ended.exit, 1);
  EXPECT_THAT(ended.err, HasSubstr("legs: it has switched to SetUp since"));
  const auto result = Json(ended.out);
  EXPECT_EQ(result["outcome"], "done-degraded");
  EXPECT_EQ(result["actuators"]["legs"]["outcome"], "lost") << result;
  const auto back = AwaitStatus(AllHaveArrived);
  EXPECT_EQ(back["actuators"]["legs"]["state"], "LowPower");
}

TEST_F(Set, SwitchesOneActuatorWhichThenIsHeld) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPower", "voice"});
  EXPECT_EQ(set.exit, 0) << set.err;
  EXPECT_THAT(set.out, HasSubstr("done: voice is in LowPower"));
  const auto status = Status();
  EXPECT_EQ(status["state"], "Active");
  EXPECT_EQ(status["actuators"]["voice"]["held"], true);
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("held"));
}

TEST_F(Set, ExitsWithTwoAndAReasonWhenTheMachineHasNoSuchStateOrActuator) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPwer", "--json"});
  EXPECT_EQ(set.exit, 2);
  EXPECT_THAT(set.err, HasSubstr("did you mean 'LowPower'?"));
  const auto result = Json(set.out);
  EXPECT_EQ(result["outcome"], "refused");
  EXPECT_NE(result["code"], 0);
  EXPECT_EQ(result["state"], "Active");
  const Ended unknown = Musher({"set", "Active", "tail"});
  EXPECT_EQ(unknown.exit, 2);
  EXPECT_EQ(unknown.out, "refused: nothing switched\n");
  EXPECT_EQ(unknown.err,
            "musher: tail to Active is refused: there is no actuator 'tail'; there are legs, voice "
            "and eyes\n");
  EXPECT_THAT(Musher({"set", "legs", "Active"}).err,
              HasSubstr("there is no actuator 'Active', but a state: `musher set STATE ACTUATOR`"));
  EXPECT_THAT(Musher({"plan", "Active", "leg"}).err,
              HasSubstr("there is no actuator 'leg'; did you mean 'legs'? There are legs, voice "));
  EXPECT_EQ(Musher({"set", std::string(100'000, 'x')}).exit, 2);
  for (const std::vector<std::string>& words : {std::vector<std::string>{"set", "Active", "leg"},
                                                {"plan", "Active", "leg"},
                                                {"wait", "Active", "leg"},
                                                {"restart", "leg"},
                                                {"describe", "leg"},
                                                {"logs", "leg"},
                                                {"history", "--actuator", "leg"},
                                                {"behavior", "leg"},
                                                {"behavior", "leg", "--tree"}}) {
    const Ended ended = Musher(words);
    EXPECT_EQ(ended.exit, 2) << words[0] << ": " << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("did you mean 'legs'?")) << words[0];
  }
  EXPECT_EQ(Status()["state"], "Active");
}

TEST_F(Set, ExitsWithOneWhenItIsUndone) {
  Does("voice", "module = 5000\n[state.Active]\nshell = \"test ! -e " + (folder_ / "mute") +
                    " || exit 1\"\n");
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  std::ofstream(folder_ / "mute") << "yes";
  const Ended set = Musher({"set", "Active", "--json"});
  EXPECT_EQ(set.exit, 1);
  EXPECT_THAT(set.err, HasSubstr("Active is undone: voice: failed with 5001"));
  const auto result = Json(set.out);
  EXPECT_EQ(result["outcome"], "undone");
  EXPECT_EQ(result["code"], 5001);
  EXPECT_EQ(result["state"], "LowPower");
  EXPECT_EQ(result["actuators"]["legs"]["state"], "LowPower");
}

TEST_F(Set, ExitsWithOneWhenItIsDoneDegraded) {
  Does("voice", "[state.LowPower]\nrun = [\"false\"]\n");
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPower", "--json"});
  EXPECT_EQ(set.exit, 1);
  const auto result = Json(set.out);
  EXPECT_EQ(result["outcome"], "done-degraded");
  EXPECT_EQ(result["state"], "LowPower");
  EXPECT_EQ(result["degraded"], nlohmann::json::array({"voice"}));
  EXPECT_THAT(Musher({"status"}).out, HasSubstr("degraded: voice"));
}

TEST_F(Set, ExitsWithFourAndTheNumberOfTheSwitchThatContinues) {
  Blocks("legs", "LowPower");
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPower", "--timeout", "5", "--json"});
  EXPECT_EQ(set.exit, 4);
  EXPECT_THAT(set.err, HasSubstr("did not answer within 5 s; switch "));
  const auto failure = Json(set.out);
  EXPECT_THAT(failure["error"].get<std::string>(), HasSubstr("continues"));
  EXPECT_EQ(failure["code"], 107);
  const std::string number = std::to_string(failure["switch"].get<int>());
  Release();
  EXPECT_NE(up_->LineWith("switch " + number + " is done"), "");
  EXPECT_EQ(Status()["state"], "LowPower");
}

TEST_F(Set, ShowsOnATerminalWhichActuatorsAreStillSwitching) {
  Blocks("legs", "LowPower");
  ASSERT_NO_FATAL_FAILURE(Start());
  Process set(OnATerminal({"set", "LowPower", "--color=always"}));
  EXPECT_NE(set.LineWith("LowPower, "), "");
  EXPECT_THAT(set.LineWith("Active → LowPower"), HasSubstr("legs"));
  EXPECT_NE(set.LineWith(" s of 60 s"), "");
  Release();
  const Ended ended = set.Wait();
  EXPECT_EQ(ended.exit, 0);
  EXPECT_THAT(ended.out, HasSubstr("\x1b[A\x1b[K\x1b[32mdone\x1b[0m: the machine is in LowPower"));
}

TEST_F(Set, ShowsNoTableInAPipe) {
  Blocks("legs", "LowPower");
  ASSERT_NO_FATAL_FAILURE(Start());
  const Ended set = Musher({"set", "LowPower", "--timeout", "5"});
  EXPECT_EQ(set.exit, 4);
  EXPECT_EQ(set.out, "");
  Release();
}

TEST_F(Set, LetsTheSwitchContinueAfterCtrlC) {
  Blocks("legs", "LowPower");
  ASSERT_NO_FATAL_FAILURE(Start());
  Process watch(Command({"status", "--follow", "--json"}));
  ASSERT_NE(watch.LineWith(R"("state":"Active")"), "");
  Process set(Command({"set", "LowPower"}));
  ASSERT_NE(watch.LineWith(R"("target":"LowPower")"), "");
  set.Signal(SIGINT);
  const Ended ended = set.Wait();
  Release();
  EXPECT_EQ(ended.exit, 130);
  EXPECT_THAT(ended.err, HasSubstr("interrupted; switch "));
  EXPECT_THAT(ended.err, HasSubstr(" to LowPower continues"));
  EXPECT_NE(watch.LineWith(R"("state":"LowPower","degraded":[])"), "");
}

TEST_F(Set, IsPlannedWithoutBeingDone) {
  ASSERT_NO_FATAL_FAILURE(Start());
  const auto before = AwaitStatus(AllHaveArrived);
  const Ended plan = Musher({"plan", "LowPower", "--json"});
  EXPECT_EQ(plan.exit, 0);
  const auto steps = Json(plan.out)["steps"];
  ASSERT_EQ(steps.size(), 3U);
  EXPECT_EQ(steps[0]["actuator"], "legs");
  EXPECT_EQ(steps[0]["wave"], 2);  // the eyes come after the legs, so they go down before
  EXPECT_EQ(steps[2]["wave"], 1);
  EXPECT_EQ(steps[0]["deadline_ms"], 5000);
  const Ended refused = Musher({"plan", "Dancing"});
  EXPECT_EQ(refused.exit, 2);
  EXPECT_THAT(refused.err, HasSubstr("Dancing would be refused: unknown state"));
  EXPECT_EQ(Status(), before);
}

TEST_F(Set, IsRecordedInTheHistory) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"set", "OTA"}).exit, 0);
  // The journal is written behind the switch.
  ASSERT_NE(Process(Command({"history", "-f"})).LineWith("legs: OTA done"), "");
  const Ended history = Musher({"history", "--since", "10m"});
  EXPECT_EQ(history.exit, 0) << history.err;
  EXPECT_THAT(history.out, HasSubstr("legs: OTA done"));
  EXPECT_EQ(Musher({"history", "--since", "2100-01-01"}).out, "");
  EXPECT_EQ(Json(Musher({"history", "--lines", "2", "--json"}).out)["entries"].size(), 2U);
}

TEST_F(Set, IsExplainedByItsCauseAndDecidedAgainFromTheJournal) {
  ASSERT_NO_FATAL_FAILURE(Start());
  ASSERT_EQ(Musher({"set", "OTA"}).exit, 0);
  ASSERT_EQ(Musher({"down"}).exit, 0);
  const std::string journal = folder_ / "state/journal.sqlite";
  const Ended why = Musher({"history", "--journal", journal, "--why", "OTA"});
  EXPECT_EQ(why.exit, 0) << why.err;
  EXPECT_THAT(why.out, HasSubstr("  the machine went to OTA (switch "));
  EXPECT_THAT(why.out, HasSubstr("    because switch to OTA requested by "));
  const Ended replay = Musher({"replay", journal});
  EXPECT_EQ(replay.exit, 0) << replay.out << replay.err;
  EXPECT_EQ(replay.err, "");
  EXPECT_THAT(replay.out, ::testing::EndsWith(": all as recorded\n"));
}

TEST_F(Set, OfAStateIsWaitedFor) {
  Process wait(Command({"wait", "LowPower", "--timeout", "300"}));  // no controller leads yet
  ASSERT_EQ(UpDetached().exit, 0);
  ASSERT_EQ(Musher({"set", "LowPower"}).exit, 0);
  EXPECT_EQ(wait.Wait().exit, 0);
  EXPECT_EQ(Musher({"wait", "LowPower", "voice"}).exit, 0);
  const Ended other = Musher({"wait", "Active", "--timeout", "0.2"});
  EXPECT_EQ(other.exit, 1);
  EXPECT_THAT(other.err, HasSubstr("the machine is in LowPower, and not in Active in time"));
  const Ended wrong = Musher({"wait", "Activ"});
  EXPECT_EQ(wrong.exit, 2);
  EXPECT_THAT(wrong.err, HasSubstr("unknown state 'Activ'"));
}

}  // namespace musher::testing::switch_test
