// SEARCH and INTERVIEW: states that were added without touching the engine or another state.

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "musher/base/toml/file.hpp"
#include "musher/test/modules/wedding/show_rig.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::wedding::extension_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

ShowConfig With(std::optional<SearchRules> search, std::optional<InterviewRules> interview) {
  ShowConfig config;
  config.search = search;
  config.interview = interview;
  return config;
}

TEST(Extension, IsKnownNeitherToTheEngineNorToTheFiveStates) {
  const std::filesystem::path source = SourceDir();
  int files = 0;
  for (const char* folder : {"behavior/fsm", "modules/wedding/states"}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source / folder)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream file(entry.path());
      const std::string text((std::istreambuf_iterator<char>(file)), {});
      ++files;
      for (const char* word : {"SEARCH", "INTERVIEW", "\"search\"", "interview", "extension/"}) {
        EXPECT_THAT(text, Not(HasSubstr(word))) << entry.path();
      }
    }
  }
  EXPECT_GT(files, 20);
}

class SearchShow : public ShowRig {
 protected:
  void SetUp() override { Begin(With(SearchRules{}, std::nullopt)); }
};

TEST_F(SearchShow, SearchesWhenAFaceIsSeenAndTracksAFaceThatStaysForTwoSeconds) {
  EXPECT_EQ(TicksToWithFace("SEARCH", 2), 1);
  EXPECT_EQ(TicksToWithFace("TRACKING", 200), 101);
  EXPECT_THAT(script_.sounds, ElementsAre("greeting"));
}

TEST_F(SearchShow, TimesOutAfterFiveSecondsWithoutAFace) {
  Command("search");
  EXPECT_EQ(TicksTo("SEARCH", 2), 1);
  EXPECT_EQ(TicksTo("IDLE", 500), 250);
}

TEST_F(SearchShow, TimesOutAfterTenSecondsOfAFaceThatComesAndGoes) {
  Face();
  Tick();
  int ticks = 0;
  while (state() == "SEARCH" && ticks < 1000) {
    if (ticks % 100 == 0) Face();  // every 2 s, each of which counts for 1.5 s
    Tick();
    ++ticks;
  }
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(ticks, 500);
}

TEST_F(SearchShow, LooksAboutFromSideToSideInAFullTurnOfEightSeconds) {
  SearchRules rules;
  rules.no_face = Milliseconds(9000);
  Begin(With(rules, std::nullopt));
  Command("search");
  Tick(Ticks(Milliseconds(2000)));
  EXPECT_GT(data().motion.look_at_target.x, 0.74);
  Tick(Ticks(Milliseconds(4000)));
  EXPECT_LT(data().motion.look_at_target.x, 0.26);
}

TEST_F(SearchShow, StillTracksAtOnceByCommand) {
  Command("tracking");
  Tick();
  EXPECT_EQ(state(), "TRACKING");
}

TEST_F(SearchShow, IsSafeAsAllOthers) {
  Command("search");
  Tick();
  TooClose(true);
  Tick();
  EXPECT_EQ(state(), "SAFE_STOP");
}

class InterviewShow : public ShowRig {
 protected:
  void SetUp() override { Begin(With(std::nullopt, InterviewRules{})); }
  void Voice(double level) { show_->OnVoiceLevel(level, now_); }
  // By command, with a face.
  void StartInterview() {
    Track();
    Command("interview");
    TickWithFace(1);
    ASSERT_EQ(state(), "INTERVIEW");
  }
};

TEST_F(InterviewShow, InterviewsAGuestWhoStaysForThreeAndAHalfSeconds) {
  Track();
  EXPECT_EQ(TicksToWithFace("INTERVIEW", 300), 176);
}

TEST_F(InterviewShow, InterviewsAGuestWhoStayedAndHidesBriefly) {
  Track();
  TickWithFace(Ticks(Milliseconds(2500)));
  EXPECT_EQ(TicksTo("INTERVIEW", 75), 24) << "0.5 s without a face";
}

TEST_F(InterviewShow, DoesNotInterviewAGuestWhoLeaves) {
  Track();
  TickWithFace(Ticks(Milliseconds(1000)));
  EXPECT_EQ(TicksTo("FAREWELL", 100), 74);
}

TEST_F(InterviewShow, InterviewsOnlyByCommandIfConfigured) {
  InterviewRules rules;
  rules.unasked = false;
  Begin(With(std::nullopt, rules));
  Track();
  TickWithFace(500);
  EXPECT_EQ(state(), "TRACKING");
  show_->OnVoiceCommand("interview", now_);
  TickWithFace(1);
  EXPECT_EQ(state(), "INTERVIEW");
}

