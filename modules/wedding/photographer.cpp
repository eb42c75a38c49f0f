#include "musher/modules/wedding/photographer.hpp"

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

}  // namespace musher::wedding
