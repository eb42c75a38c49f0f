// The file of the line walker: its defaults, and messages about errors in it.

#include "musher/modules/line_walker/walker_config.hpp"

#include <gmock/gmock.h>

#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::line_walker::walker_config_test {

using ::testing::IsEmpty;

TEST(WalkerConfig, OfTheShippedFileHasTheDefaultsButForTheCourse) {
  const auto reading = ReadWalkerFile(SourceDir() + "/config/line_walker/walker.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  WalkerConfig expected;
  expected.walk.approach_m = 1.2;
  expected.walk.cameras.left.region_top = expected.walk.cameras.right.region_top = 0.5;
  EXPECT_EQ(*reading.config, expected);
}

TEST(WalkerConfig, ReportsWhatIsWrongAndWhere) {
  musher::testing::ExpectDiagnostics(
      [](const std::string& text) { return ReadWalkerText(text, "walker.toml"); },
      {{"a misspelt key",
        "[walk]\nforward_ms = 0.3\n",
        {"walker.toml:2:1: error: walk: unknown key \"forward_ms\"; did you mean "
         "\"forward_m_s\"?"}},
       {"a topic that is no name",
        "[topics]\nleft = \"a b\"\n",
        {"walker.toml:2:8: error: topics.left: expected the name of a topic, as in "
         "\"odom_out\", found \"a b\""}},
       {"a gap beyond the end",
        "[end]\nend_gap_m = 2.0\n",
        {"walker.toml:2:13: error: end.end_gap_m: must be less than end_within_m"}},
       {"slow is faster than forward",
        "[walk]\nslow_m_s = 0.5\n",
        {"walker.toml:2:12: error: walk.slow_m_s: must not be more than forward_m_s"}},
       {"an angle of no pinhole",
        "[camera.front]\nhfov_deg = 175\n",
        {"walker.toml:2:12: error: camera.front.hfov_deg: a pinhole has less than 170 degrees"}}});
}

TEST(WalkerConfig, OfAMissingFileIsAnError) {
  const Parsed<WalkerConfig> reading = ReadWalkerFile("/nowhere/walker.toml");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 1U);
}

}  // namespace musher::line_walker::walker_config_test
