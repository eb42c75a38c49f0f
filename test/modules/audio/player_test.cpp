// What is played, in which order, and what each caller is answered: the decision code alone.

#include "musher/messages/protocol/audio.hpp"
#include "musher/test/modules/audio/harness.hpp"

namespace musher::audio::testing::player_test {

using play_action::Answer;
using play_action::Make;
using play_action::Play;
using play_action::Report;
using play_action::SetVolume;
using play_action::Silence;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class PlayerDecision : public ::testing::Test, protected Harness {};

TEST_F(PlayerDecision, MakesTheSoundThenPlaysItAndAnswersAtItsEnd) {
  Say(7, "Hello");
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{1, {"Hello", Language::kEnglish, {}}}));
  EXPECT_THAT(Answers(), IsEmpty());
  Made();
  EXPECT_THAT(Those<Play>(), ElementsAre(Play{1}));
  EXPECT_THAT(LogText(), HasSubstr(R"(plays "Hello" for "app")"));
  Pass(Milliseconds(9'999));
  EXPECT_THAT(Answers(), IsEmpty());
  Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{7, 0}));
}

TEST_F(PlayerDecision, SpeaksChineseByTheTextsCharactersAndPhrasesInTheConfigsLanguage) {
  Say(1, "你好 Bob");
  EXPECT_EQ(Those<Make>().at(0).what.language, Language::kChinese);
  Made(), Ended();
  Say(2, "42");
  EXPECT_EQ(Those<Make>().at(0).what.language, Language::kEnglish);
  Made(), Ended();
  PlayId(3, 60);
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{3, {"all well", Language::kEnglish, {}}}));
}

TEST_F(PlayerDecision, SpeaksTheBatterysLevelAsANumberAndPlaysRecordings) {
  PlayId(1, 1055);
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{1, {"at 55 percent", Language::kEnglish, {}}}));
  Made(), Ended();
  PlayId(2, 60'000);
  EXPECT_EQ(Those<Make>().at(0).what.recording, "/music/waltz.wav");
}

TEST_F(PlayerDecision, LetsASecondRequestWaitForTheEndOfTheFirst) {
  Say(1, "first");
  Made();
  Say(2, "second");
  EXPECT_THAT(Those<Make>(), IsEmpty());
  Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 0}));
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{2, {"second", Language::kEnglish, {}}}));
}

TEST_F(PlayerDecision, CountsTheTenSecondsOfAWaitingRequestFromItsArrival) {
  Say(1, "first");
  Made();
  Pass(Milliseconds(2'000));
  Say(2, "second");
  Pass(Milliseconds(8'000));
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5007}));
  EXPECT_THAT(Those<Silence>(), IsEmpty()) << "the playing sound continues";
  Pass(Milliseconds(2'000));
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5007}));
  Ended();
  EXPECT_THAT(Those<Make>(), IsEmpty()) << "what had not begun by then never does";
  EXPECT_THAT(Answers(), IsEmpty()) << "each is answered once";
}

TEST_F(PlayerDecision, PlaysAGoalWithoutATimeLimit) {
  Say(1, "long");
  Made();
  Say(2, "goal", true);
  Pass(std::chrono::minutes(5));
  EXPECT_THAT(player().waiting, SizeIs(1));
  Ended();
  Made();
  EXPECT_THAT(Those<Play>(), ElementsAre(Play{2}));
  Pass(std::chrono::minutes(5));
  EXPECT_THAT(Answers(), IsEmpty());
  Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 0}));
}

TEST_F(PlayerDecision, ChecksARequestBeforeItIsMade) {
  const Phrases phrases = ThePhrases();
  const PlayRules rules{phrases, Language::kEnglish, 100};
  const auto code = [&](const PlayRequest& request) {
    const Result<> checked = CheckRequest(rules, player(), request);
    return checked ? 0 : checked.error().code;
  };
  EXPECT_EQ(code({0, "app", true, 0, "hello", true}), 0);
  EXPECT_EQ(code({0, "app", true, 0, " ", true}), 5024);
  EXPECT_EQ(code({0, "app", false, 4711, {}, true}), 5023);
  for (CallToken token = 1; token <= 17; ++token) Say(token, "one of many");
  EXPECT_EQ(code({0, "app", true, 0, "hello", true}), 5011);
  EXPECT_EQ(code({0, "app", true, 0, "hello", false}), 0) << "a topic does not wait";
  EXPECT_EQ(code({0, "app", false, 9999, {}, true}), 0) << "a stop";
}

