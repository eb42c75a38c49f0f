#include "musher/modules/wedding/photographer.hpp"

#include "musher/cyberdog/codes/module_codes.hpp"  // names modules in texts

namespace musher::wedding {

using msg::CameraService;

void Photographer::TakePhoto() {
  if (!camera_.Ready()) return log_("no photo: there is no camera service");
  CameraService::Request request;
  request.command = CameraService::kTakePicture;
  camera_.Call(request, timeout_, [this](const auto& answer) { OnAnswer(answer); });
}

void Photographer::OnAnswer(const Result<CameraService::Response>& answer) {
  if (answer && answer.value().result == CameraService::kSuccess) {
    return log_("photo " + std::to_string(++taken_) + ": " + answer.value().msg);
  }
  if (!answer) return log_("no photo: " + answer.error().message);
  log_("no photo: " + answer.value().msg + " (result " + std::to_string(answer.value().result) +
       ", " + CodeText(answer.value().code) + ")");
}

void Photographer::RecordVideo(bool on) {
  constexpr std::uint16_t kVideoFps = 30;  // of the robot's second generation
  if (!camera_.Ready()) return log_("no video: there is no camera service");
  CameraService::Request request;
  request.command = on ? CameraService::kStartRecording : CameraService::kStopRecording;
  if (on) request.fps = kVideoFps;
  camera_.Call(request, timeout_, [this, on](const auto& answer) { OnVideo(on, answer); });
}

void Photographer::OnVideo(bool on, const Result<CameraService::Response>& answer) {
  if (!answer) return log_("no video: " + answer.error().message);
  if (answer.value().result != CameraService::kSuccess) {
    return log_("no video: " + answer.value().msg + " (" + CodeText(answer.value().code) + ")");
  }
  log_((on ? "video begins: " : "video ends: ") + answer.value().msg);
}

}  // namespace musher::wedding
