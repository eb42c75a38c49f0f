// Commands on state_machine/start_command.

#include <gmock/gmock.h>

#include "musher/modules/race/topic_names.hpp"
#include "musher/test/modules/race/race_rig.hpp"
#include "musher/transport/node.hpp"

namespace musher::race::command_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Command, StartBeginsTheRaceOnce) {
  Rig rig;
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:0,QRResult:None,TaskCompleted:False");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_TRUE(rig.field.Logged("START is refused in START_TO_QRA: the race is under way"));
  EXPECT_EQ(rig.field.motions.size(), 1U);
}

// A START for one robot of a DDS domain began the race of each.
TEST(Command, IsReceivedInTheNamespaceOfTheMachine) {
  EXPECT_EQ(transport::ResolveName("", topic::kCommand), "state_machine/start_command");
  EXPECT_EQ(transport::ResolveName("dog1", topic::kCommand), "dog1/state_machine/start_command");
  EXPECT_EQ(transport::ResolveName("dog1", topic::kInfo), "dog1/state_machine/state_info");
}

TEST(Command, StartAfterTheEndNeedsAReset) {
  Rig rig;
  rig.Command("START:END");
  rig.Tick();
  EXPECT_EQ(rig.race->InfoText(),
            "CurrentState:45,QRResult:None,TaskCompleted:True,Reservations:0");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "END");
  rig.Command("STOP");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START");
  EXPECT_TRUE(rig.field.Logged("START is refused: the task is completed; send RESET before"));
  rig.Command("RESET");
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:0,QRResult:None,TaskCompleted:False");
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
}

// state_info said that the task was completed while the robot walked.
TEST(Command, StartWithANameAfterTheEndIsNoCompletedTask) {
  Rig rig;
  rig.Command("START:END");
  rig.Tick();
  rig.Command("STOP");
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("TaskCompleted:True"));
  rig.Command("START:QRA_TO_A1");
  rig.Tick();
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:3,QRResult:None,TaskCompleted:False");
}

TEST(Command, StartWithANameOrANumberGoesThereFromAnywhere) {
  Rig rig;
  rig.Command("START:IN_S2");
  EXPECT_EQ(rig.state(), "IN_S2");
  rig.Command(" START:10 \n");
  EXPECT_EQ(rig.state(), "S1_TO_S2");
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  EXPECT_TRUE(rig.field.streaming);
  rig.Command("START:IN_S2");
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_EQ(rig.field.ends, 1);
  EXPECT_THAT(rig.field.states, ElementsAre(0, 11, 10, 3, 11));
}

TEST(Command, StopEndsTheMovementAndGoesToStart) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  rig.Command("SET_QR_B:B-2");
  rig.Command("STOP");
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.field.ends, 1);
  rig.Run(std::chrono::seconds(5));
  EXPECT_EQ(rig.field.streams, 1);
  rig.Command("START");
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:1,QRResult:B-2,TaskCompleted:False");
}

// START waits for the next tick, and a STOP in START did nothing: the race began after a stop.
TEST(Command, StopOverrulesAStartOfTheSameTick) {
  Rig rig;
  rig.Command("START");
  rig.Command("STOP");
  rig.Run(Milliseconds(1000));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_THAT(rig.field.motions, ElementsAre());
  EXPECT_TRUE(rig.field.Logged("START is refused: a later command has stopped it"));
}

TEST(Command, StopOverrulesAStartThatWouldBeRefusedInItsState) {
  for (const char* stop : {"STOP", "RESET"}) {
    Rig rig;
    rig.Command("START:IN_S2");
    rig.Tick();
    rig.Command("START");
    rig.Command(stop);
    rig.Run(Milliseconds(1000));
    EXPECT_EQ(rig.state(), "START") << stop;
    EXPECT_THAT(rig.field.motions, ElementsAre()) << stop;
  }
}

TEST(Command, ThatFollowsAStopInTheSameTickCounts) {
  Rig rig;
  for (const char* command : {"START", "STOP", "START"}) rig.Command(command);
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
  for (const char* command : {"STOP", "START:IN_S2"}) rig.Command(command);
  rig.Tick(2);
  EXPECT_EQ(rig.state(), "IN_S2");
  // By the request of behavior: in the machine's queue.
  EXPECT_TRUE(rig.machine->Send("STOP"));
  EXPECT_TRUE(rig.machine->Send("START"));
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
}

