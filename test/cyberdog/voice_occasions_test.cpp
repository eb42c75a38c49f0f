// What a touch, a refusal, a failed switch and an app make the manager say, and when it is quiet.

#include "musher/test/cyberdog/voices.hpp"

namespace musher::cyberdog::voice_occasions_test {

using std::chrono::seconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// --- touches ---

TEST_F(Voices, ADoubleTapIsAnsweredWithTheChargeAtMostEveryTwoSeconds) {
  BringUp();
  Feed(voice_event::DoubleTapped{});
  Wait(Milliseconds(1999));
  Feed(voice_event::DoubleTapped{});
  Wait(Milliseconds(1));
  EXPECT_THAT(Said(seconds(0)), ElementsAre("1080"));
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), ElementsAre("1080"));
}

TEST_F(Voices, ATapIsAnsweredBeforeWhatElseWaits) {
  machine_.battery = 50;
  Start();
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), ElementsAre("9000", "1050", "60"));
}

TEST_F(Voices, AnUnknownChargeIsAnnouncedAsASentence) {
  BringUp();
  machine_.battery_silent = true;
  Show();
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), ElementsAre("the charge of the battery is not known"));
}

// --- refusals and failures ---

TEST_F(Voices, WhatThePolicyRefusesIsAnnouncedAsItsSentenceAndNotAgainForHalfAMinute) {
  BringUp();
  const std::string why = "wake-up refused: the battery is at 4 %";
  for (int i = 0; i < 3; ++i) Record("policy", 0, 113, why), Wait(seconds(5));
  EXPECT_THAT(Said(seconds(16)), ElementsAre(why));
  Record("policy", 0, 113, why);
  EXPECT_THAT(Said(), ElementsAre(why));
}

TEST_F(Voices, WhatThePolicyDoesWithoutTroubleIsNotAnnounced) {
  BringUp();
  Record("policy", 0, 0, "the battery is at 18 %: down to Protected");
  Record("policy", 0, 111, "wake-up refused: switch 4 is under way");
  EXPECT_THAT(Said(), IsEmpty());
}

TEST_F(Voices, AFailedSwitchIsAnnouncedByTheModuleThatFailed) {
  BringUp();
  Record("switch", 4, 0, "switch 4 begins");
  Record("switch", 4, 2112, "switch 4 is undone: sensor_manager: failed");
  EXPECT_THAT(Said(), ElementsAre("31017"));
  Record("switch", 5, 2009, "switch 5 is done-degraded");
  EXPECT_THAT(Said(), ElementsAre("switch 5 is done-degraded")) << "there is no such phrase";
  Record("switch", 6, 2409, "a self-check");
  EXPECT_THAT(Said(), ElementsAre("31006"));
  Record("switch", 0, 103, "switch to Dance refused: there is no such state");
  EXPECT_THAT(Said(), ElementsAre("switch to Dance refused: there is no such state"));
}

TEST_F(Voices, WhatWasDegradedBeforeIsNotAnnouncedAtEverySwitch) {
  BringUp();
  Fail("sensor_manager", 2409);
  Show();
  Record("switch", 4, 0, "switch 4 begins");
  Record("switch", 4, 2409, "switch 4 is done-degraded");
  EXPECT_THAT(Said(), IsEmpty());
}

TEST_F(Voices, AFailureDuringTheStartIsOnlyAnnouncedAsAPart) {
  machine_.phase = Phase::kStarting;
  Show();
  Record("switch", 1, 2109, "switch 1 is done-degraded: sensor_manager");
  machine_.phase = Phase::kRunning;
  Fail("sensor_manager", 2109);
  Show();
  EXPECT_THAT(Said(), ElementsAre("9000", "61", "31007"));
}

TEST_F(Voices, ALongSentenceIsCutBetweenCharacters) {
  BringUp();
  std::string why(239, 'a');
  why += "ü, and so on";
  Record("policy", 0, 113, why);
  EXPECT_THAT(Said(), ElementsAre(std::string(239, 'a')));
}

// --- the app, sleep and silence ---

