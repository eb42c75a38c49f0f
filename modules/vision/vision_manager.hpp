#pragma once
// The actuator that detects faces. See README.md in this folder.
//
// Threads: state callbacks on the actuator's worker, topics on the loop of its node, the detector
// on a thread of its own, which ends the actuator when it loses its detector.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/vision/face_topics.hpp"
#include "musher/modules/vision/vision_config.hpp"
#include "musher/transport/clock.hpp"

namespace musher::vision {

class VisionManager : public MachineActuator {
 public:
  // `maker` makes the detector; called on the detector's thread and in the self-check.
  VisionManager(const std::string& actuator_name, VisionConfig config, DetectorMaker maker);
  ~VisionManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> Enter(const State& state);
  Result<> MakeTopics();

  const VisionConfig config_;
  const DetectorMaker maker_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<LookThread> looker_;
  std::unique_ptr<FaceTopics> topics_;
};

}  // namespace musher::vision
