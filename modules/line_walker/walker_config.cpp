#include "musher/modules/line_walker/walker_config.hpp"

#include <cmath>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::line_walker {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

void SetNumber(TableReader& reader, std::string_view key, double least, double most,
               double& value) {
  value = reader.Number(key, least, most).value_or(value);
}

void SetDegrees(TableReader& reader, std::string_view key, double least, double most,
                double& value_rad) {
  if (const auto degrees = reader.Number(key, least, most)) value_rad = *degrees * kDegree;
}

void SetInteger(TableReader& reader, std::string_view key, int least, int most, int& value) {
  if (const auto read = reader.Integer(key, least, most)) value = static_cast<int>(*read);
}

void SetTime(TableReader& reader, std::string_view key, Duration& value,
             std::int64_t least_ms = 1) {
  value = reader.Time(key, least_ms).value_or(value);
}

void SetTopic(TableReader& reader, std::string_view key, std::string& value) {
  const auto topic = reader.String(key);
  if (!topic) return;
  if (!config_toml::IsTopic(topic->text)) {
    reader.Fault(topic->at, key, "expected the name of a topic, as in \"odom_out\"");
  }
  value = topic->text;
}

class Reader {
 public:
  explicit Reader(Findings& findings) : findings_(findings) {}

  WalkerConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    SetTime(root, "self_check_ms", config_.self_check_time);
    Sub(root, "topics", &Reader::ReadTopics);
    Sub(root, "lane", &Reader::ReadLane);
    Sub(root, "walk", &Reader::ReadWalk);
    Sub(root, "end", &Reader::ReadEnd);
    Sub(root, "limits", &Reader::ReadLimits);
    Sub(root, "line", &Reader::ReadLine);
    Sub(root, "camera", &Reader::ReadCameras);
    root.RefuseOthers();
    return std::move(config_);
  }

 private:
  void Sub(TableReader& root, std::string_view name, void (Reader::*read)(TableReader&)) {
    const Table* table = root.SubTable(name);
    if (table == nullptr) return;
    TableReader reader(*table, root.At(name), std::string(name), findings_);
    (this->*read)(reader);
    reader.RefuseOthers();
  }

  void ReadTopics(TableReader& reader) {
    TopicNames& topics = config_.topics;
    SetTopic(reader, "left", topics.left);
    SetTopic(reader, "right", topics.right);
    SetTopic(reader, "front", topics.front);
    SetTopic(reader, "command", topics.command);
    SetTopic(reader, "status", topics.status);
    SetTopic(reader, "odometry", topics.odometry);
    SetTopic(reader, "servo", topics.servo);
    SetTopic(reader, "servo_response", topics.servo_response);
  }

  void ReadLane(TableReader& reader) {
    LaneRules& lane = config_.walk.lane;
    SetNumber(reader, "width_m", 0.2, 5, lane.width_m);
    SetNumber(reader, "left_gain", 0.01, 1, lane.left_gain);
    SetNumber(reader, "right_gain", 0.01, 1, lane.right_gain);
    SetNumber(reader, "curvature_share", 0, 1, lane.curvature_share);
    SetNumber(reader, "jump_m", 0.01, 5, lane.jump_m);
    SetDegrees(reader, "jump_deg", 1, 180, lane.jump_rad);
    SetInteger(reader, "jumps", 1, 100, lane.jumps);
    SetNumber(reader, "first_aside_m", 0.01, 5, lane.first_aside_m);
    SetDegrees(reader, "first_deg", 1, 180, lane.first_rad);
  }

  void ReadWalk(TableReader& reader) {
    WalkRules& walk = config_.walk;
    SteeringRules& steering = walk.steering;
    SetNumber(reader, "forward_m_s", 0.01, 2, steering.forward_m_s);
    SetNumber(reader, "slow_m_s", 0.01, 2, steering.slow_m_s);
    SetNumber(reader, "lost_m_s", 0.01, 2, walk.lost_m_s);
    SetNumber(reader, "side_m_s", 0, 1, steering.side_m_s);
    SetNumber(reader, "yaw_rad_s", 0.05, 3, steering.yaw_rad_s);
    SetNumber(reader, "by_offset", 0, 50, steering.by_offset);
    SetNumber(reader, "by_heading", 0, 50, steering.by_heading);
    SetNumber(reader, "side_by_offset", 0, 10, steering.side_by_offset);
    SetDegrees(reader, "slow_from_deg", 0, 90, steering.slow_from_rad);
    SetDegrees(reader, "slow_to_deg", 1, 180, steering.slow_to_rad);
    SetNumber(reader, "step_height_m", 0.01, 0.2, config_.step_height_m);
    SetNumber(reader, "adjust_m", 0, 5, walk.adjust_m);
    SetDegrees(reader, "adjust_deg", 0, 180, walk.adjust_rad);
    SetNumber(reader, "approach_m", 0, 10, walk.approach_m);
    SetTime(reader, "lead_ms", walk.lead, 0);
    SetTime(reader, "picture_delay_ms", walk.picture_delay, 0);
    if (steering.slow_to_rad <= steering.slow_from_rad) {
      reader.Fault(reader.At("slow_to_deg"), "slow_to_deg", "must be more than slow_from_deg");
    }
    if (steering.slow_m_s > steering.forward_m_s) {
      reader.Fault(reader.At("slow_m_s"), "slow_m_s", "must not be more than forward_m_s");
    }
  }

  void ReadEnd(TableReader& reader) {
    WalkRules& walk = config_.walk;
    SetNumber(reader, "end_within_m", 0.1, 10, walk.end.within_m);
    SetNumber(reader, "end_gap_m", -5, 10, walk.end_gap_m);
    SetInteger(reader, "pictures", 1, 100, walk.end_pictures);
    SetInteger(reader, "side_pictures", 1, 100, walk.side_pictures);
    SetNumber(reader, "side_within_m", 0.05, 5, walk.end.side_within_m);
    SetNumber(reader, "side_gap_m", 0.05, 5, walk.end.side_gap_m);
    SetNumber(reader, "jump_m", 0.01, 5, walk.end_jump_m);
    SetNumber(reader, "least_span_m", 0.05, 5, walk.end.least_span_m);
    SetNumber(reader, "longest_gap_m", 0.01, 5, walk.end.longest_gap_m);
    SetDegrees(reader, "squint_deg", 1, 89, walk.end.squint_rad);
    SetInteger(reader, "least_points", 2, 1000, walk.end.least_points);
    if (walk.end_gap_m >= walk.end.within_m) {
      reader.Fault(reader.At("end_gap_m"), "end_gap_m", "must be less than end_within_m");
    }
  }

  void ReadLimits(TableReader& reader) {
    WalkRules& walk = config_.walk;
    SetTime(reader, "time_limit_ms", walk.time_limit);
    SetTime(reader, "start_ms", walk.start_wait);
    SetTime(reader, "stale_ms", walk.stale);
    SetTime(reader, "fresh_ms", walk.fresh);
    SetTime(reader, "lost_ms", walk.lost, 0);
    SetTime(reader, "refused_ms", walk.refused, 0);
  }

  void ReadLine(TableReader& reader) {
    FitRules& fit = config_.walk.fit;
    SetNumber(reader, "tolerance_m", 0.001, 1, fit.tolerance_m);
    SetNumber(reader, "nearest_m", 0, 5, fit.nearest_m);
    SetNumber(reader, "farthest_m", 0.1, 10, fit.farthest_m);
    SetNumber(reader, "back_m", 0, 10, fit.back_m);
    SetNumber(reader, "ahead_m", 0, 10, fit.ahead_m);
    SetNumber(reader, "least_span_m", 0.01, 5, fit.least_span_m);
    SetNumber(reader, "tightest_m", 0.1, 100, fit.tightest_m);
    SetDegrees(reader, "steepest_deg", 1, 80, fit.steepest_rad);
    SetInteger(reader, "least_points", 3, 60, fit.least_points);
    config_.walk.end.tolerance_m = fit.tolerance_m;
    if (fit.farthest_m <= fit.nearest_m) {
      reader.Fault(reader.At("farthest_m"), "farthest_m", "must be more than nearest_m");
    }
  }

  void ReadCameras(TableReader& reader) {
    CameraSet& cameras = config_.walk.cameras;
    SetNumber(reader, "trunk_height_m", 0.01, 2, cameras.trunk_height_m);
    SetNumber(reader, "farthest_m", 0.1, 20, cameras.farthest_m);
    ReadCamera(reader, "left", cameras.left);
    ReadCamera(reader, "right", cameras.right);
    ReadCamera(reader, "front", cameras.front);
  }

  void ReadCamera(TableReader& cameras, std::string_view name, MountedCamera& camera) {
    const Table* table = cameras.SubTable(name);
    if (table == nullptr) return;
    TableReader reader(*table, cameras.At(name), "camera." + std::string(name), findings_);
    if (const auto fisheye =
            reader.Choice<bool>("model", {{"pinhole", false}, {"fisheye", true}})) {
      camera.fisheye = *fisheye;
    }
    SetNumber(reader, "x_m", -2, 2, camera.x_m);
    SetNumber(reader, "y_m", -2, 2, camera.y_m);
    SetNumber(reader, "z_m", -2, 2, camera.z_m);
    SetDegrees(reader, "yaw_deg", -360, 360, camera.yaw_rad);
    SetDegrees(reader, "pitch_deg", -90, 90, camera.pitch_rad);
    SetDegrees(reader, "roll_deg", -180, 180, camera.roll_rad);
    SetInteger(reader, "width_px", 8, 8192, camera.width_px);
    SetInteger(reader, "height_px", 8, 8192, camera.height_px);
    SetNumber(reader, "region_top", 0, 1, camera.region_top);
    SetDegrees(reader, "hfov_deg", 1, 220, camera.hfov_rad);
    if (!camera.fisheye && camera.hfov_rad >= 170 * kDegree) {
      reader.Fault(reader.At("hfov_deg"), "hfov_deg", "a pinhole has less than 170 degrees");
    }
    reader.RefuseOthers();
  }

  Findings& findings_;
  WalkerConfig config_;
};

}  // namespace

WalkerReading ReadWalkerText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<WalkerReading>(
      text, path,
      [](const Table& root, Findings& findings) { return Reader(findings).Read(root); });
}

WalkerReading ReadWalkerFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadWalkerText);
}

}  // namespace musher::line_walker