TEST_F(PlayerDecision, CancelsTheSoundOfOneGoalOnly) {
  Say(1, "sounds", true);
  Made();
  Say(2, "waits", true);
  Say(3, "waits, too", true);
  Do(play_event::CancelRequested{2});
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5022}));
  EXPECT_THAT(Those<Silence>(), IsEmpty());
  Do(play_event::CancelRequested{1});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5022}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{3, {"waits, too", Language::kEnglish, {}}}));
  Do(play_event::CancelRequested{1});
  EXPECT_THAT(Answers(), IsEmpty()) << "it has ended";
}

TEST_F(PlayerDecision, AnswersTheLimitAlsoWhenTheSoundIsNeverMade) {
  Say(1, "first");
  EXPECT_EQ(NextTime(player()), now() + kAnswerTime);
  Pass(kAnswerTime);
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5007}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  EXPECT_EQ(NextTime(player()), std::nullopt);
}

TEST_F(PlayerDecision, TreatsASoundThatEndsAtItsLimitAsInTime) {
  Say(1, "ten seconds");
  Made();
  now() += kAnswerTime;
  Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 0}));
}

TEST_F(PlayerDecision, TreatsASoundThatEndsAfterItsLimitAsLate) {
  Say(1, "ten seconds and a bit");
  Made();
  now() += kAnswerTime + Milliseconds(1);
  Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5007}));
}

TEST_F(PlayerDecision, InterruptsWhatPlaysByATopicAndAnswersTheInterruptedCaller) {
  Say(1, "long scenario");
  Made();
  Say(2, "waits");
  PlayId(0, 60);
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5021}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{3, {"all well", Language::kEnglish, {}}}));
  Made(), Ended();
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{2, {"waits", Language::kEnglish, {}}}))
      << "the waiting sounds keep waiting";
}

TEST_F(PlayerDecision, PlaysTheNewestOfManyTopicRequests) {
  Say(0, "one");
  Say(0, "two");
  Say(0, "three");
  EXPECT_EQ(player().current->what.text, "three");
  EXPECT_THAT(player().waiting, IsEmpty());
  EXPECT_EQ(NextTime(player()), std::nullopt) << "no caller waits for it";
}

TEST_F(PlayerDecision, DoesNotConfuseTheEndOfAnInterruptedSoundWithThatOfItsSuccessor) {
  Say(1, "one");
  Made();
  Say(0, "two");
  Made();
  EXPECT_THAT(Do(play_event::Ended{1, {}}), IsEmpty());
  ASSERT_TRUE(player().current);
  EXPECT_EQ(player().current->what.text, "two");
}

TEST_F(PlayerDecision, LeavesWhatPlaysAloneWhenItRefuses) {
  Say(1, "plays");
  Made();
  PlayId(0, 4711);
  EXPECT_EQ(player().current->what.text, "plays");
  EXPECT_THAT(LogText(), HasSubstr("unknown phrase 4711"));
}

