// The table of phrases: the text of a number, and the errors of a file.

#include <gmock/gmock.h>

#include <fstream>

#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/sound_file.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::audio::phrases_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr Language kEn = Language::kEnglish;
constexpr Language kZh = Language::kChinese;

std::vector<std::string> Texts(const std::vector<Diagnostic>& diagnostics) {
  std::vector<std::string> texts;
  texts.reserve(diagnostics.size());
  for (const Diagnostic& diagnostic : diagnostics) texts.push_back(FormatDiagnostic(diagnostic));
  return texts;
}

std::vector<std::string> FaultsOf(const std::string& text) {
  return Texts(ReadPhrasesText(text, "/tmp/p.toml").diagnostics);
}

TEST(Phrases, AreSpokenInTheLanguageOfTheConfigElseInTheOther) {
  const auto reading = ReadPhrasesText(R"(
[[phrase]]
id = 60
en = "well"
zh = "正常"
[[phrase]]
id = 61
en = "not well"
)",
                                       "p.toml");
  ASSERT_TRUE(reading.phrases);
  EXPECT_EQ(reading.phrases->Find(60, kZh), (Utterance{"正常", kZh, {}}));
  EXPECT_EQ(reading.phrases->Find(60, kEn), (Utterance{"well", kEn, {}}));
  EXPECT_EQ(reading.phrases->Find(61, kZh), (Utterance{"not well", kEn, {}}));
  EXPECT_EQ(reading.phrases->Find(59, kEn), std::nullopt);
  EXPECT_EQ(reading.phrases->Find(62, kEn), std::nullopt);
}

TEST(Phrases, OfARangeSpeakTheirNumber) {
  const auto reading = ReadPhrasesText(
      "[[phrase]]\nid = 1000\nlast_id = 1100\nen = \"{number} of {number}\"\n", "p.toml");
  ASSERT_TRUE(reading.phrases);
  EXPECT_EQ(reading.phrases->Find(1000, kEn)->text, "0 of 0");
  EXPECT_EQ(reading.phrases->Find(1100, kEn)->text, "100 of 100");
  EXPECT_FALSE(reading.phrases->Has(999));
  EXPECT_FALSE(reading.phrases->Has(1101));
}

TEST(Phrases, CanBeRecordings) {
  const TempFolder folder;
  ASSERT_TRUE(WriteWav(folder / "bark.wav", {8000, {1, 2, 3}}));
  const auto reading =
      ReadPhrasesText("[[phrase]]\nid = 7\nrecording = \"bark.wav\"\n", folder / "p.toml");
  ASSERT_TRUE(reading.phrases) << ::testing::PrintToString(Texts(reading.diagnostics));
  EXPECT_EQ(reading.phrases->Find(7, kEn)->recording, folder / "bark.wav");
}

TEST(Phrases, ReportTheMissingRecordingWithItsPlace) {
  EXPECT_THAT(
      FaultsOf("[[phrase]]\nid = 7\nrecording = \"absent.wav\"\n"),
      ElementsAre(::testing::AllOf(HasSubstr("p.toml:3:13: error: phrase.recording"),
                                   HasSubstr("/tmp/absent.wav: "), HasSubstr("No such file"))));
}

TEST(Phrases, ReportARecordingWithoutSound) {
  const TempFolder folder;
  std::ofstream(folder / "text.wav") << "this is no sound";
  const auto reading =
      ReadPhrasesText("[[phrase]]\nid = 7\nrecording = \"text.wav\"\n", folder / "p.toml");
  EXPECT_FALSE(reading.phrases);
  EXPECT_THAT(Texts(reading.diagnostics), ElementsAre(HasSubstr("p.toml:3:13: error: ")));
}

TEST(Phrases, ReportAllErrorsOfAFileAtOnce) {
  EXPECT_THAT(
      FaultsOf(R"([[phrase]]
id = 60
en = " "
[[phrase]]
en = "without a number"
[[phrase]]
id = 70000
en = "too far"
[[phrase]]
id = 9999
en = "stop"
[[phrase]]
id = 5
[[phrase]]
id = 6
en = "{number} without a row"
[[phrase]]
id = 8
last_id = 7
en = "backwards"
[[phrase]]
id = 60
fr = "encore"
)"),
      ElementsAre(HasSubstr("p.toml:3:6: error: phrase.en: expected a text"),
                  HasSubstr("p.toml:4:1: error: phrase: the key \"id\" is missing"),
                  HasSubstr("p.toml:7:6: error"),
                  HasSubstr("p.toml:10:6: error: phrase.id: 9999 stops"),
                  HasSubstr("p.toml:12:1: error: phrase.id: expected a text"),
                  HasSubstr("p.toml:16:6: error: phrase.en: {number} needs"),
                  HasSubstr("p.toml:19:11: error: phrase.last_id"),
                  HasSubstr("p.toml:21:1: error: phrase.id: expected a text"),
                  HasSubstr("p.toml:22:6: error: phrase.id: 60 is a phrase already, at line 2"),
                  HasSubstr("p.toml:23:1: error: phrase: unknown key \"fr\"")));
}

