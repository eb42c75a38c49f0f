#pragma once
// The actuator of the robot's cameras. See README.md in this folder.
//
// Threads: state callbacks on the actuator's worker, the cameras on the loop of its node; blocking
// work (devices, files) on threads of its own.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/camera/camera_config.hpp"
#include "musher/modules/camera/cameras.hpp"
#include "musher/transport/clock.hpp"

namespace musher::camera {

class CameraManager : public MachineActuator {
 public:
  CameraManager(const std::string& actuator_name, CamerasConfig config);
  ~CameraManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> MakeCameras();
  void LoadCodecs();

  CamerasConfig config_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  CaptureThreads threads_;
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<Cameras> cameras_;
};

}  // namespace musher::camera