TEST_F(PlayerDecision, RefusesInvalidRequestsEachWithItsCode) {
  PlayId(1, 4711);
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5023}));
  Say(2, "");
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5024}));
  Say(3, " \n\xE3\x80\x80\t");
  EXPECT_THAT(Answers(), ElementsAre(Answer{3, 5024}));
  Say(4, std::string(10'240, 'a'));
  EXPECT_THAT(Answers(), ElementsAre(Answer{4, 5025}));
  EXPECT_THAT(LogText(), HasSubstr("the text has 10240 characters, the limit is 100"));
  Say(5, "a\xFF");
  EXPECT_THAT(Answers(), ElementsAre(Answer{5, 5026}));
  EXPECT_EQ(player().current, std::nullopt);
}

TEST_F(PlayerDecision, LogsTheSameRefusalOnceInTenSecondsAndAnswersEach) {
  PlayId(1, 4711);
  EXPECT_THAT(LogText(), HasSubstr("4711"));
  PlayId(2, 4711);
  EXPECT_EQ(LogText(), "");
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5023}));
  PlayId(3, 4712);
  EXPECT_THAT(LogText(), HasSubstr("4712"));
  Pass(Milliseconds(9'000));
  now() = Time{} + Milliseconds(1);  // the world was restarted
  PlayId(4, 4712);
  EXPECT_EQ(LogText(), "");
  Pass(Milliseconds(1'000));
  PlayId(5, 4712);
  EXPECT_THAT(LogText(), HasSubstr("4712"));
}

TEST_F(PlayerDecision, CountsCharactersNotBytes) {
  std::string chinese;
  for (int i = 0; i < 100; ++i) chinese += "好";
  Say(1, chinese);
  EXPECT_THAT(Answers(), IsEmpty());
  Say(2, chinese + "好");
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5025}));
}

TEST_F(PlayerDecision, SpeaksPastAZeroInTheText) {
  Say(1, std::string("one\0two", 7));
  EXPECT_EQ(Those<Make>().at(0).what.text, "one two");
}

TEST_F(PlayerDecision, LetsAtMostSixteenWait) {
  Say(1, "plays");
  for (CallToken token = 2; token < 18; ++token) Say(token, "waits");
  EXPECT_THAT(Answers(), IsEmpty());
  Say(18, "one too many");
  EXPECT_THAT(Answers(), ElementsAre(Answer{18, 5011}));
  Say(0, "a topic");
  EXPECT_EQ(player().current->what.text, "a topic");
}

TEST_F(PlayerDecision, StopsAllThatPlaysAndWaits) {
  Say(1, "plays");
  Made();
  Say(2, "waits");
  Do(play_event::StopRequested{3});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5022}, Answer{2, 5022}, Answer{3, 0}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  EXPECT_EQ(player().current, std::nullopt);
}

TEST_F(PlayerDecision, StopsByTheId9999Too) {
  Say(1, "plays");
  PlayId(2, msg::AudioPlay::kStop);
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5022}, Answer{2, 0}));
  Say(0, "plays");
  PlayId(0, msg::AudioPlay::kStop);
  EXPECT_EQ(player().current, std::nullopt);
}

TEST_F(PlayerDecision, AnswersAStopOfSilence) {
  Do(play_event::StopRequested{1});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 0}));
}

TEST_F(PlayerDecision, ReportsSoundEvery500MillisecondsAndItsEndOnce) {
  Say(0, "hello");
  EXPECT_THAT(Those<Report>(), IsEmpty()) << "not played yet";
  Made();
  EXPECT_THAT(Those<Report>(), ElementsAre(Report{true}));
  EXPECT_EQ(NextTime(player()), now() + Milliseconds(500));
  Pass(Milliseconds(499));
  EXPECT_THAT(Those<Report>(), IsEmpty());
  Pass(Milliseconds(1));
  EXPECT_THAT(Those<Report>(), ElementsAre(Report{true}));
  Ended();
  EXPECT_THAT(Those<Report>(), ElementsAre(Report{false}));
  EXPECT_EQ(NextTime(player()), std::nullopt);
  Pass(Milliseconds(500));
  EXPECT_THAT(Those<Report>(), IsEmpty());
}

TEST_F(PlayerDecision, ReportsNoSilenceBetweenTwoSoundsOfARow) {
  Say(1, "one");
  Made();
  Say(2, "two");
  Ended();
  EXPECT_THAT(Those<Report>(), IsEmpty());
  Made();
  EXPECT_THAT(Those<Report>(), ElementsAre(Report{true}));
}

