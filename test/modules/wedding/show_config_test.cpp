// The wedding robot's config file, read and checked.

#include "musher/modules/wedding/show_config.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

#include <gmock/gmock.h>

namespace musher::wedding::show_config_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

WeddingConfig Shipped(const char* file) {
  const Parsed<WeddingConfig> reading = ReadWeddingFile(SourceDir() + "/config/wedding/" + file);
  for (const Diagnostic& diagnostic : reading.diagnostics) {
    ADD_FAILURE() << FormatDiagnostic(diagnostic);
  }
  return reading.config.value_or(WeddingConfig{});
}

TEST(WeddingConfigTest, HasTheDefaultsWithAnEmptyFile) {
  const Parsed<WeddingConfig> reading = ReadWeddingText("", "show.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  EXPECT_EQ(reading.config, WeddingConfig{});
}

TEST(WeddingConfigTest,
     OfTheShippedShowDiffersFromTheDefaultsInItsStartItsCameraAndItsBlindTimeoutOnly) {
  const WeddingConfig config = Shipped("wedding.toml");
  EXPECT_EQ(config.show.gaze.camera, Mount::kHead);
  WeddingConfig plain = config;
  plain.show.gaze = {};
  plain.show.perception.blind = {};
  EXPECT_TRUE(config.autostart) << "set by a person: the show stands at its place";
  plain.autostart = false;
  EXPECT_EQ(Shipped("second_generation.toml").show.gaze, config.show.gaze);
  EXPECT_EQ(Shipped("second_generation.toml").show.perception, config.show.perception);
  EXPECT_EQ(plain, WeddingConfig{});
}

TEST(WeddingConfigTest, OfTheSecondGenerationHasAllItsExtensions) {
  const ShowConfig show = Shipped("second_generation.toml").show;
  EXPECT_EQ(show.search, SearchRules{});
  ASSERT_TRUE(show.interview);
  EXPECT_EQ(show.interview->question_characters.size(), 3);
  EXPECT_TRUE(show.interview->video);
  EXPECT_EQ(show.actions, ActionRules{});
  EXPECT_TRUE(Shipped("second_generation.toml").second_generation);
}

TEST(WeddingConfigTest, ReportsWhatIsWrongAndWhere) {
  const std::string search = "[search]\nenabled = true\n";
  musher::testing::ExpectDiagnostics(
      [](const std::string& text) { return ReadWeddingText(text, "show.toml"); },
      {{"all errors at once",
        "rate_hz = 0\n[gaze]\ncamera = \"hat\"\nfollow = 1.5\n[idle]\nswai = 0.1\n[search]\n"
        "enabled = \"yes\"\n",
        {"show.toml:1:11: error: rate_hz", "show.toml:3:10: error: gaze.camera",
         "show.toml:4:10: error: gaze.follow", "show.toml:6:1: error: idle: unknown key \"swai\"",
         "show.toml:8:11: error: search.enabled"}},
       {"actions without a search, a check and a video without a camera",
        "[actions]\nenabled = true\nidle_least_ms = 30000\n[check]\nready = \"required\"\n"
        "[interview]\nenabled = true\nvideo = true\n[photo]\nservice = \"\"\n",
        {"show.toml:2:11: error: actions.enabled", "show.toml:3:17: error: actions.idle_least_ms",
         "show.toml:5:9: error: check.ready", "show.toml:8:9: error: interview.video"}},
       {"a face is lost that still counts",
        "[perception]\nage_ms = 3000\n[tracking]\nlost_ms = 1500\n",
        {"show.toml:4:11: error: tracking.lost_ms"}},
       {"the same, by the default",
        "[perception]\nage_ms = 3000\n",
        {"show.toml:2:10: error: perception.age_ms"}},
       {"a camera service that is no name",
        "[photo]\nservice = \"camera service!\"\n",
        {"show.toml:2:11: error: photo.service"}},
       {"right: no camera", "[photo]\nservice = \"\"\n", {}},
       {"right: an absolute name", "[photo]\nservice = \"/hall/camera_service\"\n", {}},
       {"a confirmation after the timeout",
        search + "confirm_ms = 20000\n",
        {"show.toml:3:14: error: search.confirm_ms"}},
       {"a timeout before the confirmation",
        search + "timeout_ms = 1000\n",
        {"show.toml:3:14: error: search.timeout_ms"}},
       {"the least above the most",
        "[interview]\nenabled = true\nlost_least_ms = 1500\nlost_most_ms = 500\n",
        {"show.toml:3:17: error: interview.lost_least_ms"}},
       {"the most below the least",
        "[interview]\nlost_most_ms = 500\n",
        {"show.toml:2:16: error: interview.lost_most_ms"}}});
}

// scripts/demo wedding kills it: 1.5 s of real time in a world at speed 2, and as much again.
TEST(WeddingConfigTest, OfTheShippedShowOutlastsADetectorRestart) {
  EXPECT_GE(Shipped("wedding.toml").show.perception.blind, Milliseconds(6000));
  EXPECT_LE(Shipped("wedding.toml").show.perception.blind, Milliseconds(10'000));
}

TEST(WeddingConfigTest, CountsTheCharactersOfQuestionsAsPeopleDo) {
  const auto reading =
      ReadWeddingText("[interview]\nenabled = true\nquestions = [\"ab\", \"你好吗\"]\n", "");
  EXPECT_THAT(reading.config->show.interview->question_characters, ElementsAre(2, 3));
}

}  // namespace musher::wedding::show_config_test
