// The files of musher-meilin-server: their defaults, and messages about errors.

#include "musher/modules/meilin/servers/server_config.hpp"

#include <gmock/gmock.h>

#include "musher/test/support/paths.hpp"

namespace musher::meilin::servers::server_config_test {

using ::testing::IsEmpty;

template <class Config>
Config FileOf(const std::string& name) {
  const auto reading = ReadServerFile(SourceDir() + "/config/meilin/" + name + ".toml");
  EXPECT_THAT(reading.diagnostics, IsEmpty());
  if (!reading.config) return {};
  const auto* config = std::get_if<Config>(&reading.config->server);
  EXPECT_NE(config, nullptr) << name;
  return config != nullptr ? *config : Config();
}

std::string ErrorIn(const std::string& text) {
  const auto reading = ReadServerText(text, "arm.toml");
  EXPECT_FALSE(reading.config);
  return reading.diagnostics.empty() ? "" : FormatDiagnostic(reading.diagnostics.front());
}

TEST(MoveFile, HasTheDefaultsButThoseThatItNames) {
  const auto file = FileOf<MoveConfig>("move_to_pose");
  const MoveConfig other;
  const MoveSettings &s = file.settings, &d = other.settings;
  EXPECT_EQ(s.period, d.period);
  EXPECT_EQ(s.pose_wait, d.pose_wait);
  EXPECT_EQ(s.pose_stale, d.pose_stale);
  EXPECT_EQ(s.yaw_limit, d.yaw_limit);
  EXPECT_EQ(s.xy_limit, Milliseconds(40'000)) << "with the time of a climb";
  EXPECT_EQ(s.brake_time, d.brake_time);
  EXPECT_EQ(s.yaw_tolerance_deg, d.yaw_tolerance_deg);
  EXPECT_EQ(s.xy_tolerance_m, d.xy_tolerance_m);
  EXPECT_EQ(s.max_m_s, d.max_m_s);
  EXPECT_EQ(s.min_m_s, d.min_m_s);
  EXPECT_EQ(s.climb_m_s, 0.3);
  EXPECT_EQ(s.brake_m_s2, 1.5);
  EXPECT_EQ(s.max_yaw_rad_s, d.max_yaw_rad_s);
  EXPECT_EQ(s.min_yaw_rad_s, d.min_yaw_rad_s);
  EXPECT_EQ(s.max_xy_yaw_rad_s, d.max_xy_yaw_rad_s);
  EXPECT_EQ(s.integral_limit, d.integral_limit);
  const auto same = [](const PidGains& a, const PidGains& b) {
    return a.p == b.p && a.i == b.i && a.d == b.d;
  };
  EXPECT_TRUE(same(s.yaw, d.yaw) && same(s.xy_yaw, d.xy_yaw));
  EXPECT_TRUE(same(s.x, d.x) && same(s.y, d.y));
  EXPECT_EQ(file.frame, other.frame);
  EXPECT_EQ(file.action, other.action);
  EXPECT_EQ(file.pose, other.pose);
  EXPECT_EQ(file.command, other.command);
  EXPECT_EQ(file.climb_state, other.climb_state);
}

TEST(SuspensionFile, HasTheDefaults) {
  const auto file = FileOf<SuspensionConfig>("suspension");
  const SuspensionConfig other;
  const SuspensionSettings &s = file.settings, &d = other.settings;
  EXPECT_EQ(s.rest_mm, d.rest_mm);
  EXPECT_EQ(s.low_mm, d.low_mm);
  EXPECT_EQ(s.high_mm, d.high_mm);
  EXPECT_EQ(s.low_step_mm, d.low_step_mm);
  EXPECT_EQ(s.highest_step_mm, d.highest_step_mm);
  EXPECT_EQ(s.highest_mm, d.highest_mm);
  EXPECT_EQ(s.tolerance_mm, d.tolerance_mm);
  EXPECT_EQ(s.time_limit, d.time_limit);
  EXPECT_EQ(s.stale, d.stale);
  EXPECT_EQ(file.wheel_order, other.wheel_order);
  EXPECT_EQ(file.switch_order, other.switch_order);
  EXPECT_EQ(file.action, other.action);
  EXPECT_EQ(file.command, other.command);
  EXPECT_EQ(file.chassis, other.chassis);
  EXPECT_EQ(file.distances, other.distances);
  EXPECT_EQ(file.state, other.state);
}

TEST(ToolFiles, HaveTheDefaults) {
  const auto same = [](const ToolConfig& file, const ToolConfig& other) {
    EXPECT_EQ(file.time_limit, other.time_limit);
    EXPECT_EQ(file.action, other.action);
    EXPECT_EQ(file.command, other.command);
    EXPECT_EQ(file.report, other.report);
    EXPECT_EQ(file.runtime_state, other.runtime_state);
  };
  same(FileOf<ArmConfig>("arm"), ArmConfig());
  same(FileOf<SpearConfig>("spear"), SpearConfig());
}

TEST(ServerFile, SaysWhereAnErrorIsAndWhatIsExpected) {
  const std::vector<std::pair<std::string, std::string>> errors = {
      {"",
       "arm.toml:1:1: error: the key \"server\" is missing; expected the server: \"move_to_pose\", "
       "\"suspension\", \"arm\" or \"spear\""},
      {"server = \"amr\"", "arm.toml:1:10: error: server: "},
      {"server = \"arm\"\nlimit_sec = 3",
       "arm.toml:2:1: error: unknown key \"limit_sec\"; did you mean \"limit_ms\"?"},
      {"server = \"arm\"\nlimit_ms = 0", "arm.toml:2:12: error: limit_ms: "},
      {"server = \"spear\"\nruntime_state = \"x\"", "arm.toml:2:1: error: unknown key"},
      {"server = \"arm\"\nreport = \"a b\"",
       "arm.toml:2:10: error: report: expected the name of a topic, as in \"r0x0203\", "
       "found \"a b\""},
      {"server = \"move_to_pose\"\nx_pid = [1, 2]",
       "arm.toml:2:9: error: x_pid: expected three numbers from 0 to 1000: [p, i, d]"},
      {"server = \"move_to_pose\"\nx_pid = [1, 2.5, -1]",
       "arm.toml:2:18: error: x_pid: expected three numbers from 0 to 1000: [p, i, d]"},
      {"server = \"move_to_pose\"\nx_pid = [1, nan, 1]", "arm.toml:2:13: error: x_pid: "},
      {"server = \"move_to_pose\"\nmin_m_s = 2",
       "arm.toml:2:11: error: min_m_s: greater than the greatest speed"},
      {"server = \"suspension\"\nwheel_order = [0, 1, 2, 2]",
       "arm.toml:2:15: error: wheel_order: expected each of 0, 1, 2 and 3 once"},
      {"server = \"suspension\"\nswitch_order = [0, 1, 2]",
       "arm.toml:2:16: error: switch_order: expected each of 0, 1, 2 and 3 once"},
      {"server = \"suspension\"\nhigh_mm = 500",
       "arm.toml:2:11: error: high_mm: no wheel reaches it, see highest_mm"},
      {"server = \"suspension\"\nlow_mm = 411",
       "arm.toml:2:10: error: low_mm: greater than high_mm"},
  };
  for (const auto& [text, error] : errors) {
    EXPECT_THAT(ErrorIn(text), ::testing::HasSubstr(error)) << text;
  }
}

}  // namespace musher::meilin::servers::server_config_test