TEST(Command, StopAfterAResetThatWaitsForTheBodyLeavesItAReset) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("SET_QR_A:A-2");
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
  rig.Command("RESET");
  rig.Command("STOP");
  rig.race->OnMotionDone(rig.field.calls.front(), Ok(), rig.now);
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:0,QRResult:None,TaskCompleted:False");
}

TEST(Command, ResetForgetsResultsAndCounters) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  rig.Run(std::chrono::seconds(25));
  rig.Command("SET_QR_A:A-2");
  const Index z1 = 4;
  ASSERT_EQ(rig.course_.counters[z1], "z1");
  EXPECT_EQ(rig.race->memory().Count(z1), 2);
  rig.Command("RESET");
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.race->memory().Count(z1), 0);
  EXPECT_EQ(rig.race->InfoText(), "CurrentState:0,QRResult:None,TaskCompleted:False");
}

TEST(Command, ResetDuringALieDownWaitsForItsReply) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
  rig.Command("RESET");
  rig.Run(std::chrono::seconds(3));
  EXPECT_EQ(rig.state(), "IN_A1");
  rig.race->OnMotionDone(rig.field.calls.front(), Ok(), rig.now);
  EXPECT_EQ(rig.state(), "START");
  rig.Command("START");
  rig.Tick(3);
  EXPECT_THAT(rig.field.motions, ElementsAre(101, 111));
}

TEST(Command, ResetDuringALieDownThatIsNotAnsweredGoesAfterItsLimit) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
  rig.Command("RESET");
  EXPECT_TRUE(rig.RunTo("START", std::chrono::seconds(21)));
}

TEST(Command, SetOfAResultIsUsedAtOnce) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  rig.Tick(3);
  rig.Command("SET_QR_A:A-2");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(1000)));
  rig.Command("START:IN_QRB");
  rig.Tick(3);
  rig.Command("SET_QR_B_DEFAULT");
  ASSERT_TRUE(rig.RunTo("QRB_TO_B1", Milliseconds(1000)));
  rig.Command("START:IN_S2");
  rig.Command("SET_ARROW:left");
  rig.Command("SET_ARROW:right");
  EXPECT_TRUE(rig.field.Logged("SET_ARROW is refused: arrow is already left"));
  ASSERT_TRUE(rig.RunTo("S2_TO_L1", Milliseconds(1000)));
}

// After a restart of the race it took the way of the other value.
TEST(Command, LeadsToNoWayByAResultThatIsNotKnown) {
  Rig rig;
  rig.Command("START:IN_S1_R");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(65)));
  EXPECT_THAT(rig.race->InfoText(),
              HasSubstr("Reason:IN_S1_R: qr_a is not known: set it by SET_QR_A"));
  rig.Command("SET_QR_A:A-1");
  rig.Command("START:IN_S1_R");
  ASSERT_TRUE(rig.RunTo("S1_TO_A2", std::chrono::seconds(65)));
}

// START was sent where the robot did not stand in its start: it walked.
TEST(Command, StartElsewhereThanInTheStartIsAFault) {
  Rig rig;
  rig.script.lines = [](const std::string& detector) {
    return Lines{detector == "front_start" ? 0U : 2U, LineWord::kCenter, LineWord::kCenter};
  };
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("ERROR", std::chrono::seconds(10)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("check start_heading: no picture of it"));
  EXPECT_EQ(rig.field.streams, 0);
}

TEST(Command, ExitOfZoneBLeavesABayAtOnceOnTheSideOppositeToTheArrow) {
  Rig rig;
  rig.Command("SET_ARROW:left");
  rig.Command("START:IN_B1");
  rig.Run(Milliseconds(5200));
  EXPECT_THAT(rig.field.motions, ElementsAre(101));
  rig.Command("EXIT_B_ZONE");
  ASSERT_TRUE(rig.RunTo("B1_TO_R1", Milliseconds(1500)));  // after the reply of the lie-down
  rig.Command("RESET");
  rig.Command("SET_ARROW:right");
  rig.Command("START:IN_B2");
  rig.Run(Milliseconds(1000));
  rig.Command("EXIT_B_ZONE");
  EXPECT_TRUE(rig.RunTo("B2_TO_L1", Milliseconds(200)));
}

