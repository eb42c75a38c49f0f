#include "musher/modules/vision/tool/look_course.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "musher/base/suggest.hpp"

namespace musher::vision::tool {
namespace {

constexpr std::int64_t kPictureNs = 100'000'000;  // between two pictures of a film without times

bool IsFilm(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".mp4" || extension == ".avi" || extension == ".mkv";
}

std::string Metres(float distance_m) {
  return std::isfinite(distance_m) ? fmt::format("{:.2f} m", distance_m) : "distance unknown";
}

std::string Offset(float offset) {
  return std::isfinite(offset) ? fmt::format("{:.3f}", offset) : "unknown";
}

std::string LinesText(const msg::YellowLines& lines) {
  const std::string known =
      lines.uncertainty_m > 0
          ? fmt::format(" ({:.2f} m, known to {:.2f} m)", lines.middle_m, lines.uncertainty_m)
          : "";
  return fmt::format(
      "  {} line{}: ycy {}, dy {}, walk {}; middle_offset {}{}, line_offset {}, bottom_gap_px {}, "
      "area_px2 {:.0f}\n{}",
      lines.contours, lines.contours == 1 ? "" : "s", lines.ycy, lines.dy, lines.walk,
      Offset(lines.middle_offset), known, Offset(lines.line_offset), Offset(lines.bottom_gap_px),
      lines.area_px2, lines.doubt.empty() ? "" : "  in doubt: " + lines.doubt + "\n");
}

std::string SightingText(const msg::Sighting& sighting) {
  std::string text = sighting.seen ? "  seen" : "  not seen";
  if (!sighting.text.empty()) text += ", \"" + sighting.text + "\"";
  if (!sighting.phase.empty()) text += ", " + sighting.phase;
  if (!sighting.seen) return text + "\n";
  text += fmt::format(", {}, at {:.3f} {:.3f}, {:.3f} x {:.3f}", Metres(sighting.distance_m),
                      sighting.x + sighting.width / 2, sighting.y + sighting.height / 2,
                      sighting.width, sighting.height);
  if (sighting.confidence > 0) text += fmt::format(", confidence {:.2f}", sighting.confidence);
  return text + "\n";
}

class CourseSearch {
 public:
  CourseSearch(const CourseEntry& entry, const LookOptions& options, std::ostream& out)
      : entry_(entry), options_(options), out_(out) {}

  Result<> LookAt(const std::string& file) {
    auto detector = entry_.factory.make();
    if (!detector) return detector.error();
    if (IsFilm(file)) return LookAtFilm(file, *detector.value());
    cv::Mat mat = cv::imread(file, cv::IMREAD_COLOR);
    if (mat.empty()) return Error{kCodeFailed, file + " is no picture that can be read"};
    LookAtPicture(file, mat, kPictureNs, *detector.value());
    return Save(mat, *detector.value());
  }

 private:
  Result<> LookAtFilm(const std::string& file, CourseDetector& detector) {
    // Named: without a backend OpenCV also asks every USB device whether it is a camera.
    cv::VideoCapture film(file, cv::CAP_FFMPEG);
    cv::Mat last;
    cv::Mat mat;
    std::int64_t stamp_ns = -1;
    while (film.read(mat)) {
      const auto at_ns = static_cast<std::int64_t>(film.get(cv::CAP_PROP_POS_MSEC) * 1e6);
      stamp_ns = at_ns > stamp_ns ? at_ns : stamp_ns + kPictureNs;
      LookAtPicture(fmt::format("{} at {:.2f} s", file, static_cast<double>(stamp_ns) / 1e9), mat,
                    stamp_ns, detector);
      last = mat.clone();
    }
    if (last.empty()) return Error{kCodeFailed, file + " is no film that can be read"};
    return Save(last, detector);
  }

  void LookAtPicture(const std::string& title, const cv::Mat& mat, std::int64_t stamp_ns,
                     CourseDetector& detector) {
    const auto begin = std::chrono::steady_clock::now();
    const CourseSight sight = detector.Look(mat, stamp_ns, LensOf(mat));
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    out_ << fmt::format("{}: {} x {}, {:.0f} ms\n", title, mat.cols, mat.rows, took.count())
         << SightText(sight);
  }

  std::optional<Lens> LensOf(const cv::Mat& mat) const {
    std::optional<double> hfov_rad = entry_.hfov_rad;
    if (options_.hfov_deg) hfov_rad = *options_.hfov_deg * M_PI / 180;
    if (!hfov_rad) return std::nullopt;
    return PinholeOf(*hfov_rad, static_cast<std::uint32_t>(mat.cols),
                     static_cast<std::uint32_t>(mat.rows));
  }

  Result<> Save(cv::Mat& mat, const CourseDetector& detector) const {
    if (options_.out.empty()) return Ok();
    detector.Draw(mat);
    if (cv::imwrite(options_.out, mat)) return Ok();
    return Error{kCodeFailed, options_.out + " cannot be written"};
  }

  const CourseEntry& entry_;
  const LookOptions& options_;
  std::ostream& out_;
};

}  // namespace

Result<CourseEntry> DetectorOf(const VisionConfig& config, const std::string& name) {
  std::vector<std::string> names;
  for (const CourseEntry& entry : config.detectors) {
    if (entry.name == name) return entry;
    names.push_back(entry.name);
  }
  if (names.empty()) return Error{kCodeFailed, "the config has no table [[detectors]]"};
  return Error{kCodeFailed, NoSuch("detector", name, names)};
}

std::string SightText(const CourseSight& sight) {
  std::string text;
  if (sight.sighting) text += SightingText(*sight.sighting);
  if (sight.lines) text += LinesText(*sight.lines);
  if (!sight.doubt.empty()) text += "  in doubt: " + sight.doubt + "\n";
  if (sight.text) text += "  publishes \"" + *sight.text + "\"\n";
  return text;
}

Result<> LookAtCourse(const CourseEntry& entry, const LookOptions& options, std::ostream& out) {
  // Errors of a file are reported here, not by OpenCV.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  if (Result<> able = entry.factory.check(); !able) return able;
  CourseSearch search(entry, options, out);
  for (const std::string& file : options.pictures) {
    try {
      if (Result<> looked = search.LookAt(file); !looked) return looked;
    } catch (const std::exception& thrown) {
      const std::string why = thrown.what();
      return Error{kCodeFailed, file + ": " + why.substr(0, why.find('\n'))};
    }
  }
  return Ok();
}

}  // namespace musher::vision::tool