TEST_F(PlayerDecision, ReportsWhyASoundCouldNotBeMade) {
  Say(1, "hello");
  Do(play_event::Made{1, Error{5027, "espeak-ng: no"}});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5027}));
  EXPECT_THAT(LogText(), HasSubstr("espeak-ng: no"));
}

TEST_F(PlayerDecision, LogsALostDeviceOnceAnswersEveryCallerAndLogsItsReturn) {
  const Error lost{5012, "sound device hw:0: No such device"};
  Say(1, "one");
  Made();
  Say(2, "two");
  Do(play_event::Ended{Number(), lost});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5012}));
  EXPECT_THAT(LogText(), HasSubstr("No such device"));
  Made();
  Do(play_event::Ended{Number(), lost});
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5012}));
  EXPECT_EQ(LogText(), "");
  Say(3, "three");
  Made(), Ended();
  EXPECT_THAT(Answers(), ElementsAre(Answer{3, 0}));
  EXPECT_THAT(LogText(), HasSubstr("the sound device is available again"));
}

TEST_F(PlayerDecision, ChangesTheVolumeWithinItsRange) {
  Do(play_event::VolumeRequested{1, 0});
  EXPECT_THAT(Those<SetVolume>(), ElementsAre(SetVolume{0}));
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 0}));
  Do(play_event::VolumeRequested{2, 101});
  EXPECT_THAT(Those<SetVolume>(), IsEmpty());
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5010}));
  EXPECT_EQ(player().volume, 0);
}

TEST_F(PlayerDecision, KeepsTheMicrophonesStateWithoutFallingSilent) {
  Say(1, "plays");
  Made();
  Do(play_event::MicrophoneRequested{2, msg::AudioStatus::kOffMic});
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 0}));
  EXPECT_TRUE(player().microphone_off);
  EXPECT_NE(player().current, std::nullopt);
  Do(play_event::MicrophoneRequested{3, 2});
  EXPECT_THAT(Answers(), ElementsAre(Answer{3, 5010}));
  EXPECT_TRUE(player().microphone_off);
}

TEST_F(PlayerDecision, SwitchesVoiceControlOffForAnUpgradeAndKeepsItOff) {
  Do(play_event::StateEntered{State(kOta)});
  EXPECT_FALSE(player().voice_control);
  Do(play_event::VoiceControlRequested{1, true});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5003}));
  Do(play_event::StateEntered{State(kActive)});
  EXPECT_FALSE(player().voice_control) << "until it is requested";
  Do(play_event::VoiceControlRequested{2, true});
  EXPECT_TRUE(player().voice_control);
}

TEST_F(PlayerDecision, ContinuesSpeakingInEveryStateButTearDown) {
  Say(1, "plays");
  Made();
  for (const auto state : {kSelfCheck, kActive, kDeActive, kProtected, kLowPower, kOta, kError}) {
    EXPECT_THAT(Do(play_event::StateEntered{State(state)}), IsEmpty()) << state;
  }
  Do(play_event::StateEntered{State(kTearDown)});
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5022}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  Say(2, "hello");
  EXPECT_THAT(Answers(), ElementsAre(Answer{2, 5003}));
}

TEST_F(PlayerDecision, KeepsWhatWasLeftOfItsTimesWhenTheWorldIsRestarted) {
  Say(1, "plays");
  Made();
  Pass(Milliseconds(4'000));
  now() = Time{} + Milliseconds(100);
  Do(play_event::TimePassed{});
  EXPECT_THAT(Answers(), IsEmpty());
  Pass(Milliseconds(5'999));
  EXPECT_THAT(Answers(), IsEmpty());
  Pass(Milliseconds(1));
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5007}));
}

TEST_F(PlayerDecision, CountsFromTheFirstTimeOfAWorldThatStartsLater) {
  now() = Time{};
  Say(1, "early");
  now() = Time{} + std::chrono::hours(2);
  Do(play_event::TimePassed{});
  EXPECT_THAT(Answers(), IsEmpty());
  Pass(kAnswerTime);
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5007}));
}

}  // namespace musher::audio::testing::player_test
