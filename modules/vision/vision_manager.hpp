#pragma once
// The actuator that detects faces and what is on a course. See README.md in this folder.
//
// Threads: state callbacks on the actuator's worker, topics on the loop of its node, each detector
// on a thread of its own, which ends the actuator when it loses its detector.

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/vision/course/course_detection.hpp"
#include "musher/modules/vision/face_topics.hpp"
#include "musher/modules/vision/picture/detector_thread.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/transport/clock.hpp"

namespace musher::vision {

class VisionManager : public MachineActuator {
 public:
  using OnFaces = std::function<void(DetectionResult<Detector>)>;
  using FaceWorkerMaker =
      std::function<std::unique_ptr<DetectorWorker<Detector>>(OnFaces on_result)>;

  // `maker` makes the detector of faces; called on the detector's thread and in the self-check.
  VisionManager(const std::string& actuator_name, VisionConfig config, DetectorMaker maker);
  // With another worker than a DetectorThread.
  VisionManager(const std::string& actuator_name, VisionConfig config, FaceWorkerMaker make_worker);
  ~VisionManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> Load();
  Result<> SelfCheck();
  Result<> Enter(const State& state);
  Result<> MakeTopics();
  Result<> MakeFaceTopics(const Dependencies& dependencies);
  Result<> MakeDetections(const Dependencies& dependencies);
  void OnLost(const Error& error);
  Result<> SetOn(bool on);
  Result<> SetChecked(bool checked);
  // Of the detectors that have not passed; one that passes looks no more.
  Result<> Check();
  std::unique_ptr<DetectorWorker<Detector>> MakeThread(const DetectorMaker& maker,
                                                       OnFaces on_result);

  const VisionConfig config_;
  const FaceWorkerMaker make_worker_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  // Of faces; null: they are not detected.
  std::unique_ptr<DetectorWorker<Detector>> face_worker_;
  std::unique_ptr<FaceTopics> topics_;
  std::vector<std::unique_ptr<CourseDetection>> detections_;
  std::vector<CourseDetection*> checked_;  // in the self-check that runs, without those that passed
};

}  // namespace musher::vision
