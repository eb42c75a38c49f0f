#pragma once
// From a picture message to what is published of it: converts the picture, runs the detector of a
// course, draws. Pure.
//
// Threads: one call at a time.

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/vision/course/course_config.hpp"
#include "musher/modules/vision/course/course_detector.hpp"
#include "musher/modules/vision/picture/lens.hpp"
#include "musher/modules/vision/picture/picture.hpp"

namespace musher::vision {

struct CourseShot : Shot {
  std::optional<Lens> lens;
  bool draws = false;     // a debug image is subscribed to
  std::uint32_t run = 0;  // another than that of the last picture: the detector starts again
};

struct CourseFound {
  CourseSight sight;                  // with the picture's header
  std::optional<msg::Image> drawing;  // bgr8, with the picture's header
  std::uint32_t run = 0;              // of the picture
};

// The pixels of a picture that passed CheckPicture(), as CV_8UC3. Owns its pixels.
cv::Mat BgrOf(const msg::Image& picture);

// The same backwards, without a header.
msg::Image MessageOf(const cv::Mat& bgr);

class CourseProcessor {
 public:
  using Input = CourseShot;  // see detector_worker.hpp
  using Found = CourseFound;

  // Makes the first detector. Fails with the maker's error.
  static Result<std::unique_ptr<CourseProcessor>> Make(CourseDetectorMaker maker);

  // Throws what the detector throws.
  CourseFound Process(const CourseShot& shot);

 private:
  CourseProcessor(CourseDetectorMaker maker, std::unique_ptr<CourseDetector> detector)
      : maker_(std::move(maker)), detector_(std::move(detector)) {}

  const CourseDetectorMaker maker_;
  std::unique_ptr<CourseDetector> detector_;
  std::optional<std::uint32_t> run_;  // of the last picture
};

}  // namespace musher::vision
