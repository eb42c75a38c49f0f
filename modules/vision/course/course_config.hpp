#pragma once
// The detectors of a course in the config of the vision module, each a table [[detectors]];
// README.md and config/vision/course.toml explain their keys.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/base/toml/document.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/modules/vision/course/course_detectors.hpp"
#include "musher/modules/vision/course/white_balance.hpp"
#include "musher/modules/vision/picture/detector_worker.hpp"

namespace musher::vision {

enum class CourseKind { kQr, kArrow, kBarrier, kMarker, kLight, kLines, kAruco, kNet };

using CourseDetectorMaker = std::function<Result<std::unique_ptr<CourseDetector>>()>;

// By the kind of the detector; a light has those of a marker.
using CourseParameters =
    std::variant<LinesParameters, ArrowParameters, BarrierParameters, MarkerParameters,
                 QrParameters, ArucoParameters, NetParameters>;

// How to make a detector with its parameters.
struct CourseFactory {
  CourseDetectorMaker make;
  std::function<Result<>()> check;  // whether it can work: what it needs is installed; may be slow
};

// The topics of one detector.
struct CourseOutputs {
  std::optional<std::string> text;      // std_msgs/String
  std::optional<std::string> sighting;  // musher_msgs/Sighting
  std::optional<std::string> doubt;     // std_msgs/String: why a picture has no sighting
  std::optional<std::string> lines;     // musher_msgs/YellowLines
  std::string debug_image;              // sensor_msgs/Image

  std::vector<std::string> All() const;
};

// The key of the colour in [hall] that detectors of that kind have, and of their own one: "yellow";
// empty: they have none.
std::string ColorKeyOf(CourseKind kind);

// The same of the region: "barrier". Of lines there is none, whose offsets are shares of it.
std::string RegionKeyOf(CourseKind kind);

struct CourseEntry {
  std::string name;
  CourseKind kind = CourseKind::kQr;
  std::string picture = "image_rgb";  // topics; relative ones are in the machine's namespace
  std::string camera_info;            // empty: camera_info below the picture's
  std::optional<double> hfov_rad;     // of the picture, where no CameraInfo comes
  double rate_hz = 10;                // pictures processed in a second of their own time; 0: all
  Duration still{};                   // as of the whole file
  std::string publish;                // the text, or of a detector of lines its lines
  DetectorLimits limits;
  CourseParameters parameters;
  std::optional<WhiteBalance> balance;  // of the hall
  bool own_color = false;               // not that of [hall], which its kind has
  bool own_region = false;              // the same
  CourseFactory factory;                // with them

  std::string CameraInfoTopic() const {
    return camera_info.empty() ? picture + "/camera_info" : camera_info;
  }
  CourseOutputs Outputs() const;
};

// The tables [[detectors]] of the file, with what [hall] and [[mounts]] say; `folder` is that of
// the file, and `taken` are topics that its other parts publish.
std::vector<CourseEntry> ReadCourseEntries(config_toml::TableReader& root,
                                           config_toml::Findings& findings,
                                           const std::filesystem::path& folder,
                                           const std::vector<std::string>& taken);

}  // namespace musher::vision
