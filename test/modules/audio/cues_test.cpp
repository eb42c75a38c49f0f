// Sounds that are requested by name: what is played, and the errors of a file.

#include <fstream>

#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/sound_file.hpp"
#include "musher/test/modules/audio/harness.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::audio::testing::cues_test {

using play_action::Answer;
using play_action::Make;
using play_action::Silence;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kUrgent = 0;  // of TheCueTopics()

class CueDecision : public ::testing::Test, protected Harness {};

TEST_F(CueDecision, SpeaksTheTextOfACueOrPlaysItsRecording) {
  Cue(kUrgent, "greeting");
  EXPECT_THAT(Those<Make>(), ElementsAre(Make{1, {"welcome", Language::kEnglish, {}}}));
  Made();
  EXPECT_THAT(LogText(), HasSubstr(R"(plays "welcome" for "greeting")"));
  Ended();
  EXPECT_THAT(Answers(), IsEmpty()) << "no caller waits for it";
  Cue(kUrgent, "shutter");
  EXPECT_EQ(Those<Make>().at(0).what.recording, "/sounds/shutter.wav");
}

TEST_F(CueDecision, InterruptsWhatPlaysWhereItsTopicDoes) {
  Say(1, "long scenario");
  Made();
  Cue(kUrgent, "greeting");
  EXPECT_THAT(Answers(), ElementsAre(Answer{1, 5021}));
  EXPECT_THAT(Those<Silence>(), SizeIs(1));
  EXPECT_EQ(player().current->what.text, "welcome");
}

TEST_F(CueDecision, WaitsForItsTurnWhereItsTopicDoesNotInterrupt) {
  Say(1, "long scenario");
  Made();
  Cue(kWaitingCues, "greeting");
  Cue(kWaitingCues, "shutter");
  EXPECT_THAT(Those<Make>(), IsEmpty());
  Ended();
  EXPECT_EQ(Those<Make>().at(0).what.text, "welcome");
  Made(), Ended();
  EXPECT_EQ(Those<Make>().at(0).what.recording, "/sounds/shutter.wav");
}

TEST_F(CueDecision, FollowsTheInterruptSettingOfTheCueItself) {
  Say(1, "long scenario");
  Made();
  Cue(kUrgent, "by the way");
  EXPECT_EQ(player().current->what.text, "long scenario");
  Cue(kWaitingCues, "fire");
  EXPECT_EQ(player().current->what.text, "fire");
  Made(), Ended();
  EXPECT_EQ(player().current->what.text, "by the way");
}

// No "Three, two, one!" after "Please step back".
TEST_F(CueDecision, DropsTheWaitingCuesOfItsTopicWhenOneInterrupts) {
  Cue(kWaitingCues, "greeting");
  Made();
  Cue(kWaitingCues, "shutter");
  Say(1, "a request");
  Cue(kUrgent, "by the way");
  Cue(kWaitingCues, "fire");
  EXPECT_EQ(player().current->what.text, "fire");
  Made(), Ended();
  EXPECT_EQ(player().current->what.text, "a request") << "the requests of others keep waiting";
  Made(), Ended();
  EXPECT_EQ(player().current->what.text, "by the way");
  Made(), Ended();
  EXPECT_FALSE(player().current);
}

TEST_F(CueDecision, DropsACueWhoseTurnComesTooLate) {
  Say(0, "endless");
  Made();
  Cue(kWaitingCues, "greeting");
  EXPECT_LE(NextTime(player()), now() + kAnswerTime);
  Pass(kAnswerTime);
  EXPECT_THAT(LogText(), HasSubstr("\"greeting\" was not played: timeout in the queue"));
  Ended();
  EXPECT_THAT(Those<Make>(), IsEmpty());
}

TEST_F(CueDecision, RefusesACueWhenTheQueueIsFull) {
  Say(0, "plays");
  for (std::size_t i = 0; i <= kMostWaiting; ++i) Cue(kWaitingCues, "greeting");
  EXPECT_THAT(LogText(), HasSubstr("refused cue \"greeting\": 16 sounds are queued already"));
  EXPECT_THAT(player().waiting, SizeIs(kMostWaiting));
}

