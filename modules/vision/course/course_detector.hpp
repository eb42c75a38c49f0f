#pragma once
// A detector of what stands, hangs or is painted on a course: from one picture to what is
// published. Each kind is a pure function of a picture and its parameters, see the header of its
// name; a CourseDetector adds what lasts from picture to picture, for example repeated sightings.
//
// Threads: one call at a time.

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "musher/messages/musher_msgs/sighting.hpp"
#include "musher/messages/musher_msgs/yellow_lines.hpp"
#include "musher/modules/vision/picture/lens.hpp"

namespace musher::vision {

// What is published of a picture. The headers are filled in by the publisher.
struct CourseSight {
  std::optional<msg::Sighting> sighting;  // of all detectors but those of lines; nothing in a doubt
  std::optional<msg::YellowLines> lines;  // of a detector of lines
  std::optional<std::string> text;  // what the detector's text topic says now; nothing: silent
  std::string doubt{};              // why a light may be there or not; then there is no sighting
};

class CourseDetector {
 public:
  virtual ~CourseDetector() = default;

  // `bgr`: CV_8UC3, not empty. `stamp_ns`: of the picture, later than the last picture's.
  // `lens`: nothing while it is unknown; the focal length of the parameters counts then. May throw:
  // the detector is replaced by a new one.
  virtual CourseSight Look(const cv::Mat& bgr, std::int64_t stamp_ns,
                           const std::optional<Lens>& lens) = 0;

  // Draws the region, and what the last Look() has found, on that picture.
  virtual void Draw(cv::Mat& bgr) const = 0;
};

}  // namespace musher::vision
