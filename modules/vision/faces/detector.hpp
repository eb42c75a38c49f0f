#pragma once
// The interface of a face detector. Derive from Detector to use another one.
//
// Threads: one call at a time.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/messages/sensor_msgs/image.hpp"
#include "musher/modules/vision/picture/face_box.hpp"
#include "musher/modules/vision/picture/picture.hpp"

namespace musher::vision {

class Detector {
 public:
  using Input = Shot;  // see detector_worker.hpp
  using Found = std::vector<FaceBox>;

  virtual ~Detector() = default;

  // In a picture that passed CheckPicture(). May throw: the detector is then replaced by a new
  // one.
  virtual std::vector<FaceBox> Detect(const msg::Image& picture) = 0;
  std::vector<FaceBox> Process(const Shot& shot) { return Detect(shot.picture); }
};

using DetectorMaker = std::function<Result<std::unique_ptr<Detector>>()>;

struct CascadeConfig {
  std::string model;       // file of a cascade, of OpenCV's Haar or LBP features
  int width_px = 320;      // wider pictures are scaled down to this
  double step = 1.1;       // factor between one face size that is searched and the next
  int neighbours = 3;      // how many detections around a place make a face
  double smallest = 0.05;  // of the picture's width, and of its height

  friend bool operator==(const CascadeConfig&, const CascadeConfig&) = default;
};

// The model found by the build, of Debian's opencv-data.
std::string DefaultModel();

// OpenCV's cascade classifier, which finds faces that look towards the camera, on one thread.
// Fails when the file is not a cascade model.
Result<std::unique_ptr<Detector>> MakeCascadeDetector(const CascadeConfig& config);

}  // namespace musher::vision
