// Pauses: LowPower, Protected, an emergency stop. The race continues where it was.

#include <gmock/gmock.h>

#include <tuple>
#include <utility>

#include "musher/test/modules/race/race_replay.hpp"

namespace musher::race::pause_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

void PauseFor(Rig& rig, Duration time) {
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(time);
  rig.race->Resume(rig.now);
}

TEST(Pause, EndsTheStreamAndContinuesWithTheRestAfterStandingUp) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(2000));
  rig.race->Pause(rig.now);
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_EQ(rig.field.ends, 1);
  rig.race->Pause(rig.now);  // idempotent
  EXPECT_EQ(rig.field.ends, 1);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(55));
  rig.race->Resume(rig.now);
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.ends == 2; }));
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 111));
  const int frames = rig.field.frames_of_stream[0] + rig.field.frames_of_stream[1];
  EXPECT_GE(frames, 23 * 4);
  EXPECT_LE(frames, 23 * 4 + 1);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
}

TEST(Pause, ClosesTheDetectorsAndStopsTheWalker) {
  Rig rig;
  rig.Command("START:IN_QR_A");
  rig.Run(Milliseconds(500));
  ASSERT_TRUE(rig.Wants("qr"));
  rig.race->Pause(rig.now);
  EXPECT_FALSE(rig.Wants("qr"));
  rig.race->Resume(rig.now);
  rig.Command("START:S1_TO_S2");
  rig.Run(Milliseconds(2000));
  PauseFor(rig, std::chrono::seconds(30));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
  ASSERT_TRUE(rig.RunTo("IN_S2"));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP", "START", "STOP"));
}

TEST(Pause, RepeatsAMotionThatFailedByIt) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.race->OnMotionDone(rig.field.calls.front(), Error{3003, "DeActive"}, rig.now);
  rig.field.calls.clear();
  rig.Run(std::chrono::seconds(5));
  rig.script.motion_replies = true;
  rig.race->Resume(rig.now);
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streaming; }));
  EXPECT_THAT(rig.field.motions, ElementsAre(111, 111));
}

// The latch of an emergency stop refuses every motion but standing up.
class Latched : public ::testing::Test {
 protected:
  Latched() {
    rig_.script.motion = [this](std::int32_t motion) -> Result<> {
      if (motion == 111) latched_ = false;
      return latched_ ? Result<>(Error{3040, "the emergency stop is set"}) : Ok();
    };
  }
  void StopAndContinue() {
    latched_ = true;
    PauseFor(rig_, std::chrono::seconds(5));
  }

  Rig rig_;
  bool latched_ = false;
};

TEST_F(Latched, BodyStandsUpBeforeALieDownIsRepeated) {
  rig_.script.motion_replies = false;
  rig_.Command("START:IN_A1");
  ASSERT_TRUE(rig_.RunUntil([&] { return rig_.field.motions.size() == 1; }));
  latched_ = true;
  rig_.race->Pause(rig_.now);
  rig_.machine->Pause();
  rig_.script.motion_replies = true;
  rig_.Run(std::chrono::seconds(5));
  rig_.race->Resume(rig_.now);
  ASSERT_TRUE(rig_.RunTo("A1_TO_S1", std::chrono::seconds(40))) << rig_.race->InfoText();
  EXPECT_THAT(rig_.field.motions, ElementsAre(101, 111, 101));
}

TEST_F(Latched, BodyStandsUpWhereTheLieDownIsAnsweredAfterThePause) {
  rig_.script.motion_replies = false;
  rig_.Command("START:IN_A1");
  ASSERT_TRUE(rig_.RunUntil([&] { return rig_.field.motions.size() == 1; }));
  StopAndContinue();
  rig_.script.motion_replies = true;
  ASSERT_TRUE(rig_.RunTo("A1_TO_S1", std::chrono::seconds(40))) << rig_.race->InfoText();
  EXPECT_THAT(rig_.field.motions, ElementsAre(101, 111, 101));
}

TEST_F(Latched, BodyLiesOnWhereTheLieDownEndedWellInThePause) {
  rig_.script.motion_replies = false;
  rig_.Command("START:IN_A1");
  ASSERT_TRUE(rig_.RunUntil([&] { return rig_.field.motions.size() == 1; }));
  PauseFor(rig_, std::chrono::seconds(5));
  rig_.script.motion_replies = true;
  ASSERT_TRUE(rig_.RunTo("A1_TO_S1", std::chrono::seconds(40))) << rig_.race->InfoText();
  EXPECT_THAT(rig_.field.motions, ElementsAre(101));
}