TEST_F(InterviewShow, TakesAPhotoRatherThanAnInterview) {
  Track();
  Gesture("heart");
  TickWithFace(1);
  EXPECT_EQ(state(), "PHOTO_POSING");
}

TEST_F(InterviewShow, HandlesTheCommandInTrackingOnly) {
  Command("interview");
  Tick();
  EXPECT_EQ(state(), "IDLE");
  EXPECT_EQ(machine_->counts().unhandled, 1U);
}

TEST_F(InterviewShow, AsksThreeQuestionsAndThanks) {
  StartInterview();
  EXPECT_EQ(script_.poses.back(), "mic_hold");
  // 3.0 + 3 * (2.0 + 8.0) + 2.0 + 1.0 s with a guest who does not speak.
  EXPECT_EQ(TicksToWithFace("IDLE", 2000), Ticks(Milliseconds(36'000)));
  EXPECT_THAT(script_.sounds,
              ElementsAre("greeting", "interview_start", "interview_question_1",
                          "interview_question_2", "interview_question_3", "interview_thanks"));
  EXPECT_EQ(script_.poses.back(), "neutral");
}

TEST_F(InterviewShow, OfTheShippedConfigAsksTheSentencesOfTheVoiceAndTakesAsLongAsInItsManual) {
  const std::string source = SourceDir();
  const std::string file = source + "/config/wedding/second_generation.toml";
  const std::string config = config_toml::ReadTextFile(file, 1 << 20).value();
  const std::string cues =
      config_toml::ReadTextFile(source + "/config/audio/wedding_cues.toml", 1 << 20).value();
  for (const char* id : {"interview_question_1", "interview_question_2", "interview_question_3"}) {
    const std::string key = "zh = \"";
    const std::size_t begin = cues.find(key, cues.find("id = \"" + std::string(id))) + key.size();
    const std::string spoken = cues.substr(begin, cues.find('"', begin) - begin);
    EXPECT_THAT(config, HasSubstr("\"" + spoken + "\"")) << id;
  }

  const auto interview = ReadWeddingFile(file).config->show.interview;
  Begin(With(std::nullopt, interview));
  StartInterview();
  EXPECT_NEAR(TicksToWithFace("IDLE", 5000), Ticks(Milliseconds(43'000)), 2) << "whole ticks";
  EXPECT_THAT(config_toml::ReadTextFile(source + "/modules/wedding/README.md", 1 << 20).value(),
              HasSubstr("43 s later at most"));
}

TEST_F(InterviewShow, ContinuesASecondAndAHalfAfterAnAnswer) {
  StartInterview();
  TickWithFace(Ticks(Milliseconds(5000)));
  ASSERT_EQ(script_.sounds.back(), "interview_question_1");
  for (int i = 0; i < 50; ++i) {
    Voice(0.5);
    TickWithFace(1);
  }
  Voice(0.001);
  TickWithFace(70);
  EXPECT_EQ(script_.sounds.back(), "interview_question_1");
  TickWithFace(10);
  EXPECT_EQ(script_.sounds.back(), "interview_question_2");
}

TEST_F(InterviewShow, SpeaksLongQuestionsToTheirEnd) {
  InterviewRules rules;
  rules.question_characters = {10};
  Begin(With(std::nullopt, rules));
  StartInterview();
  TickWithFace(Ticks(Milliseconds(3000 + 4000)));
  Voice(0.5);  // it listens from now on
  TickWithFace(1);
  Voice(0);
  TickWithFace(80);
  EXPECT_EQ(script_.sounds.back(), "interview_thanks");
}

TEST_F(InterviewShow, EndsWhenTheGuestLeaves) {
  StartInterview();
  EXPECT_EQ(TicksTo("IDLE", 100), 75) << "1.5 s";
  EXPECT_EQ(script_.poses.back(), "neutral");
}

TEST(BothExtensions, LeadFromAFaceOverSearchAndTrackingToAnInterview) {
  class Rig : public ShowRig {
   public:
    Rig() {
      Begin(With(SearchRules{}, InterviewRules{}));
      TickWithFace(1000);
    }
    void TestBody() override {}
    std::vector<std::string> states() { return script_.states; }
  } rig;
  EXPECT_THAT(rig.states(), ElementsAre("IDLE", "SEARCH", "TRACKING", "INTERVIEW"));
}

}  // namespace musher::wedding::extension_test
