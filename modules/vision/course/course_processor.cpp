#include "musher/modules/vision/course/course_processor.hpp"

#include <chrono>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "musher/messages/stamp.hpp"

namespace musher::vision {
namespace {

struct Format {
  int channels;
  int to_bgr;  // of cv::cvtColor; -1: is bgr
};

Format FormatOf(const std::string& encoding) {
  if (encoding == "mono8") return {1, cv::COLOR_GRAY2BGR};
  if (encoding == "rgb8") return {3, cv::COLOR_RGB2BGR};
  if (encoding == "rgba8") return {4, cv::COLOR_RGBA2BGR};
  if (encoding == "bgra8") return {4, cv::COLOR_BGRA2BGR};
  return {3, -1};
}

}  // namespace

cv::Mat BgrOf(const msg::Image& picture) {
  const Format format = FormatOf(picture.encoding);
  // Read only.
  auto* data = const_cast<std::uint8_t*>(picture.data.data());
  const cv::Mat pixels(static_cast<int>(picture.height), static_cast<int>(picture.width),
                       CV_8UC(format.channels), data, picture.step);
  if (format.to_bgr < 0) return pixels.clone();
  cv::Mat bgr;
  cv::cvtColor(pixels, bgr, format.to_bgr);
  return bgr;
}

msg::Image MessageOf(const cv::Mat& bgr) {
  const cv::Mat whole = bgr.isContinuous() ? bgr : bgr.clone();
  msg::Image picture;
  picture.width = static_cast<std::uint32_t>(whole.cols);
  picture.height = static_cast<std::uint32_t>(whole.rows);
  picture.encoding = "bgr8";
  picture.step = picture.width * 3;
  picture.data.assign(whole.ptr(), whole.ptr() + whole.total() * whole.elemSize());
  return picture;
}

Result<std::unique_ptr<CourseProcessor>> CourseProcessor::Make(CourseDetectorMaker maker) {
  auto made = maker();
  if (!made) return made.error();
  return std::unique_ptr<CourseProcessor>(
      new CourseProcessor(std::move(maker), std::move(made).value()));
}

CourseFound CourseProcessor::Process(const CourseShot& shot) {
  if (run_ && *run_ != shot.run) {
    auto made = maker_();
    if (!made) throw std::runtime_error(made.error().message);
    detector_ = std::move(made).value();
  }
  run_ = shot.run;
  cv::Mat bgr = BgrOf(shot.picture);
  const msg::Header header = {msg::ToStamp(std::chrono::nanoseconds(shot.stamp_ns)),
                              shot.picture.header.frame_id};
  CourseFound found{detector_->Look(bgr, shot.stamp_ns, shot.lens), std::nullopt, shot.run};
  if (found.sight.sighting) found.sight.sighting->header = header;
  if (found.sight.lines) found.sight.lines->header = header;
  if (shot.draws) {
    detector_->Draw(bgr);
    found.drawing = MessageOf(bgr);
    found.drawing->header = header;
  }
  return found;
}

}  // namespace musher::vision
