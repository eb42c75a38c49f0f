#include "musher/modules/line_walker/walker_config.hpp"

#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::line_walker {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::string_view kTopic = "odom_out";

Rows TopicRows(TopicNames& topics) {
  return {
      row::Topic("left", topics.left, kTopic),
      row::Topic("right", topics.right, kTopic),
      row::Topic("front", topics.front, kTopic),
      row::Topic("command", topics.command, kTopic),
      row::Topic("status", topics.status, kTopic),
      row::Topic("odometry", topics.odometry, kTopic),
      row::Topic("servo", topics.servo, kTopic),
      row::Topic("servo_response", topics.servo_response, kTopic),
  };
}

Rows LaneRows(LaneRules& lane) {
  return {
      row::Number("width_m", lane.width_m, 0.2, 5),
      row::Number("left_gain", lane.left_gain, 0.01, 1),
      row::Number("right_gain", lane.right_gain, 0.01, 1),
      row::Number("curvature_share", lane.curvature_share, 0, 1),
      row::Number("jump_m", lane.jump_m, 0.01, 5),
      row::Degrees("jump_deg", lane.jump_rad, 1, 180),
      row::Integer("jumps", lane.jumps, 1, 100),
      row::Number("first_aside_m", lane.first_aside_m, 0.01, 5),
      row::Degrees("first_deg", lane.first_rad, 1, 180),
  };
}

Rows WalkingRows(WalkRules& walk, double& step_height_m) {
  SteeringRules& steering = walk.steering;
  return {
      row::Number("forward_m_s", steering.forward_m_s, 0.01, 2),
      row::Number("slow_m_s", steering.slow_m_s, 0.01, 2),
      row::Number("lost_m_s", walk.lost_m_s, 0.01, 2),
      row::Number("side_m_s", steering.side_m_s, 0, 1),
      row::Number("yaw_rad_s", steering.yaw_rad_s, 0.05, 3),
      row::Number("by_offset", steering.by_offset, 0, 50),
      row::Number("by_heading", steering.by_heading, 0, 50),
      row::Number("side_by_offset", steering.side_by_offset, 0, 10),
      row::Degrees("slow_from_deg", steering.slow_from_rad, 0, 90),
      row::Degrees("slow_to_deg", steering.slow_to_rad, 1, 180),
      row::Number("step_height_m", step_height_m, 0.01, 0.2),
      row::Number("adjust_m", walk.adjust_m, 0, 5),
      row::Degrees("adjust_deg", walk.adjust_rad, 0, 180),
      row::Number("approach_m", walk.approach_m, 0, 10),
      row::Time("lead_ms", walk.lead, 0),
      row::Time("picture_delay_ms", walk.picture_delay, 0),
      row::Check(
          "slow_to_deg", [&] { return steering.slow_to_rad > steering.slow_from_rad; },
          "must be more than slow_from_deg"),
      row::Check(
          "slow_m_s", [&] { return steering.slow_m_s <= steering.forward_m_s; },
          "must not be more than forward_m_s"),
  };
}

Rows EndRows(WalkRules& walk) {
  return {
      row::Number("end_within_m", walk.end.within_m, 0.1, 10),
      row::Number("end_gap_m", walk.end_gap_m, -5, 10),
      row::Integer("pictures", walk.end_pictures, 1, 100),
      row::Integer("side_pictures", walk.side_pictures, 1, 100),
      row::Number("side_within_m", walk.end.side_within_m, 0.05, 5),
      row::Number("side_gap_m", walk.end.side_gap_m, 0.05, 5),
      row::Number("jump_m", walk.end_jump_m, 0.01, 5),
      row::Number("least_span_m", walk.end.least_span_m, 0.05, 5),
      row::Number("longest_gap_m", walk.end.longest_gap_m, 0.01, 5),
      row::Degrees("squint_deg", walk.end.squint_rad, 1, 89),
      row::Integer("least_points", walk.end.least_points, 2, 1000),
      row::Check(
          "end_gap_m", [&] { return walk.end_gap_m < walk.end.within_m; },
          "must be less than end_within_m"),
  };
}

Rows LimitRows(WalkRules& walk) {
  return {
      row::Time("time_limit_ms", walk.time_limit), row::Time("start_ms", walk.start_wait),
      row::Time("stale_ms", walk.stale),           row::Time("fresh_ms", walk.fresh),
      row::Time("lost_ms", walk.lost, 0),          row::Time("refused_ms", walk.refused, 0),
  };
}

Rows LineRows(WalkRules& walk) {
  FitRules& fit = walk.fit;
  return {
      row::Number("tolerance_m", fit.tolerance_m, 0.001, 1),
      row::Number("nearest_m", fit.nearest_m, 0, 5),
      row::Number("farthest_m", fit.farthest_m, 0.1, 10),
      row::Number("back_m", fit.back_m, 0, 10),
      row::Number("ahead_m", fit.ahead_m, 0, 10),
      row::Number("least_span_m", fit.least_span_m, 0.01, 5),
      row::Number("tightest_m", fit.tightest_m, 0.1, 100),
      row::Degrees("steepest_deg", fit.steepest_rad, 1, 80),
      row::Integer("least_points", fit.least_points, 3, 60),
      row::Check(
          "farthest_m", [&] { return fit.farthest_m > fit.nearest_m; },
          "must be more than nearest_m"),
      [&](TableReader&) { walk.end.tolerance_m = walk.fit.tolerance_m; },
  };
}

Rows LaneCameraRows(MountedCamera& camera) {
  Rows rows = navigation::CameraRows(camera);
  rows.push_back(row::Number("region_top", camera.region_top, 0, 1));
  return rows;
}

WalkerConfig Read(TableReader& root) {
  WalkerConfig config;
  WalkRules& walk = config.walk;
  CameraSet& cameras = walk.cameras;
  ReadRows(
      root,
      {row::Time("self_check_ms", config.self_check_time),
       row::Sub("topics", TopicRows(config.topics)), row::Sub("lane", LaneRows(walk.lane)),
       row::Sub("walk", WalkingRows(walk, config.step_height_m)), row::Sub("end", EndRows(walk)),
       row::Sub("limits", LimitRows(walk)), row::Sub("line", LineRows(walk)),
       row::Sub("camera", {row::Number("trunk_height_m", cameras.trunk_height_m, 0.01, 2),
                           row::Number("farthest_m", cameras.farthest_m, 0.1, 20),
                           row::Sub("left", LaneCameraRows(cameras.left)),
                           row::Sub("right", LaneCameraRows(cameras.right)),
                           row::Sub("front", LaneCameraRows(cameras.front))})});
  return config;
}

}  // namespace

Parsed<WalkerConfig> ReadWalkerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<WalkerConfig>>(
      text, path, [](const Table& table, Findings& findings) {
        TableReader root(table, {1, 1}, "", findings);
        return Read(root);
      });
}

Parsed<WalkerConfig> ReadWalkerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadWalkerText);
}

}  // namespace musher::line_walker
