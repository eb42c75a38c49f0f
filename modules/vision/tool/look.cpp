#include "musher/modules/vision/tool/look.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "musher/modules/vision/picture/picture.hpp"

namespace musher::vision::tool {
namespace {

msg::Image MessageOf(const cv::Mat& mat) {
  msg::Image picture;
  picture.width = static_cast<std::uint32_t>(mat.cols);
  picture.height = static_cast<std::uint32_t>(mat.rows);
  picture.encoding = "bgr8";
  picture.step = picture.width * 3;
  picture.data.assign(mat.datastart, mat.dataend);
  return picture;
}

void Draw(const std::vector<FaceBox>& faces, cv::Mat& mat) {
  const cv::Scalar green(60, 200, 60);
  for (const FaceBox& face : faces) {
    const cv::Rect box(cvRound(face.x * mat.cols), cvRound(face.y * mat.rows),
                       cvRound(face.width * mat.cols), cvRound(face.height * mat.rows));
    cv::rectangle(mat, box, green, std::max(1, mat.cols / 320));
  }
}

class FaceSearch {
 public:
  FaceSearch(const VisionConfig& config, const LookOptions& options, Detector& detector,
             std::ostream& out)
      : config_(config), options_(options), detector_(detector), out_(out) {}

  Result<> LookAt(const std::string& file) {
    cv::Mat mat = cv::imread(file, cv::IMREAD_COLOR);
    if (mat.empty()) return Error{kCodeFailed, file + " is no picture that can be read"};
    const msg::Image picture = MessageOf(mat);
    if (Result<> valid = CheckPicture(picture); !valid) return valid;
    const auto begin = std::chrono::steady_clock::now();
    std::vector<FaceBox> faces = detector_.Detect(picture);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
    out_ << fmt::format("{}: {} x {}, {} face{} in {:.0f} ms\n", file, picture.width,
                        picture.height, faces.size(), faces.size() == 1 ? "" : "s", took.count());
    std::sort(faces.begin(), faces.end(),
              [](const FaceBox& a, const FaceBox& b) { return a.height > b.height; });
    for (const FaceBox& face : faces) Print(face, picture);
    if (options_.at_m && !faces.empty()) Calibrate(faces[0], picture);
    if (options_.out.empty()) return Ok();
    Draw(faces, mat);
    if (!cv::imwrite(options_.out, mat)) {
      return Error{kCodeFailed, options_.out + " cannot be written"};
    }
    return Ok();
  }

 private:
  std::optional<Lens> LensOf(const msg::Image& picture) const {
    std::optional<double> hfov_rad = config_.hfov_rad;
    if (options_.hfov_deg) hfov_rad = *options_.hfov_deg * M_PI / 180;
    if (!hfov_rad) return std::nullopt;
    return PinholeOf(*hfov_rad, picture.width, picture.height);
  }

  void Print(const FaceBox& face, const msg::Image& picture) const {
    out_ << fmt::format("  at {:.3f} {:.3f}, {:.3f} x {:.3f}, confidence {:.2f}", face.center_x(),
                        face.center_y(), face.width, face.height, face.confidence);
    if (const auto lens = LensOf(picture)) {
      out_ << fmt::format(", {:.2f} m away",
                          DistanceM(*lens, face, face.height, config_.faces.face_m));
    }
    const double smallest = config_.faces.tracker.smallest;
    out_ << (face.width < smallest || face.height < smallest ? ", too small to count\n" : "\n");
  }

  void Calibrate(const FaceBox& largest, const msg::Image& picture) const {
    const auto lens = LensOf(picture);
    if (!lens) return;
    const double unit_m = DistanceM(*lens, largest, largest.height, 1);
    out_ << fmt::format("  it is {:.2f} m away when face_m = {:.3f}\n", *options_.at_m,
                        *options_.at_m / unit_m);
  }

  const VisionConfig& config_;
  const LookOptions& options_;
  Detector& detector_;
  std::ostream& out_;
};

}  // namespace

Result<> Look(const VisionConfig& config, const LookOptions& options, std::ostream& out) {
  // Errors of a file are reported here, not by OpenCV.
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  auto detector = MakeCascadeDetector(config.cascade);
  if (!detector) return detector.error();
  FaceSearch search(config, options, *detector.value(), out);
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