TEST_F(Voices, TheFirstAppIsGreetedAndThenTheRobotStandsUp) {
  BringUp();
  Feed(voice_event::AppConnected{});
  EXPECT_THAT(Said(), ElementsAre("2002", "stand up"));
  Feed(voice_event::AppConnected{});
  EXPECT_THAT(Said(), IsEmpty());
}

TEST_F(Voices, ARobotThatIsChargedOrRestsOrStartsDoesNotStandUpForTheApp) {
  machine_.phase = Phase::kStarting;
  Show();
  Feed(voice_event::AppConnected{});
  BringUp();
  SetBattery(80, true);
  Feed(voice_event::AppConnected{});
  SetBattery(80, false);
  machine_.state = kLowPower;
  Show();
  Feed(voice_event::AppConnected{});
  EXPECT_THAT(Said(), IsEmpty());
}

// It lay, and its app connected again after its controller was restarted.
TEST_F(Voices, ARobotThatRanBeforeItsControllerDoesNotStandUpForTheApp) {
  machine_.adopted = true;
  BringUp();
  Feed(voice_event::AppConnected{});
  EXPECT_THAT(Said(), IsEmpty());
}

// The greeting waits for other sounds and plays for seconds.
TEST_F(Voices, ARobotThatIsStoppedOrChargedOrRestsDuringTheGreetingDoesNotStandUpAfterIt) {
  BringUp();
  const VoiceState before = voice_;
  Feed(voice_event::AppConnected{});
  machine_.stopped = true;
  Show();
  machine_.stopped = false;  // released, and Active requested
  Show();
  EXPECT_THAT(Said(), ElementsAre("2002"));
  voice_ = before;
  Feed(voice_event::AppConnected{});
  SetBattery(80, true);
  EXPECT_THAT(Said(), ElementsAre("2002"));
  SetBattery(80, false);
  voice_ = before;
  Feed(voice_event::AppConnected{});
  machine_.state = kDeActive;
  Show();
  EXPECT_THAT(Said(), ElementsAre("2002"));
}

TEST_F(Voices, TheRobotStandsUpForTheAppAlsoWithoutAVoice) {
  BringUp();
  Feed(voice_event::PlayerMatched{false});
  Feed(voice_event::AppConnected{});
  EXPECT_THAT(Said(), ElementsAre("stand up"));
}

TEST_F(Voices, OnlyTheOccasionsOfTheConfigAreAnnounced) {
  VoicePolicy voice;
  voice.say = {Occasion::kTouch};
  CompletePolicy(voice, *config_.policy);
  BringUp();
  SetBattery(3);
  Record("policy", 0, 113, "refused");
  Record("switch", 4, 2112, "undone");
  Feed(voice_event::AppConnected{});
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), ElementsAre("1003"));
}

TEST_F(Voices, AQuietSleeperOnlyAnswersATouchAndAnnouncesTheRestAwake) {
  VoicePolicy voice;
  voice.quiet_asleep = true;
  CompletePolicy(voice, *config_.policy);
  BringUp();
  machine_.state = kLowPower;
  SetBattery(18);
  Record("policy", 0, 113, "wake-up refused");
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(), ElementsAre("1018"));
  machine_.state = kProtected;
  Show();
  EXPECT_THAT(Said(), ElementsAre("10020"));
}

TEST_F(Voices, ATornDownRobotAnnouncesNothingMore) {
  BringUp();
  Feed(voice_event::PlayReported{true});
  SetBattery(15);
  machine_.phase = Phase::kStopping;
  Show();
  EXPECT_THAT(Said(), IsEmpty());
}

// --- time ---

TEST_F(Voices, AWorldThatBeginsAgainTakesNoTimeFromWhatWaits) {
  answers_ = false;
  BringUp();
  Feed(voice_event::DoubleTapped{});
  Wait(seconds(2));
  now_ = Time{seconds(5)};
  Feed(voice_event::TimePassed{});
  Feed(voice_event::DoubleTapped{});
  EXPECT_THAT(Said(Milliseconds(3999)), ElementsAre("1080"));
  EXPECT_THAT(Said(Milliseconds(1)), ElementsAre("1080"));
}

}  // namespace musher::cyberdog::voice_occasions_test