TEST_F(CueDecision, LogsAnUnknownCueOnceAndLeavesWhatPlaysAlone) {
  Say(1, "plays");
  Made();
  Cue(kUrgent, "greetings");
  EXPECT_EQ(LogText(), "/show/play has no cue \"greetings\"");
  Pass(std::chrono::hours(1));
  Cue(kUrgent, "");
  EXPECT_THAT(LogText(), HasSubstr("no cue \"\""));
  Cue(kUrgent, "greetings");
  EXPECT_EQ(LogText(), "");
  EXPECT_THAT(Those<Silence>(), IsEmpty());
}

TEST_F(CueDecision, DoesNotFillTheLogNorTheMemoryWithTenThousandUnknownCues) {
  std::string log;
  for (int i = 0; i < 10'000; ++i) {
    Cue(kUrgent, std::to_string(i) + std::string(1'000, 'x'));
    log += LogText();
  }
  EXPECT_LT(log.size(), 5'000U);
  EXPECT_THAT(log, HasSubstr("further ones are not logged"));
  EXPECT_THAT(player().unknown_cues, SizeIs(kMostUnknownCues));
}

TEST_F(CueDecision, PlaysNothingAfterTearDown) {
  Do(play_event::StateEntered{State(kLowPower)});
  Cue(kUrgent, "greeting");
  EXPECT_THAT(Those<Make>(), SizeIs(1)) << "in every other state it does";
  Do(play_event::StateEntered{State(kTearDown)});
  Cue(kUrgent, "greeting");
  EXPECT_THAT(Those<Make>(), IsEmpty());
  EXPECT_THAT(LogText(), HasSubstr("refused cue \"greeting\": the robot is being shut down"));
}

std::vector<std::string> Texts(const std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> texts;
  texts.reserve(diagnostics.size());
  for (const Diagnostic& diagnostic : diagnostics) texts.push_back(FormatDiagnostic(diagnostic));
  return texts;
}

TEST(Cues, AreReadWithTheirTextsAndRecordings) {
  const TempFolder folder;
  ASSERT_TRUE(WriteWav(folder / "click.wav", {8000, {1, 2, 3}}));
  const auto reading = ReadCuesText(
      "[[cue]]\nid = \"hello\"\nen = \"Hello\"\nzh = \"你好\"\n"
      "[[cue]]\nid = \"shutter\"\nrecording = \"click.wav\"\n"
      "interrupts = true\n",
      folder / "c.toml");
  ASSERT_TRUE(reading.cues) << ::testing::PrintToString(Texts(reading.diagnostics));
  EXPECT_EQ(reading.cues->at("hello").spoken.In(Language::kChinese),
            (Utterance{"你好", Language::kChinese, {}}));
  EXPECT_EQ(reading.cues->at("hello").interrupts, std::nullopt);
  const musher::audio::Cue& shutter = reading.cues->at("shutter");
  EXPECT_EQ(shutter.spoken.In(Language::kEnglish).recording, folder / "click.wav");
  EXPECT_EQ(shutter.interrupts, true);
}

TEST(Cues, ReportAllErrorsOfAFileAtOnce) {
  const auto reading = ReadCuesText(
      R"([[cue]]
id = "one"
en = " "
[[cue]]
en = "without a name"
[[cue]]
id = ""
en = "with none"
[[cue]]
id = "one"
recording = "absent.wav"
[[cue]]
id = "two"
fr = "deux"
)",
      "/tmp/c.toml");
  EXPECT_FALSE(reading.cues);
  EXPECT_THAT(
      Texts(reading.diagnostics),
      ElementsAre(HasSubstr("c.toml:3:6: error: cue.en: expected a text"),
                  HasSubstr("c.toml:4:1: error: cue: the key \"id\" is missing"),
                  HasSubstr("c.toml:7:6: error: cue.id: expected a name, found nothing"),
                  HasSubstr("c.toml:10:6: error: cue.id: \"one\" is a cue already, at line 2"),
                  AllOf(HasSubstr("c.toml:11:13: error: cue.recording"), HasSubstr("/tmp/absent")),
                  HasSubstr("c.toml:12:1: error: cue.id: expected a text (en, zh)"),
                  HasSubstr("c.toml:14:1: error: cue: unknown key \"fr\"")));
}

TEST(CueTopics, AreReadWithTheConfig) {
  const TempFolder folder;
  std::ofstream(folder / "phrases.toml") << "[[phrase]]\nid = 1\nen = \"one\"\n";
  std::ofstream(folder / "cues.toml") << "[[cue]]\nid = \"a\"\nen = \"an a\"\n";
  const Parsed<AudioConfig> reading = ReadAudioText(
      "phrases = \"phrases.toml\"\n"
      "[[cues]]\ntopic = \"/show/play\"\nfile = \"cues.toml\"\n"
      "[[cues]]\ntopic = \"show/say\"\nfile = \"cues.toml\"\ninterrupts = false\n",
      folder / "audio.toml");
  ASSERT_TRUE(reading.config) << ::testing::PrintToString(Texts(reading.diagnostics));
  const Cues cues = {{"a", {{{{Language::kEnglish, "an a"}}, {}}}}};
  EXPECT_THAT(reading.config->cue_topics,
              ElementsAre(CueTopic{"/show/play", true, cues}, CueTopic{"show/say", false, cues}));
}

TEST(CueTopics, ReportAllErrorsOfAllFiles) {
  const TempFolder folder;
  std::ofstream(folder / "cues.toml") << "[[cue]]\nid = 3\nen = \"an a\"\n";
  const Parsed<AudioConfig> reading = ReadAudioText(
      "phrases = \"phrases.toml\"\n"
      "[[cues]]\ntopic = \"/show play\"\nfile = \"cues.toml\"\n"
      "[[cues]]\ntopic = \"/show/play\"\nfile = \"absent.toml\"\n"
      "[[cues]]\nfile = \"\"\nqueue = 3\n"
      "[[cues]]\ntopic = \"/show/play\"\nfile = \"gone.toml\"\n",
      folder / "audio.toml");
  EXPECT_FALSE(reading.config);
  EXPECT_THAT(
      Texts(reading.diagnostics),
      ElementsAre(HasSubstr("audio.toml:3:9: error: cues.topic: expected the name of a topic"),
                  HasSubstr("audio.toml:8:1: error: cues: the key \"topic\" is missing"),
                  HasSubstr("audio.toml:9:8: error: cues.file: expected a name"),
                  HasSubstr("audio.toml:10:1: error: cues: unknown key \"queue\""),
                  HasSubstr("audio.toml:12:9: error: cues.topic: \"/show/play\" has its"),
                  HasSubstr("phrases.toml: error: the file cannot be read"),
                  HasSubstr("cues.toml:2:6: error: cue.id"),
                  HasSubstr("absent.toml: error: the file cannot be read"),
                  HasSubstr("gone.toml: error: the file cannot be read")));
}

TEST(CueTopics, OfTheWeddingRobotHaveEverySoundInBothLanguages) {
  const Parsed<AudioConfig> reading = ReadAudioFile(SourceDir() + "/config/audio/wedding.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(Texts(reading.diagnostics), IsEmpty());
  ASSERT_THAT(reading.config->cue_topics, SizeIs(1));
  const CueTopic& topic = reading.config->cue_topics[0];
  EXPECT_EQ(topic.topic, "wedding/audio/play");
  for (const char* id :
       {"greeting", "photo_confirm", "countdown", "shutter", "photo_done", "farewell", "too_close",
        "interview_start", "interview_question_1", "interview_question_2", "interview_question_3",
        "interview_thanks", "idle_greeting"}) {
    ASSERT_TRUE(topic.cues.contains(id)) << id;
  }
  EXPECT_FALSE(topic.interrupts) << "photo_done and greeting follow each other at once";
  EXPECT_EQ(topic.cues.at("too_close").interrupts, true);
  for (const auto& [id, cue] : topic.cues) {
    for (const Language language : {Language::kEnglish, Language::kChinese}) {
      const Utterance what = cue.spoken.In(language);
      EXPECT_EQ(what.language, language) << id;
      EXPECT_EQ(LanguageOf(what.text, language), language) << id;
    }
  }
}

}  // namespace musher::audio::testing::cues_test