TEST(Phrases, OfTwoRangesMayNotOverlap) {
  EXPECT_THAT(FaultsOf("[[phrase]]\nid = 10\nlast_id = 20\nen = \"a\"\n"
                       "[[phrase]]\nid = 12\nen = \"b\"\n"
                       "[[phrase]]\nid = 20\nlast_id = 30\nen = \"c\"\n"),
              ElementsAre(HasSubstr("12 is a phrase already, at line 2"),
                          HasSubstr("20 is a phrase already, at line 2")));
}

TEST(AudioConfig, OfTheRobotIsWhole) {
  const Parsed<AudioConfig> reading = ReadAudioFile(SourceDir() + "/config/audio/audio.toml");
  ASSERT_TRUE(reading.config);
  EXPECT_THAT(Texts(reading.diagnostics), IsEmpty());
  EXPECT_EQ(reading.config->output.kind, OutputKind::kAuto);
  // The phrases that CyberDog's manager and this one request.
  std::vector<int> wanted = {60, 61, 2002, 5300, 9000, 10'000, 10'005, 10'020, 10'030, 31'058};
  for (int soc = 0; soc <= 100; ++soc) wanted.push_back(1000 + soc);
  for (int id = 31'006; id <= 31'027; ++id) wanted.push_back(id);
  for (const int id : wanted) {
    const Phrases& phrases = reading.config->phrases;
    for (const Language language : {kEn, kZh}) {
      const auto found = phrases.Find(static_cast<std::uint16_t>(id), language);
      ASSERT_TRUE(found) << id;
      EXPECT_EQ(found->language, language) << id;
      EXPECT_EQ(LanguageOf(found->text, language), language) << id;
    }
  }
}

TEST(AudioConfig, ReadsEveryKey) {
  const TempFolder folder;
  std::ofstream(folder / "phrases.toml") << "[[phrase]]\nid = 1\nen = \"one\"\n";
  const Parsed<AudioConfig> reading = ReadAudioText(R"(
output = "wav"
folder = "spoken"
volume = 30
language = "zh"
longest_text = 50
phrases = "phrases.toml"
[voice]
words_per_minute = 120
english = "en-gb"
chinese = "yue"
)",
                                                    folder / "audio.toml");
  ASSERT_TRUE(reading.config) << ::testing::PrintToString(Texts(reading.diagnostics));
  AudioConfig expected;
  expected.output = {OutputKind::kWav, "default", folder / "spoken"};
  expected.volume = 30;
  expected.language = kZh;
  expected.longest_text = 50;
  expected.phrases_file = folder / "phrases.toml";
  expected.voice = {120, "en-gb", "yue"};
  expected.phrases = Phrases({{1, 1, {{{kEn, "one"}}, {}}}});
  EXPECT_EQ(*reading.config, expected);
}

TEST(AudioConfig, ReportsAllErrorsOfBothFiles) {
  const TempFolder folder;
  std::ofstream(folder / "phrases.toml") << "[[phrase]]\nid = -1\nen = \"one\"\n";
  const Parsed<AudioConfig> reading = ReadAudioText(
      "output = \"radio\"\nvolume = 101\nlanguage = \"fr\"\nphrases = \"phrases.toml\"\n"
      "loudness = 3\n[voice]\nwords_per_minute = 9\nenglish = \"\"\n",
      folder / "audio.toml");
  EXPECT_FALSE(reading.config);
  EXPECT_THAT(Texts(reading.diagnostics),
              ElementsAre(HasSubstr("audio.toml:1:10: error: output"),
                          HasSubstr("audio.toml:2:10: error: volume"),
                          HasSubstr("audio.toml:3:12: error: language"),
                          HasSubstr("audio.toml:5:1: error: unknown key \"loudness\""),
                          HasSubstr("audio.toml:7:20: error: voice.words_per_minute"),
                          HasSubstr("audio.toml:8:11: error: voice.english"),
                          HasSubstr("phrases.toml:2:6: error: phrase.id")));
}

TEST(AudioConfig, NeedsItsPhrasesAndAFolderForWavFiles) {
  EXPECT_THAT(Texts(ReadAudioText("output = \"wav\"\n", "/tmp/a.toml").diagnostics),
              ElementsAre(HasSubstr("the key \"folder\" is missing"),
                          HasSubstr("the key \"phrases\" is missing")));
  EXPECT_THAT(Texts(ReadAudioText("phrases = \"absent.toml\"\n", "/tmp/a.toml").diagnostics),
              ElementsAre(HasSubstr("/tmp/absent.toml: error: the file cannot be read")));
  EXPECT_THAT(Texts(ReadAudioFile("/tmp/absent.toml").diagnostics),
              ElementsAre(HasSubstr("/tmp/absent.toml: error: the file cannot be read")));
}

}  // namespace musher::audio::phrases_test