TEST_F(Latched, BodyStandsUpBeforeALieDownThatHasNotBegun) {
  rig_.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig_.RunTo("IN_A1"));
  rig_.Run(Milliseconds(2000));
  StopAndContinue();
  ASSERT_TRUE(rig_.RunTo("A1_TO_S1", std::chrono::seconds(40))) << rig_.race->InfoText();
  EXPECT_THAT(rig_.field.motions, ElementsAre(111, 111, 101));
}

// Between the last step of a state and its transition nothing seemed to be under way.
TEST_F(Latched, BodyStandsUpBetweenTwoStates) {
  Rig before;
  before.Command("START:QRA_TO_A1");
  ASSERT_TRUE(before.RunTo("IN_A1"));
  rig_.Command("START:QRA_TO_A1");
  while (rig_.now + Milliseconds(50) < before.now) rig_.Tick();
  ASSERT_EQ(rig_.state(), "QRA_TO_A1");
  StopAndContinue();
  ASSERT_TRUE(rig_.RunTo("A1_TO_S1", std::chrono::seconds(40))) << rig_.race->InfoText();
  EXPECT_THAT(rig_.field.motions, ElementsAre(111, 111, 101));
}

// The walk of a later command was refused.
TEST_F(Latched, BodyThatStoodInTheStartStandsUpBeforeItWalks) {
  rig_.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig_.RunUntil([&] { return rig_.field.streaming; }));
  rig_.Command("STOP");
  StopAndContinue();
  rig_.Command("START:QRA_TO_A1");
  ASSERT_TRUE(rig_.RunTo("IN_A1", std::chrono::minutes(1)));
  EXPECT_THAT(rig_.field.motions, ElementsAre(111, 111));
}

TEST(Pause, OfALyingRobotDoesNotMakeItStand) {
  Rig rig;
  rig.script.speech_replies = false;
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return !rig.field.spoken.empty(); }));
  PauseFor(rig, std::chrono::seconds(5));
  rig.Run(Milliseconds(2000));
  EXPECT_THAT(rig.field.motions, ElementsAre(101));
  EXPECT_THAT(rig.field.spoken, ElementsAre("已到达库位", "已到达库位"));
}

TEST(Pause, DoesNotCountTowardsALimit) {
  Rig rig;
  rig.Command("START:IN_QRB");
  rig.Run(std::chrono::seconds(30));
  PauseFor(rig, std::chrono::seconds(55));
  rig.Run(std::chrono::seconds(25));
  EXPECT_EQ(rig.state(), "IN_QRB");
  EXPECT_TRUE(rig.RunTo("QRB_TO_B1", std::chrono::seconds(10)));
}

TEST(Pause, AcceptsResetAndStop) {
  Rig rig;
  rig.Command("START:IN_QRB");
  rig.Run(std::chrono::seconds(1));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Command("STOP");
  EXPECT_EQ(rig.state(), "START");
}

// After the release, and Active, it began by itself.
TEST(Pause, OverrulesAStartThatIsQueued) {
  Rig rig;
  rig.Command("START");
  PauseFor(rig, std::chrono::seconds(5));
  rig.Run(Milliseconds(2000));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_THAT(rig.field.motions, ElementsAre());
}

TEST(Pause, OverrulesAJumpThatWaitsForTheBody) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START:ERROR");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.size() == 1; }));
  rig.Command("START:QRA_TO_A1");
  rig.Tick();
  rig.script.motion_replies = true;
  PauseFor(rig, std::chrono::seconds(5));
  rig.Run(Milliseconds(3000));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.field.streams, 0);
  EXPECT_TRUE(rig.field.Logged("START:QRA_TO_A1 is dropped"));
}

// An operator has picked it up: it went on "where it was", in another place.
TEST(Pause, InWhichTheRobotIsMovedIsAFault) {
  for (const auto& [ahead_m, turned_rad, reason] :
       {std::tuple(0.4, 0.0, "it was moved by 0.40 m and turned by 0 degrees in the pause"),
        std::tuple(0.0, 0.5, "it was moved by 0.00 m and turned by 29 degrees in the pause")}) {
    Rig rig;
    rig.script.odometry = Truth;
    rig.Command("START:QRA_TO_A1");
    rig.Run(Milliseconds(3000));
    rig.race->Pause(rig.now);
    rig.machine->Pause();
    rig.Run(Milliseconds(5000));
    rig.pose.at.x_m += ahead_m;
    rig.pose.yaw_rad += turned_rad;
    rig.Run(Milliseconds(1000));
    rig.race->Resume(rig.now);
    ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(3000))) << reason;
    EXPECT_THAT(rig.race->InfoText(), HasSubstr(reason));
    EXPECT_EQ(rig.field.streams, 1) << "it walks on";
  }
}

