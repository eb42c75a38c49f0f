#pragma once
// Calls the camera's service to take the picture at the shutter, and to record an interview. The
// show does not wait for the reply; the outcome is logged.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/messages/protocol/camera.hpp"
#include "musher/transport/service.hpp"

namespace musher::wedding {

class Photographer {
 public:
  using CameraClient = transport::Client<msg::CameraService>;

  // `log` is called on the loop, as long as `camera` exists.
  Photographer(CameraClient& camera, Duration timeout, std::function<void(const std::string&)> log)
      : camera_(camera), timeout_(timeout), log_(std::move(log)) {}

  void TakePhoto();
  void RecordVideo(bool on);

 private:
  void OnVideo(bool on, const Result<msg::CameraService::Response>& answer);
  void OnAnswer(const Result<msg::CameraService::Response>& answer);

  CameraClient& camera_;
  const Duration timeout_;
  const std::function<void(const std::string&)> log_;
  std::uint64_t taken_ = 0;
};

}  // namespace musher::wedding
