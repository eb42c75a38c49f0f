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
  static Result<std::unique_ptr<Cameras>> Make(const Dependencies& around,
                                               const CamerasConfig& config,
                                               std::unique_ptr<Store> store);

  // The robot goes to that state, or is there again.
  void Enter(const State& state);

  // While a self-check goes on all that it looks at are on, whatever the state.
  void SetChecked(bool checked);
  // Of each camera in the order of the config, but for those it skips.
  std::vector<CameraFinding> Check() const;

 private:
  explicit Cameras(CamerasConfig config) : config_(std::move(config)) {}
  bool IsChecked(const CameraDevice& camera) const;

  const CamerasConfig config_;
  std::vector<std::unique_ptr<CameraDevice>> cameras_;
  std::unique_ptr<CameraServer> server_;
};

}  // namespace musher::camera
