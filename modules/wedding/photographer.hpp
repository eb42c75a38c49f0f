#pragma once
// Has the camera's service take the picture at the shutter. Nobody waits for it: its outcome is
// said and counted.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/messages/protocol/camera.hpp"
#include "musher/transport/service.hpp"

namespace musher::wedding {

struct PhotoCounts {
  std::uint64_t asked = 0;
  std::uint64_t taken = 0;
  std::uint64_t failed = 0;
};

class Photographer {
 public:
  using CameraClient = transport::Client<msg::CameraService>;

  // `log` is called on the loop, as long as `camera` is there.
  Photographer(CameraClient& camera, Duration timeout, std::function<void(const std::string&)> log)
      : camera_(camera), timeout_(timeout), log_(std::move(log)) {}

  void TakePhoto();
  // Whether there is a service.
  bool Ready() const { return camera_.Ready(); }
  const PhotoCounts& counts() const { return counts_; }

 private:
  void OnAnswer(const Result<msg::CameraService::Response>& answer);

  CameraClient& camera_;
  const Duration timeout_;
  const std::function<void(const std::string&)> log_;
  PhotoCounts counts_;
};

}  // namespace musher::wedding