TEST(Pause, InWhichTheRobotIsMovedIsNoFaultWhereTheCourseDoesNotCompareIt) {
  Course course = TheCourse();
  course.odometry.most_moved_m = 0;
  Rig rig(course);
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(Milliseconds(5000));
  rig.pose.at.x_m += 0.4;
  rig.race->Resume(rig.now);
  EXPECT_TRUE(rig.RunTo("IN_A1"));
}

// Charged, the robot walked off from its charger by itself.
TEST(Pause, ThatIsLongIsFollowedByTheRestOnlyAfterStart) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  PauseFor(rig, std::chrono::seconds(61));
  rig.Run(std::chrono::seconds(30));
  EXPECT_EQ(rig.state(), "QRA_TO_A1");
  EXPECT_EQ(rig.field.streams, 1);
  EXPECT_THAT(rig.field.motions, ElementsAre(111));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(",Waits:START"));
  PauseFor(rig, std::chrono::seconds(1));
  rig.Run(std::chrono::seconds(5));
  EXPECT_EQ(rig.field.streams, 1) << "a short pause permits nothing";
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("IN_A1", std::chrono::seconds(60)));
  EXPECT_THAT(rig.race->InfoText(), ::testing::Not(HasSubstr("Waits")));
}

// Led up within a minute, it walked off from its charger "where it was".
TEST(Pause, OnAChargerIsFollowedByTheRestOnlyAfterStart) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(Milliseconds(5000));
  rig.race->OnCharger(true, rig.now);
  rig.Run(Milliseconds(10'000));
  rig.race->OnCharger(false, rig.now);  // lifted off it
  rig.Run(Milliseconds(2000));
  rig.race->Resume(rig.now);
  rig.Run(std::chrono::seconds(20));
  EXPECT_EQ(rig.field.streams, 1);
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(",Waits:START"));
  EXPECT_TRUE(rig.field.Logged("it was, or is, on a charger: it goes on after START"));
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("IN_A1", std::chrono::seconds(60)));
  ExpectReplays(rig);
}

TEST(Pause, AfterOneOnAChargerNeedsNoStart) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.race->OnCharger(true, rig.now);
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  EXPECT_EQ(rig.field.streams, 1) << "a person has started it there";
  rig.race->OnCharger(false, rig.now);
  PauseFor(rig, Milliseconds(5000));
  EXPECT_TRUE(rig.RunTo("IN_A1", std::chrono::seconds(60)));
}

TEST(Pause, IsNotNeededForACharger) {
  Rig rig;
  rig.Command("START:IN_QRB");
  rig.Run(Milliseconds(3000));
  rig.race->OnCharger(true, rig.now);
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(200)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(",Reason:IN_QRB: it is on a charger"));
  ExpectReplays(rig);
}

// A second publisher of the battery reports it: the first one is of another robot, which charges.
TEST(Pause, IsNotNeededForAChargerWhereAnotherOneWasReportedBefore) {
  Rig rig;
  rig.race->OnCharger(true, rig.now);
  rig.Command("START:IN_QRB");
  rig.Run(Milliseconds(3000));
  EXPECT_EQ(rig.state(), "IN_QRB") << "a person has started it there";
  rig.race->OnCharger(true, rig.now);
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(200)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(",Reason:IN_QRB: it is on a charger"));
  ExpectReplays(rig);
}

// Its process was stopped, or its computer suspended: it walked on, wherever it was put meanwhile.
TEST(Pause, InWhichItsProcessCouldNotRunIsFollowedByTheRestOnlyAfterStart) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  ASSERT_TRUE(rig.field.streaming);
  rig.now += std::chrono::seconds(20);
  rig.race->OnBreak(std::chrono::seconds(20), rig.now);
  EXPECT_FALSE(rig.field.streaming);
  rig.Run(std::chrono::seconds(30));
  EXPECT_EQ(rig.state(), "QRA_TO_A1");
  EXPECT_EQ(rig.field.streams, 1);
  EXPECT_THAT(rig.race->InfoText(), HasSubstr(",Waits:START"));
  EXPECT_TRUE(rig.field.Logged("could not run for 20000 ms: it goes on after START"));
  rig.Command("START");
  ASSERT_TRUE(rig.RunTo("IN_A1", std::chrono::seconds(60)));
  ExpectReplays(rig);
}

