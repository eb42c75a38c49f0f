// Recordings of races: those that exist stay readable, and damaged ones do no harm.

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "musher/application/fsm_replay_file.hpp"
#include "musher/behavior/fsm/replay.hpp"
#include "musher/test/modules/race/race_rig.hpp"

namespace musher::race::recording_test {

using ::testing::HasSubstr;

// Recorded in September 2026, with words that stand for themselves.
std::string Golden() {
  return SourceDir() + "/test/modules/race/recordings/board.record";
}

std::string GoldenText() {
  std::ifstream stream(Golden());
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(RaceRecording, OfAnEarlierVersionIsReplayedIdentically) {
  Field field;
  std::ostringstream out, err;
  Course course = TheCourse();
  course.check.agreeing = 1;  // as it was then
  const ReplayExit exit = ReplayFile(
      Golden(),
      [&](fsm::Machine& machine) -> Result<ReplayedInput> {
        const auto race = std::make_shared<Race>(course, field);
        if (const Result<> built = race->Build(machine); !built) return built.error();
        race->Resume({});
        return ReplayedInput([race](std::string_view input, std::string_view text) {
          return race->Apply(input, text);
        });
      },
      out, err);
  EXPECT_EQ(exit, ReplayExit::kIdentical) << out.str() << err.str();
  EXPECT_THAT(out.str(), HasSubstr("IN_QR_A -> QRA_TO_A2  decided"));
  EXPECT_TRUE(field.Logged("IN_QR_A: qr_a is A-2"));
}

// A byte is another one, or missing; or a time is beyond every clock.
TEST(RaceRecording, ThatIsDamagedIsRefusedOrReplayed) {
  const std::string golden = GoldenText();
  ASSERT_FALSE(golden.empty());
  std::uint32_t seed = 1;
  const auto random = [&seed](std::size_t below) {
    seed = seed * 1'664'525U + 1'013'904'223U;
    return (seed >> 8U) % below;
  };
  int replayed = 0;
  for (int i = 0; i < 150; ++i) {
    std::string text = golden;
    const std::size_t at = random(text.size());
    if (i % 3 == 0) text[at] = static_cast<char>(' ' + random(95));
    if (i % 3 == 1) text.erase(at, 1 + random(4));
    if (i % 3 == 2) text.insert(text.find_first_of("0123456789", at) + 1, "999999999999");
    const auto recording = fsm::ReadRecording(text, "damaged.record");
    if (!recording) continue;
    Field field;
    fsm::Machine machine({.name = recording.value().machine});  // outlives the race
    Race race(TheCourse(), field);
    ASSERT_TRUE(race.Build(machine));
    race.Resume({});
    const auto result = fsm::Replay(
        recording.value(), machine,
        [&](std::string_view input, std::string_view words) { return race.Apply(input, words); });
    if (result) {
      ++replayed;
    } else {
      EXPECT_THAT(result.error().message, HasSubstr("damaged.record:"));
    }
  }
  EXPECT_GT(replayed, 0);
}

}  // namespace musher::race::recording_test
