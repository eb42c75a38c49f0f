// The file of the line walker: its defaults, and messages about errors in it.

#include "musher/modules/line_walker/walker_config.hpp"

#include <gmock/gmock.h>

#include "musher/test/support/paths.hpp"

namespace musher::line_walker::walker_config_test {

using ::testing::IsEmpty;

std::string ErrorOf(const std::string& text) {
  const WalkerReading reading = ReadWalkerText(text, "walker.toml");
  EXPECT_FALSE(reading.config);
  return reading.diagnostics.empty() ? "" : FormatDiagnostic(reading.diagnostics.front());
}

void ExpectSame(const MountedCamera& a, const MountedCamera& b) {
  EXPECT_EQ(a.fisheye, b.fisheye);
  EXPECT_EQ(a.x_m, b.x_m);
  EXPECT_EQ(a.y_m, b.y_m);
  EXPECT_EQ(a.z_m, b.z_m);
  EXPECT_NEAR(a.yaw_rad, b.yaw_rad, 1e-12);
  EXPECT_NEAR(a.pitch_rad, b.pitch_rad, 1e-12);
  EXPECT_EQ(a.roll_rad, b.roll_rad);
  EXPECT_EQ(a.width_px, b.width_px);
  EXPECT_EQ(a.height_px, b.height_px);
  EXPECT_NEAR(a.hfov_rad, b.hfov_rad, 1e-12);
}

TEST(WalkerConfig, OfTheShippedFileHasTheDefaults) {
  const auto reading = ReadWalkerFile(SourceDir() + "/config/line_walker/walker.toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  ASSERT_TRUE(reading.config);
  const WalkerConfig& file = *reading.config;
  const WalkerConfig defaults;
  EXPECT_EQ(file.topics.left, defaults.topics.left);
  EXPECT_EQ(file.topics.servo_response, defaults.topics.servo_response);
  EXPECT_EQ(file.self_check_time, defaults.self_check_time);
  EXPECT_EQ(file.step_height_m, defaults.step_height_m);
  const WalkRules& a = file.walk;
  const WalkRules& b = defaults.walk;
  EXPECT_EQ(a.lane.width_m, b.lane.width_m);
  EXPECT_EQ(a.lane.left_gain, b.lane.left_gain);
  EXPECT_EQ(a.lane.right_gain, b.lane.right_gain);
  EXPECT_EQ(a.lane.curvature_share, b.lane.curvature_share);
  EXPECT_NEAR(a.lane.jump_rad, b.lane.jump_rad, 1e-12);
  EXPECT_EQ(a.lane.jumps, b.lane.jumps);
  EXPECT_EQ(a.lane.first_aside_m, b.lane.first_aside_m);
  EXPECT_NEAR(a.lane.first_rad, b.lane.first_rad, 1e-12);
  EXPECT_EQ(a.steering.forward_m_s, b.steering.forward_m_s);
  EXPECT_EQ(a.steering.slow_m_s, b.steering.slow_m_s);
  EXPECT_EQ(a.steering.side_m_s, b.steering.side_m_s);
  EXPECT_EQ(a.steering.yaw_rad_s, b.steering.yaw_rad_s);
  EXPECT_EQ(a.steering.by_offset, b.steering.by_offset);
  EXPECT_EQ(a.steering.by_heading, b.steering.by_heading);
  EXPECT_EQ(a.steering.side_by_offset, b.steering.side_by_offset);
  EXPECT_NEAR(a.steering.slow_from_rad, b.steering.slow_from_rad, 1e-12);
  EXPECT_NEAR(a.steering.slow_to_rad, b.steering.slow_to_rad, 1e-12);
  EXPECT_EQ(a.lost_m_s, b.lost_m_s);
  EXPECT_EQ(a.adjust_m, b.adjust_m);
  EXPECT_NEAR(a.adjust_rad, b.adjust_rad, 1e-12);
  EXPECT_EQ(b.approach_m, 0);  // the file has its own, for the course
  EXPECT_EQ(a.lead, b.lead);
  EXPECT_EQ(a.picture_delay, b.picture_delay);
  EXPECT_EQ(a.end.within_m, b.end.within_m);
  EXPECT_EQ(a.end_gap_m, b.end_gap_m);
  EXPECT_EQ(a.end_pictures, b.end_pictures);
  EXPECT_EQ(a.end_jump_m, b.end_jump_m);
  EXPECT_EQ(a.side_pictures, b.side_pictures);
  EXPECT_EQ(a.end.side_within_m, b.end.side_within_m);
  EXPECT_EQ(a.end.side_gap_m, b.end.side_gap_m);
  EXPECT_EQ(a.end.least_span_m, b.end.least_span_m);
  EXPECT_EQ(a.end.longest_gap_m, b.end.longest_gap_m);
  EXPECT_NEAR(a.end.squint_rad, b.end.squint_rad, 1e-12);
  EXPECT_EQ(a.end.least_points, b.end.least_points);
  EXPECT_EQ(a.end.tolerance_m, b.end.tolerance_m);
  EXPECT_EQ(a.time_limit, b.time_limit);
  EXPECT_EQ(a.start_wait, b.start_wait);
  EXPECT_EQ(a.stale, b.stale);
  EXPECT_EQ(a.fresh, b.fresh);
  EXPECT_EQ(a.lost, b.lost);
  EXPECT_EQ(a.refused, b.refused);
  EXPECT_EQ(a.fit.tolerance_m, b.fit.tolerance_m);
  EXPECT_EQ(a.fit.nearest_m, b.fit.nearest_m);
  EXPECT_EQ(a.fit.farthest_m, b.fit.farthest_m);
  EXPECT_EQ(a.fit.back_m, b.fit.back_m);
  EXPECT_EQ(a.fit.ahead_m, b.fit.ahead_m);
  EXPECT_EQ(a.fit.least_span_m, b.fit.least_span_m);
  EXPECT_EQ(a.fit.least_points, b.fit.least_points);
  EXPECT_EQ(a.fit.tightest_m, b.fit.tightest_m);
  EXPECT_NEAR(a.fit.steepest_rad, b.fit.steepest_rad, 1e-12);
  EXPECT_EQ(a.cameras.trunk_height_m, b.cameras.trunk_height_m);
  EXPECT_EQ(a.cameras.farthest_m, b.cameras.farthest_m);
  ExpectSame(a.cameras.left, b.cameras.left);
  ExpectSame(a.cameras.right, b.cameras.right);
  ExpectSame(a.cameras.front, b.cameras.front);
}

TEST(WalkerConfig, ReportsErrorsAtTheirPlace) {
  EXPECT_EQ(ErrorOf("[walk]\nforward_ms = 0.3\n"),
            "walker.toml:2:1: error: walk: unknown key \"forward_ms\"; did you mean "
            "\"forward_m_s\"?");
  EXPECT_EQ(ErrorOf("[topics]\nleft = \"a b\"\n"),
            "walker.toml:2:8: error: topics.left: expected the name of a topic, as in "
            "\"odom_out\"");
  EXPECT_EQ(ErrorOf("[end]\nend_gap_m = 2.0\n"),
            "walker.toml:2:13: error: end.end_gap_m: must be less than end_within_m");
  EXPECT_EQ(ErrorOf("[walk]\nslow_m_s = 0.5\n"),
            "walker.toml:2:12: error: walk.slow_m_s: must not be more than forward_m_s");
  EXPECT_EQ(ErrorOf("[camera.front]\nhfov_deg = 175\n"),
            "walker.toml:2:12: error: camera.front.hfov_deg: a pinhole has less than 170 degrees");
}

TEST(WalkerConfig, OfAMissingFileIsAnError) {
  const WalkerReading reading = ReadWalkerFile("/nowhere/walker.toml");
  EXPECT_FALSE(reading.config);
  ASSERT_EQ(reading.diagnostics.size(), 1U);
}

}  // namespace musher::line_walker::walker_config_test
