// What the manager says of the start and of the battery, and to a player that is slow or not there;
// the tables of its phrases.

#include "musher/cyberdog/parts.hpp"
#include "musher/cyberdog/sounds.hpp"
#include "musher/test/cyberdog/voices.hpp"

namespace musher::cyberdog::voice_test {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// --- the start ---

TEST_F(Voices, ARobotThatIsUpAnnouncesThatItIsReadyAndWellAndThenThatAllIsLoaded) {
  Start();
  EXPECT_THAT(Said(), ElementsAre("9000", "60"));
  machine_.loaded = true;
  Show();
  EXPECT_THAT(Said(), ElementsAre("5300"));
  Show();
  EXPECT_THAT(Said(), IsEmpty());
}

TEST_F(Voices, ARobotOfOneStageAnnouncesNoSecondStage) {
  config_ = ManagedConfig(1);
  machine_.loaded = true;
  Start();
  EXPECT_THAT(Said(), ElementsAre("9000", "60"));
}

TEST_F(Voices, AFailedSelfCheckNamesTheParts) {
  Fail("sensor_manager", 2309, "ultrasonic: silent, 2309; gps: silent, 2409");
  Fail("device_manager", 2718);
  Start();
  EXPECT_THAT(Said(), ElementsAre("9000", "61", "31009", "31006", "31011", "31013"));
}

TEST_F(Voices, APartWithoutAPhraseIsNamed) {
  Fail("gripper", 101, "the jaw is stuck");
  Start();
  EXPECT_THAT(Said(), ElementsAre("9000", "61", "gripper: the jaw is stuck"));
}

TEST_F(Voices, ACriticalFailureIsAnnouncedWithoutReady) {
  machine_.phase = Phase::kFailed;
  Fail("motion_manager", 3009);
  Show();
  EXPECT_THAT(Said(), ElementsAre("61", "31015"));
}

TEST_F(Voices, WhatFailsInTheSecondStageIsAnnouncedWhenItIsOver) {
  Start();
  Said();
  Fail("RealSenseActuator", 4409);
  machine_.loaded = true;
  Show();
  EXPECT_THAT(Said(), ElementsAre("31054", "5300"));
}

TEST_F(Voices, AControllerThatAdoptsARunningRobotDoesNotSayReadyAgain) {
  machine_.adopted = true;
  machine_.loaded = true;
  Start();
  EXPECT_THAT(Said(), IsEmpty());
}

TEST_F(Voices, ReadyWaitsUntilTheAudioIsFree) {
  Feed(voice_event::PlayReported{true});
  Start();
  for (int i = 0; i < 6; ++i) {
    EXPECT_THAT(Said(Milliseconds(500)), IsEmpty());
    Feed(voice_event::PlayReported{true});
  }
  Feed(voice_event::PlayReported{false});
  EXPECT_THAT(Said(), ElementsAre("9000", "60"));
}

TEST_F(Voices, AReporterThatFallsSilentPlaysNoMore) {
  Feed(voice_event::PlayReported{true});
  Start();
  EXPECT_THAT(Said(Milliseconds(799)), IsEmpty());
  EXPECT_THAT(Said(Milliseconds(1)), ElementsAre("9000"));
}

// --- a player that is not there, or does not answer ---

TEST_F(Voices, WithoutAPlayerNothingIsAnnouncedAndThatIsReportedOnce) {
  Feed(voice_event::PlayerMatched{false});
  Start();
  EXPECT_THAT(Said(), ElementsAre("(dropped)"));
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), IsEmpty());
  EXPECT_EQ(NextVoiceDeadline(voice_), std::nullopt);
}

TEST_F(Voices, APlayerThatComesInTimeIsStillUsed) {
  Feed(voice_event::PlayerMatched{false});
  Start();
  EXPECT_THAT(Said(seconds(5)), IsEmpty());
  Feed(voice_event::PlayerMatched{true});
  EXPECT_THAT(Said(), ElementsAre("9000", "60"));
}

TEST_F(Voices, ASilentPlayerIsWaitedForSixSecondsAndThenTheNextIsSent) {
  answers_ = false;
  Start();
  EXPECT_THAT(Said(Milliseconds(5999)), ElementsAre("9000"));
  EXPECT_THAT(Said(Milliseconds(1)), ElementsAre("60"));
  Feed(voice_event::PlayEnded{1});  // the first one answers after all
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(Milliseconds(5999)), IsEmpty()) << "one at a time";
}

