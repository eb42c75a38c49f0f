#pragma once
// What finds faces in a picture. Who has a better one derives from Detector.
//
// Threads: one call at a time.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/vision/face_box.hpp"

namespace musher::vision {

class Detector {
 public:
  virtual ~Detector() = default;

  // In a picture that CheckPicture() has let pass. May throw: it is not asked again, but replaced
  // by a new one.
  virtual std::vector<FaceBox> Detect(const msg::Image& picture) = 0;
};

using DetectorMaker = std::function<Result<std::unique_ptr<Detector>>()>;

struct CascadeConfig {
  std::string model;       // file of a cascade, of OpenCV's Haar or LBP features
  int width_px = 320;      // wider pictures are scaled down to this
  double step = 1.1;       // from a size of faces that is looked for to the next
  int neighbours = 3;      // so many finds around a place make a face
  double smallest = 0.05;  // of the picture's width, and of its height

  friend bool operator==(const CascadeConfig&, const CascadeConfig&) = default;
};

// The model that the build found, of Debian's opencv-data.
std::string DefaultModel();

// OpenCV's cascade classifier, which finds faces that look towards the camera, on one thread. Fails
// when the model's file is none.
Result<std::unique_ptr<Detector>> MakeCascadeDetector(const CascadeConfig& config);

}  // namespace musher::vision
