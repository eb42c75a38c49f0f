#include "musher/modules/vision/vision_config.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::vision {
namespace {

using config_toml::Findings;
using config_toml::Table;
using config_toml::TableReader;

class Reader {
 public:
  explicit Reader(Findings& findings) : findings_(findings) {}

  VisionConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    config_.picture = Topic(root, "picture", config_.picture);
    config_.camera_info = Topic(root, "camera_info", config_.camera_info);
    config_.publish_under = Topic(root, "publish_under", config_.publish_under);
    if (const auto frame = root.String("frame_id")) config_.frame_id = frame->text;
    if (const auto degrees = root.Number("hfov_deg", 1, 170)) {
      config_.hfov_rad = *degrees * M_PI / 180;
    }
    if (const auto states = root.Strings("look_in")) {
      config_.look_in.clear();
      for (const auto& state : *states) config_.look_in.emplace_back(state.text);
    }
    config_.rate_hz = root.Number("rate_hz", 0, 1000).value_or(config_.rate_hz);
    config_.self_check_time = root.Time("self_check_ms").value_or(config_.self_check_time);
    config_.silence = root.Time("silence_ms").value_or(config_.silence);
    Sub(root, "detector", &Reader::ReadDetector);
    Sub(root, "faces", &Reader::ReadFaces);
    Sub(root, "target", &Reader::ReadTarget);
    Sub(root, "too_close", &Reader::ReadTooClose);
    config_.detect_faces = root.Bool("detect_faces").value_or(config_.detect_faces);
    config_.detectors = ReadCourseEntries(root, findings_, FaceTopicNames());
    root.RefuseOthers();
    CheckRate(root);
    CheckAny(root);
    config_.cascade.smallest = config_.faces.tracker.smallest;
    config_.faces.closeness.longest_gap = config_.silence;
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

  void ReadDetector(TableReader& reader) {
    CascadeConfig& cascade = config_.cascade;
    if (const auto model = reader.String("model")) cascade.model = model->text;
    cascade.width_px = Integer(reader, "width_px", 40, 4096, cascade.width_px);
    cascade.step = reader.Number("step", 1.01, 2).value_or(cascade.step);
    cascade.neighbours = Integer(reader, "neighbours", 1, 50, cascade.neighbours);
    config_.limits.hang = reader.Time("hang_ms").value_or(config_.limits.hang);
    config_.limits.failures = Integer(reader, "failures", 1, 1000, config_.limits.failures);
  }

  void ReadFaces(TableReader& reader) {
    TrackerRules& tracker = config_.faces.tracker;
    config_.faces.face_m = reader.Number("face_m", 0.01, 10).value_or(config_.faces.face_m);
    tracker.smallest = reader.Number("smallest", 0.001, 1).value_or(tracker.smallest);
    tracker.iou = reader.Number("iou", 0.01, 1).value_or(tracker.iou);
    tracker.distance = reader.Number("distance", 0, 1).value_or(tracker.distance);
    tracker.confirm_pictures =
        Integer(reader, "confirm_pictures", 1, 1000, tracker.confirm_pictures);
    tracker.confirm_within = reader.Time("confirm_within_ms").value_or(tracker.confirm_within);
    tracker.forget = reader.Time("forget_ms").value_or(tracker.forget);
    tracker.smoothing = reader.Time("smoothing_ms", 0).value_or(tracker.smoothing);
  }

  void ReadTarget(TableReader& reader) {
    TargetRules& target = config_.faces.target;
    target.lost = reader.Time("lost_ms").value_or(target.lost);
    target.nearer = reader.Number("nearer", 0, 0.99).value_or(target.nearer);
  }

  void ReadTooClose(TableReader& reader) {
    ClosenessRules& rules = config_.faces.closeness;
    rules.near_m = reader.Number("near_m", 0, 100).value_or(rules.near_m);
    rules.clear_m = reader.Number("clear_m", 0, 100).value_or(rules.clear_m);
    rules.hold = reader.Time("hold_ms", 0).value_or(rules.hold);
    if (rules.clear_m < rules.near_m) {
      reader.Fault(reader.At("clear_m"), "clear_m", "must not be less than near_m");
    }
  }

  std::vector<std::string> FaceTopicNames() const {
    if (!config_.detect_faces) return {};
    const std::string& under = config_.publish_under;
    return {under + "/target", under + "/too_close", under + "/faces_json"};
  }

  void CheckAny(TableReader& root) const {
    if (config_.detect_faces || root.Has("detectors")) return;
    root.Fault(root.At("detect_faces"), "detect_faces",
               "nothing is detected: expected true, or a table [[detectors]]");
  }

  void CheckRate(TableReader& root) const {
    if (!config_.detect_faces) return;
    const Duration forget = config_.faces.tracker.forget;
    const double longest_s = ToSeconds(forget);
    if (config_.rate_hz == 0 || config_.rate_hz * longest_s >= 1) return;
    root.Fault(root.At("rate_hz"), "rate_hz",
               "a face would be forgotten from one picture to the next: expected two within "
               "[faces] forget_ms, which are " +
                   std::to_string(ToMilliseconds(forget)) + " ms");
  }

  static int Integer(TableReader& reader, std::string_view key, int least, int most,
                     int otherwise) {
    const auto value = reader.Integer(key, least, most);
    return value ? static_cast<int>(*value) : otherwise;
  }

  std::string Topic(TableReader& reader, std::string_view key, const std::string& otherwise) {
    const auto topic = reader.String(key);
    if (!topic) return otherwise;
    if (!config_toml::IsTopic(topic->text)) {
      reader.Fault(topic->at, key, "expected the name of a topic, as in \"image_rgb\"");
    }
    return topic->text;
  }

  Findings& findings_;
  VisionConfig config_;
};

}  // namespace

bool VisionConfig::LooksIn(std::string_view state) const {
  return std::any_of(look_in.begin(), look_in.end(),
                     [&](const State& each) { return each == state; });
}

VisionReading ReadVisionText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<VisionReading>(
      text, path,
      [](const Table& root, Findings& findings) { return Reader(findings).Read(root); });
}

VisionReading ReadVisionFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadVisionText);
}

}  // namespace musher::vision
