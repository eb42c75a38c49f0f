#pragma once
// The actuator that looks for faces. See README.md beside this.
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
  // `maker` of the detector; called on the thread that looks and in the self-check.
  VisionManager(const std::string& actuator_name, VisionConfig config, DetectorMaker maker);
  ~VisionManager() override;

  // Reads the state config and registers a callback for each state that it lists; Start() follows.
  // `node` as for Init().
  Result<> Prepare(const std::string& state_config,
                   std::shared_ptr<transport::NodeThread> node = nullptr);

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> Enter(const State& state);
  Result<> MakeTopics();
  std::int64_t StampNs() const;
  void Log(const Error& error) const;

  const VisionConfig config_;
  const DetectorMaker maker_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<LookThread> looker_;
  std::unique_ptr<FaceTopics> topics_;
};

}  // namespace musher::vision
