#include "musher/modules/vision/vision_config.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"

namespace musher::vision {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::string_view kTopic = "image_rgb";

std::vector<std::string> FaceTopicNames(const VisionConfig& config) {
  if (!config.detect_faces) return {};
  const std::string& under = config.publish_under;
  return {under + "/target", under + "/too_close", under + "/faces_json"};
}

Rows DetectorRows(CascadeConfig& cascade, DetectorLimits& limits) {
  return {
      row::Text("model", cascade.model),
      row::Integer("width_px", cascade.width_px, 40, 4096),
      row::Number("step", cascade.step, 1.01, 2),
      row::Integer("neighbours", cascade.neighbours, 1, 50),
      row::Time("hang_ms", limits.hang),
      row::Integer("failures", limits.failures, 1, 1000),
  };
}

Rows FaceRows(FaceRules& faces) {
  TrackerRules& tracker = faces.tracker;
  return {
      row::Number("face_m", faces.face_m, 0.01, 10),
      row::Number("smallest", tracker.smallest, 0.001, 1),
      row::Number("iou", tracker.iou, 0.01, 1),
      row::Number("distance", tracker.distance, 0, 1),
      row::Integer("confirm_pictures", tracker.confirm_pictures, 1, 1000),
      row::Time("confirm_within_ms", tracker.confirm_within),
      row::Time("forget_ms", tracker.forget),
      row::Time("smoothing_ms", tracker.smoothing, 0),
  };
}

Rows ClosenessRows(ClosenessRules& rules) {
  return {
      row::Number("near_m", rules.near_m, 0, 100),
      row::Number("clear_m", rules.clear_m, 0, 100),
      row::Time("hold_ms", rules.hold, 0),
      row::Check(
          "clear_m", [&] { return rules.clear_m >= rules.near_m; }, "must not be less than near_m"),
  };
}

void ReadStates(TableReader& root, std::vector<State>& look_in) {
  const auto states = root.Strings("look_in");
  if (!states) return;
  look_in.clear();
  for (const auto& state : *states) look_in.emplace_back(state.text);
}

// A count was a time that depended on the camera's rate.
void RefuseStillPictures(TableReader& root) {
  constexpr std::string_view kKey = "still_pictures";
  if (!root.Has(kKey)) return;
  root.Fault(root.At(kKey), kKey,
             "is replaced by still_ms, the milliseconds in which a camera shows only old pictures: "
             "300, or 0 to check nothing");
}

void CheckAny(TableReader& root, const VisionConfig& config) {
  if (config.detect_faces || root.Has("detectors")) return;
  root.Fault(root.At("detect_faces"), "detect_faces",
             "nothing is detected: expected true, or a table [[detectors]]");
}

void CheckRate(TableReader& root, const VisionConfig& config) {
  if (!config.detect_faces) return;
  const Duration forget = config.faces.tracker.forget;
  const double longest_s = ToSeconds(forget);
  if (config.rate_hz == 0 || config.rate_hz * longest_s >= 1) return;
  root.Fault(root.At("rate_hz"), "rate_hz",
             "a face would be forgotten from one picture to the next: expected two within "
             "[faces] forget_ms, which are " +
                 std::to_string(ToMilliseconds(forget)) + " ms");
}

VisionConfig Read(const Table& table, const std::filesystem::path& folder, Findings& findings) {
  VisionConfig config;
  TargetRules& target = config.faces.target;
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(
      root,
      {row::Topic("picture", config.picture, kTopic),
       row::Topic("camera_info", config.camera_info, kTopic),
       row::Topic("publish_under", config.publish_under, kTopic),
       row::Text("frame_id", config.frame_id),
       [&](TableReader& reader) {
         if (const auto degrees = reader.Number("hfov_deg", 1, 170)) {
           config.hfov_rad = *degrees * M_PI / 180;
         }
       },
       [&](TableReader& reader) { ReadStates(reader, config.look_in); },
       row::Number("rate_hz", config.rate_hz, 0, 1000),
       row::Time("self_check_ms", config.self_check_time), row::Time("silence_ms", config.silence),
       row::Time("still_ms", config.still, 0), RefuseStillPictures,
       row::Sub("detector", DetectorRows(config.cascade, config.limits)),
       row::Sub("faces", FaceRows(config.faces)),
       row::Sub("target",
                {row::Time("lost_ms", target.lost), row::Number("nearer", target.nearer, 0, 0.99)}),
       row::Sub("too_close", ClosenessRows(config.faces.closeness)),
       row::Bool("detect_faces", config.detect_faces),
       [&](TableReader& reader) {
         config.detectors = ReadCourseEntries(reader, findings, folder, FaceTopicNames(config));
       }});
  for (CourseEntry& entry : config.detectors) entry.still = config.still;
  CheckRate(root, config);
  CheckAny(root, config);
  config.cascade.smallest = config.faces.tracker.smallest;
  config.faces.closeness.longest_gap = config.silence;
  return config;
}

}  // namespace

bool VisionConfig::LooksIn(std::string_view state) const {
  return std::any_of(look_in.begin(), look_in.end(),
                     [&](const State& each) { return each == state; });
}

Parsed<VisionConfig> ReadVisionText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<VisionConfig>>(
      text, path, [folder = config_toml::FolderOf(path)](const Table& table, Findings& findings) {
        return Read(table, folder, findings);
      });
}

Parsed<VisionConfig> ReadVisionFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadVisionText);
}

}  // namespace musher::vision
