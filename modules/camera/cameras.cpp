#include "musher/modules/camera/cameras.hpp"

#include <algorithm>
#include <utility>

namespace musher::camera {
namespace {

template <typename Name>
bool Contains(const std::vector<Name>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

Result<std::unique_ptr<Cameras>> Cameras::Make(const Dependencies& dependencies,
                                               const CamerasConfig& config,
                                               std::unique_ptr<Store> store) {
  std::unique_ptr<Cameras> cameras(new Cameras(config));
  for (const CameraConfig& camera : config.cameras) {
    auto device = CameraDevice::Make(dependencies, camera, config);
    if (!device) return device.error();
    cameras->cameras_.push_back(std::move(device).value());
  }
  for (const auto& camera : cameras->cameras_) {
    if (camera->config().name != config.service.camera) continue;
    auto server = CameraServer::Make(dependencies, config.service, *camera, std::move(store));
    if (!server) return server.error();
    cameras->server_ = std::move(server).value();
    break;
  }
  return cameras;
}

void Cameras::Enter(const State& state) {
  const bool on = Contains(config_.on_in, state);
  for (const auto& camera : cameras_) camera->SetOn(on);
  if (!on && server_) server_->OnOff();
}

bool Cameras::IsChecked(const CameraDevice& camera) const {
  return !Contains(config_.skip, camera.config().name);
}

void Cameras::SetChecked(bool checked) {
  for (const auto& camera : cameras_) camera->SetChecked(checked && IsChecked(*camera));
}

std::vector<CameraResult> Cameras::Check() const {
  std::vector<CameraResult> findings;
  for (const auto& camera : cameras_) {
    if (IsChecked(*camera)) findings.push_back({camera->config().name, camera->Check()});
  }
  return findings;
}

}  // namespace musher::camera