// The clock does not count it: after a night it went on as after some seconds.
TEST(Pause, IsAsLongAsTheSuspensionOfItsComputerInIt) {
  for (const auto& [asleep, streams] :
       {std::pair(std::chrono::seconds(20), 2), std::pair(std::chrono::seconds(58), 1)}) {
    Rig rig;
    rig.script.odometry = Truth;
    rig.Command("START:QRA_TO_A1");
    rig.Run(Milliseconds(3000));
    rig.race->Pause(rig.now);
    rig.machine->Pause();
    rig.Run(std::chrono::seconds(3));
    rig.race->OnBreak(asleep / 2, rig.now);  // each of several counts
    rig.race->OnBreak(asleep / 2, rig.now);
    rig.race->Resume(rig.now);
    rig.Run(Milliseconds(3000));
    EXPECT_EQ(rig.field.streams, streams);
    ExpectReplays(rig);
  }
}

TEST(Pause, InWhichItsProcessCouldNotRunOverrulesAJumpThatWaitsForTheBody) {
  Rig rig;
  rig.script.motion_replies = false;
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return !rig.field.motions.empty(); }));
  rig.Command("START:QRA_TO_A1");
  rig.now += std::chrono::seconds(9);
  rig.race->OnBreak(std::chrono::seconds(9), rig.now);
  rig.script.motion_replies = true;
  rig.Run(std::chrono::seconds(20));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.field.streams, 0);
}

// After an hour it stood up from its error, and walked.
TEST(Pause, InWhichItsProcessCouldNotRunOverrulesAJumpThatWaitsInTheError) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.script.motion_replies = false;
  rig.race->OnCharger(true, rig.now);
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(200)));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.motions.back() == 101; }));
  rig.race->OnCharger(false, rig.now);
  rig.Command("START:QRA_TO_A1");
  rig.now += std::chrono::hours(1);
  rig.race->OnBreak(std::chrono::hours(1), rig.now);
  EXPECT_TRUE(rig.field.Logged("START:QRA_TO_A1 is dropped: this process could not run"));
  rig.script.motion_replies = true;
  rig.Run(std::chrono::seconds(60));
  EXPECT_EQ(rig.state(), "START");
  EXPECT_EQ(rig.field.streams, 1);
}

TEST(Pause, ThatIsLongMayBeEndedByAnotherCommand) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  PauseFor(rig, std::chrono::seconds(61));
  rig.Command("START:QRB_TO_B1");
  EXPECT_TRUE(rig.RunTo("IN_B1", std::chrono::seconds(60)));
}

TEST(Pause, ThatIsLongAndInWhichItIsMovedAtItsEndIsAFault) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  PauseFor(rig, std::chrono::seconds(61));
  rig.Run(std::chrono::seconds(5));
  rig.pose.at.x_m += 0.4;
  rig.Command("START");
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(3000)));
}

// The wait for START counted toward the limits: defaults were taken without one look.
TEST(Pause, ThatIsLongAndTheWaitForStartDoNotCountTowardsALimit) {
  Rig rig;
  rig.Command("START:IN_QRB");
  rig.Run(std::chrono::seconds(30));
  PauseFor(rig, std::chrono::seconds(120));
  rig.Run(std::chrono::seconds(20));
  PauseFor(rig, std::chrono::seconds(61));
  rig.Run(std::chrono::seconds(20));
  rig.Command("START");
  rig.Run(std::chrono::seconds(25));
  EXPECT_EQ(rig.state(), "IN_QRB");
  EXPECT_TRUE(rig.RunTo("QRB_TO_B1", std::chrono::seconds(10)));
}

TEST(Pause, AndTheWaitForStartDoNotShortenWhatIsSpoken) {
  Rig rig;
  rig.script.speech_replies = false;
  rig.Command("START:IN_A1");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.spoken.size() == 1; }));
  PauseFor(rig, std::chrono::seconds(61));
  rig.Run(std::chrono::seconds(60));
  rig.Command("START");
  rig.script.speech_replies = true;
  ASSERT_TRUE(rig.RunTo("A1_TO_S1", std::chrono::seconds(10)));
  EXPECT_THAT(rig.field.spoken, ElementsAre("已到达库位", "已到达库位"));
}

// The second pause took the new place for the one before the pause.
TEST(Pause, ThatFollowsAtOnceDoesNotHideThatItWasMovedInTheFirst) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(Milliseconds(5000));
  rig.pose.at.x_m += 0.4;
  rig.race->Resume(rig.now);
  PauseFor(rig, Milliseconds(2000));
  ASSERT_TRUE(rig.RunTo("ERROR", Milliseconds(3000)));
  EXPECT_THAT(rig.race->InfoText(), HasSubstr("it was moved by 0.40 m"));
}

