#pragma once
// All cameras of the module together, and camera_service. Runs on any transport.
//
// Threads: the loop's.

#include <memory>
#include <vector>

#include "musher/lifecycle/state.hpp"
#include "musher/modules/camera/camera_device.hpp"
#include "musher/modules/camera/camera_server.hpp"

namespace musher::camera {

class Cameras {
 public:
  static Result<std::unique_ptr<Cameras>> Make(const Dependencies& dependencies,
                                               const CamerasConfig& config,
                                               std::unique_ptr<Store> store);

  // Switches the cameras for that state; the robot enters it or is driven to it again.
  void Enter(const State& state);

  // During a self-check all cameras that it checks are on, whatever the state.
  void SetChecked(bool checked);
  // Of each camera in the order of the config, except those that it skips.
  std::vector<CameraResult> Check() const;

 private:
  explicit Cameras(CamerasConfig config) : config_(std::move(config)) {}
  bool IsChecked(const CameraDevice& camera) const;

  const CamerasConfig config_;
  std::vector<std::unique_ptr<CameraDevice>> cameras_;
  std::unique_ptr<CameraServer> server_;
};

}  // namespace musher::camera
