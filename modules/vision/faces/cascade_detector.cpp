#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/objdetect.hpp>
#include <utility>

#include "musher/modules/vision/faces/detector.hpp"
#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {
namespace {

cv::Mat GreyOf(const msg::Image& picture) {
  const int channels = picture.encoding == "mono8"                                ? 1
                       : picture.encoding == "rgb8" || picture.encoding == "bgr8" ? 3
                                                                                  : 4;
  // Read only.
  auto* data = const_cast<std::uint8_t*>(picture.data.data());
  cv::Mat all(static_cast<int>(picture.height), static_cast<int>(picture.width), CV_8UC(channels),
              data, picture.step);
  if (channels == 1) return all;
  const bool red_first = picture.encoding.starts_with('r');
  cv::Mat grey;
  cv::cvtColor(all, grey,
               channels == 3 ? (red_first ? cv::COLOR_RGB2GRAY : cv::COLOR_BGR2GRAY)
                             : (red_first ? cv::COLOR_RGBA2GRAY : cv::COLOR_BGRA2GRAY));
  return grey;
}

class CascadeDetector : public Detector {
 public:
  // OpenCV's objects are handles: a copy is the same cascade.
  CascadeDetector(CascadeConfig config, const cv::CascadeClassifier& cascade)
      : config_(std::move(config)), cascade_(cascade) {}

  std::vector<FaceBox> Detect(const msg::Image& picture) override {
    cv::Mat grey = GreyOf(picture);
    if (grey.cols > config_.width_px) {
      const double scale = static_cast<double>(config_.width_px) / grey.cols;
      const cv::Size size(config_.width_px, std::max(1, cvRound(grey.rows * scale)));
      cv::resize(grey, grey, size, 0, 0, cv::INTER_AREA);
    }
    const int least = cvRound(config_.smallest * std::max(grey.cols, grey.rows));
    std::vector<cv::Rect> found;
    std::vector<int> finds;
    cascade_.detectMultiScale(grey, found, finds, config_.step, config_.neighbours, 0,
                              {least, least});
    std::vector<FaceBox> faces;
    for (std::size_t i = 0; i < found.size(); ++i) {
      const double width = grey.cols;
      const double height = grey.rows;
      // 0.5 for the fewest detections that count, approaching 1 the more there are.
      const double confidence =
          1 - std::exp2(-static_cast<double>(finds[i]) / std::max(1, config_.neighbours));
      faces.push_back({found[i].x / width, found[i].y / height, found[i].width / width,
                       found[i].height / height, true, confidence});
    }
    return faces;
  }

 private:
  const CascadeConfig config_;
  cv::CascadeClassifier cascade_;
};

}  // namespace

std::string DefaultModel() {
  return MUSHER_FACE_MODEL;
}

Result<std::unique_ptr<Detector>> MakeCascadeDetector(const CascadeConfig& config) {
  const auto error = [&](const std::string& what) {
    return Error{VisionCode(KeyCode::kDeviceError), config.model + ": " + what};
  };
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(config.model, ignored)) {
    return error("there is no such model; Debian's opencv-data has some");
  }
  try {
    cv::setNumThreads(1);  // leave CPU to the robot's other programs
    cv::CascadeClassifier cascade;
    if (!cascade.load(config.model) || cascade.empty()) return error("this is no cascade");
    return std::unique_ptr<Detector>(new CascadeDetector(config, cascade));
  } catch (const std::exception& thrown) {
    const std::string why = thrown.what();
    return error("this is no cascade: " + why.substr(0, why.find('\n')));
  }
}

}  // namespace musher::vision