TEST(Pause, DuringTheWaitForStartDoesNotHideThatItWasMovedBefore) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(std::chrono::seconds(61));
  rig.pose.at.x_m += 0.4;
  rig.race->Resume(rig.now);
  rig.Run(std::chrono::seconds(5));
  PauseFor(rig, std::chrono::seconds(2));
  rig.Run(std::chrono::seconds(5));
  rig.Command("START");
  EXPECT_TRUE(rig.RunTo("ERROR", Milliseconds(3000)));
}

TEST(Pause, AfterAPlaceThatWasComparedIsComparedWithItsOwn) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  PauseFor(rig, Milliseconds(3000));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.streams == 2; }));
  rig.Run(Milliseconds(1000));
  PauseFor(rig, Milliseconds(3000));
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.race->memory().reserved(), 0U);
}

TEST(Pause, InWhichTheRobotStandsUpIsNone) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  rig.race->Pause(rig.now);
  rig.machine->Pause();
  rig.Run(Milliseconds(5000));
  rig.pose.at.x_m += 0.1;
  rig.race->Resume(rig.now);
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_EQ(rig.race->memory().reserved(), 0U);
}

TEST(Pause, WithoutOdometryIsAReservation) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(3000));
  PauseFor(rig, Milliseconds(5000));
  ASSERT_TRUE(rig.RunTo("IN_A1"));
  EXPECT_TRUE(rig.field.Logged("whether it was moved in the pause is not known"));
  EXPECT_EQ(rig.race->memory().reserved(), 2U) << "and that it walks by its time";
}

// It said that it had arrived, wherever it was carried meanwhile.
TEST(Pause, AfterWhichItsPlaceIsNotKnownIsSpokenInTheBay) {
  Rig rig;
  rig.script.odometry = Truth;
  rig.Command("START:IN_A1");
  rig.Run(Milliseconds(2000));
  rig.script.odometry = nullptr;
  PauseFor(rig, Milliseconds(5000));
  ASSERT_TRUE(rig.RunUntil([&] { return !rig.field.spoken.empty(); }));
  EXPECT_EQ(rig.field.spoken.front(), "不确定是否已到达库位");
}

TEST(Pause, InTheCountdownAfterWhichItsPlaceIsNotKnownIsSpokenInTheBay) {
  Rig rig;
  bool light = true;
  rig.script.odometry = Truth;
  rig.script.sight = [&light](const std::string& detector) -> Sighting {
    return {light && detector == "light", 0.5, "", ""};
  };
  rig.Command("START:QRB_TO_B1");
  ASSERT_TRUE(rig.RunTo("YELLOW_LIGHT_COUNTDOWN"));
  light = false;
  rig.script.odometry = nullptr;
  PauseFor(rig, Milliseconds(5000));
  rig.script.odometry = Truth;
  ASSERT_TRUE(rig.RunTo("IN_B1"));
  ASSERT_TRUE(rig.RunUntil([&] { return rig.state() != "IN_B1"; }));
  EXPECT_EQ(rig.field.spoken.back(), "不确定是否已到达库位");
}

// The walker was started again behind the lane's end.
TEST(Pause, AtTheEndOfTheLaneDoesNotStartTheWalkerAgain) {
  Rig rig;
  rig.Command("START:S1_TO_S2");
  ASSERT_TRUE(rig.RunUntil([&] { return rig.field.walking_lane; }));
  rig.Run(Milliseconds(2000));
  rig.race->OnWalkerStatus(0, "State:IDLE,Active:False,End:course_end", rig.now);
  PauseFor(rig, std::chrono::seconds(55));
  ASSERT_TRUE(rig.RunTo("IN_S2", std::chrono::seconds(10)));
  EXPECT_THAT(rig.field.walker, ElementsAre("START", "STOP"));
}

// The race before has crashed while the line walker walked.
TEST(Pause, BeforeTheFirstRunStopsTheWalkerOfAnEarlierProcess) {
  Field field;
  Race race(TheCourse(), field);
  EXPECT_THAT(field.walker, ElementsAre());
  race.Resume({});
  EXPECT_THAT(field.walker, ElementsAre("STOP"));
  race.Pause({});
  race.Resume({});
  EXPECT_THAT(field.walker, ElementsAre("STOP"));
}

TEST(Pause, OfTheMachineAtItsEndEndsTheStream) {
  Rig rig;
  rig.Command("START:QRA_TO_A1");
  rig.Run(Milliseconds(1000));
  ASSERT_TRUE(rig.field.streaming);
  EXPECT_TRUE(rig.machine->Stop());
  EXPECT_FALSE(rig.field.streaming);
  EXPECT_EQ(rig.field.ends, 1);
  EXPECT_FALSE(rig.Wants("right_lane"));
}

}  // namespace musher::race::pause_test