TEST(Command, ExitOfZoneBOnTheWayToTheOtherBayLeavesFromThere) {
  Rig rig;
  rig.Command("SET_ARROW:right");
  rig.Command("START:B1_TO_B2");
  rig.Run(Milliseconds(3000));
  rig.Command("EXIT_B_ZONE");
  ASSERT_TRUE(rig.RunTo("IN_B2"));
  EXPECT_TRUE(rig.RunTo("B2_TO_L1"));
  rig.Command("EXIT_B_ZONE");
  EXPECT_TRUE(rig.field.Logged("EXIT_B_ZONE is refused in B2_TO_L1"));
}

TEST(Command, OfAnyCaseIsTheSame) {
  Rig rig;
  rig.Command("start: in_qr_a");
  rig.Tick(3);
  rig.Command("set_qr_a: a-2");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(1000)));
  rig.Command("Stop");
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "START");
  rig.Command("start");
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "START_TO_QRA");
}

TEST(Command, OfAStatesNameAloneGoesThereAndOfAValueAloneSetsItsResult) {
  Rig rig;
  rig.Command("in_qr_a");
  rig.Tick(3);
  EXPECT_EQ(rig.state(), "IN_QR_A");
  rig.Command("a-2");
  ASSERT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(1000)));
  rig.Command("IN_S2");
  rig.Command("LEFT");
  ASSERT_TRUE(rig.RunTo("S2_TO_L1", Milliseconds(1000)));
}

TEST(Command, OfAValueOfTwoResultsNamesBothCommands) {
  Course course = TheCourse();
  course.results[FindByName(course.results, "qr_b").value()].values.push_back("A-1");
  Rig rig(course);
  rig.Command("a-1");
  EXPECT_TRUE(
      rig.field.Logged("'a-1' is a value of two results: send SET_QR_A:A-1 or SET_QR_B:A-1"));
}

// The detectors of another team publish a std_msgs/String when they see something, and nothing
// else.
TEST(DetectorOfWords, LeadsTheRaceAndMayBeSilent) {
  Course course = TheCourse();
  const Index qr = FindByName(course.detectors, "qr").value();
  course.detectors[qr].kind = Detector::Kind::kText;
  Rig rig(course);
  rig.script.silent = {"qr"};
  rig.Command("START:IN_QR_A");
  rig.Run(course.check.silent + Milliseconds(2000));
  EXPECT_EQ(rig.state(), "IN_QR_A") << "no picture is expected of it";
  rig.race->OnText(qr, "nonsense", rig.now);
  rig.race->OnText(qr, "", rig.now);
  rig.Run(Milliseconds(500));
  EXPECT_EQ(rig.state(), "IN_QR_A");
  rig.race->OnText(qr, " A-2\n", rig.now);
  EXPECT_TRUE(rig.RunTo("QRA_TO_A2", Milliseconds(1000)));
}

TEST(Command, ThatIsUnknownIsRefusedAndLoggedAtALimitedRate) {
  Rig rig;
  for (int i = 0; i < 1000; ++i) rig.Command("STRAT");
  EXPECT_TRUE(rig.field.Logged("there is no command 'STRAT'; did you mean 'START'?"));
  EXPECT_LE(rig.field.log.size(), 2U);
  rig.Run(Milliseconds(2100));
  EXPECT_TRUE(rig.field.Logged("more)"));
  rig.Command("SET_QR_A:C-9");
  rig.Command("START:NOWHERE");
  rig.Command("START:40");
  rig.Command("");
  rig.Command(std::string(5000, 'x'));
  rig.Run(Milliseconds(2100));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.field.streams, 0);
}

// What waited while the process was stopped, or its computer suspended.
TEST(Command, ThatMayBeLateMovesNothingButStopCounts) {
  Rig rig;
  const Result<> late = Error{kCodeTimeout, "race could not run for 9 s"};
  for (const char* word : {"START", "START:IN_S2", "in_s2", "A-2", "EXIT_B_ZONE"}) {
    rig.race->OnCommand(word, rig.now, late);
    rig.Tick();
    EXPECT_EQ(rig.state(), "START") << word;
  }
  EXPECT_TRUE(rig.field.Logged("START is refused: race could not run for 9 s"));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("QRResult:None"));
  rig.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  rig.race->OnCommand("STOP", rig.now, late);
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_EQ(rig.state(), "START");
}

TEST(Command, StartIsRefusedInAPause) {
  Rig rig;
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Command("START");
  rig.Command("START:IN_S2");
  EXPECT_EQ(rig.state(), "START");
  EXPECT_TRUE(rig.field.Logged("START is refused: the robot is not in a state that runs the race"));
}

}  // namespace musher::race::command_test