TEST_F(Voices, APlayerThatIsLostEndsItsUtterance) {
  answers_ = false;
  Start();
  Feed(voice_event::PlayerMatched{false});
  Feed(voice_event::PlayerMatched{true});
  EXPECT_THAT(Said(seconds(0)), ElementsAre("9000", "60"));
}

// --- the battery ---

TEST_F(Voices, EachLevelOfTheBatteryIsAnnouncedOnceInEachDirection) {
  BringUp();
  for (int percent = 79; percent >= 0; --percent) SetBattery(percent), Wait(seconds(2));
  EXPECT_THAT(Said(), ElementsAre("10030", "10020", "10005", "10000"));
}

TEST_F(Voices, ABatteryIsAnnouncedAsEmptyOnceThatIsConfirmed) {
  BringUp();
  machine_.battery = 0;
  machine_.level = BatteryLevel::kEmpty;
  Show();
  EXPECT_THAT(Said(), ElementsAre("10005"));
  machine_.empty = true;
  Show();
  EXPECT_THAT(Said(), ElementsAre("10000"));
}

TEST_F(Voices, TheLevelsAreInclusive) {
  BringUp();
  SetBattery(31);
  EXPECT_THAT(Said(), IsEmpty());
  SetBattery(30);
  EXPECT_THAT(Said(), ElementsAre("10030"));
  SetBattery(20);
  EXPECT_THAT(Said(), ElementsAre("10020"));
}

TEST_F(Voices, ABatteryThatWaversAtALevelIsAnnouncedOnce) {
  BringUp();
  for (const int percent : {30, 31, 30, 31, 30}) SetBattery(percent);
  EXPECT_THAT(Said(), ElementsAre("10030"));
  SetBattery(32);
  SetBattery(30);
  EXPECT_THAT(Said(), ElementsAre("10030")) << "two percent above it began again";
}

TEST_F(Voices, AJumpAnnouncesOnlyTheLastLevel) {
  BringUp();
  SetBattery(4);
  EXPECT_THAT(Said(), ElementsAre("10005"));
}

TEST_F(Voices, ABatteryThatIsChargedIsNotAnnouncedUntilTheCableIsOut) {
  BringUp();
  SetBattery(18, true);
  EXPECT_THAT(Said(), IsEmpty());
  SetBattery(18, false);
  EXPECT_THAT(Said(), ElementsAre("10020"));
}

TEST_F(Voices, ALowBatteryAtTheStartIsAnnouncedAfterReady) {
  machine_.battery = 25;
  Start();
  EXPECT_THAT(Said(), ElementsAre("9000", "60", "10030"));
}

// --- the tables ---

TEST(Sounds, AreCyberdogs) {
  const auto check = [](std::int32_t code) { return SelfCheckSound("", code).value_or(0); };
  EXPECT_THAT((std::vector{check(2409), check(2109), check(2209), check(2309), check(1409),
                           check(1109), check(1209), check(1509), check(1609), check(5109),
                           check(3009), check(4409), check(5309)}),
              ElementsAre(31006, 31007, 31008, 31009, 31010, 31011, 31011, 31012, 31013, 31014,
                          31015, 31054, 31058));
  const auto change = [](std::int32_t code) { return SwitchSound(code).value_or(0); };
  EXPECT_THAT((std::vector{change(2401), change(2101), change(2201), change(2301), change(1401),
                           change(1103), change(1203), change(1501), change(1601), change(5001),
                           change(3003), change(2001), change(1001)}),
              ElementsAre(31016, 31017, 31018, 31019, 31020, 31021, 31021, 31022, 31023, 31024,
                          31025, 31026, 31027));
  EXPECT_EQ(SelfCheckSound("motion_manager", 105), 31015) << "it is gone";
  EXPECT_EQ(SelfCheckSound("gripper", 105), std::nullopt);
}

TEST(Parts, AreFoundInSumsAndInMessagesButNotInOtherNumbers) {
  const auto failed = [](const char* actuator, std::int32_t code, const char* message) {
    return FailedCodes(PartsOf(actuator), {code, message});
  };
  EXPECT_THAT(failed("device_manager", 2718, ""), ElementsAre(1109, 1609));
  EXPECT_THAT(failed("device_manager", 1109, "led: no light, 1109; uwb: silent, 1609"),
              ElementsAre(1109, 1609));
  EXPECT_THAT(failed("device_manager", 105, "its process 1409 ended"), ElementsAre(105));
  EXPECT_THAT(failed("sensor_manager", 2109, "lidar: 22091 turns"), ElementsAre(2109));
  EXPECT_THAT(failed("gripper", 1409, ""), ElementsAre(1409));
}

}  // namespace musher::cyberdog::voice_test
