#pragma once
// One camera: its source, and the topics it publishes.
//
// Threads: the loop's.

#include <functional>
#include <memory>
#include <optional>

#include "musher/modules/camera/camera_core.hpp"
#include "musher/modules/camera/dependencies.hpp"
#include "musher/modules/camera/self_check.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::camera {

class CameraDevice {
 public:
  static Result<std::unique_ptr<CameraDevice>> Make(const Dependencies& dependencies,
                                                    const CameraConfig& camera,
                                                    const CamerasConfig& config);

  // Three reasons to be on: the robot is in a state in which cameras are on; a self-check runs;
  // camera_service uses its pictures.
  void SetOn(bool on);
  void SetChecked(bool checked);
  void SetUsed(bool used);

  // Gets each published picture, whatever the rate; null: no listener.
  void SetListener(std::function<void(const msg::Image&)> listener) {
    listener_ = std::move(listener);
  }

  // Whether there was a picture since it was wanted and there is no fault. Fails with 4409 or with
  // the fault.
  Result<> Check() const;
  bool on() const { return on_; }
  const CameraConfig& config() const { return camera_; }

 private:
  CameraDevice(const Dependencies& dependencies, const CameraConfig& camera,
               const CamerasConfig& config);
  void Reconsider();
  void Do(CameraActions actions);
  void Open();
  void Fail(const Error& error);
  void Later(std::function<void()> work);
  void OnFrame(msg::Image picture);
  void Publish(msg::Image picture);
  void PublishInfo(const msg::Image& picture);
  void Schedule();
  bool Watched() const;
  Time Now() const { return dependencies_.node.loop().Now(); }

  const Dependencies dependencies_;
  const CameraConfig camera_;
  CameraCore core_;
  bool on_ = false;
  bool checked_ = false;
  bool used_ = false;
  std::function<void(const msg::Image&)> listener_;
  std::optional<msg::CameraInfo> info_;  // of the source
  transport::Publisher<msg::Image>* pictures_ = nullptr;
  transport::Publisher<msg::CameraInfo>* infos_ = nullptr;
  transport::Endpoints endpoints_;  // the source publishes with them
  std::shared_ptr<int> alive_ = std::make_shared<int>();
  std::unique_ptr<Source> source_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::camera
