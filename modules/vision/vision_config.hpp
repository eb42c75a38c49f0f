#pragma once
// The config of the vision module, a TOML file; README.md and config/vision/faces.toml and
// config/vision/course.toml explain its keys.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/faces/face_watch.hpp"
#include "musher/modules/vision/picture/detector_worker.hpp"

namespace musher::vision {

struct VisionConfig {
  std::string picture = "image_rgb";  // topics; relative ones are in the machine's namespace
  std::string camera_info;            // empty: camera_info below the picture's
  std::string publish_under = "wedding/perception";
  std::string frame_id = "camera";  // of the target's header
  std::optional<double> hfov_rad;   // of the picture, where no CameraInfo comes
  std::vector<State> look_in = {"Active"};
  double rate_hz = 10;  // pictures looked at in a second of their own time; 0: all
  Duration self_check_time = Milliseconds(5000);
  Duration silence = Milliseconds(2000);  // timeout without a processed picture
  Duration still = Milliseconds(300);     // old pictures for so long: it stands still; 0: off
  CascadeConfig cascade;
  DetectorLimits limits;
  FaceRules faces;
  bool detect_faces = true;
  std::vector<CourseEntry> detectors;  // of a course

  VisionConfig() { cascade.model = DefaultModel(); }
  std::string CameraInfoTopic() const {
    return camera_info.empty() ? picture + "/camera_info" : camera_info;
  }
  bool LooksIn(std::string_view state) const;
};

// Never throws; an unreadable file is a diagnostic.
Parsed<VisionConfig> ReadVisionFile(const std::string& path);

// The same for a text; `path` is what diagnostics refer to.
Parsed<VisionConfig> ReadVisionText(std::string_view text, const std::string& path);

}  // namespace musher::vision
