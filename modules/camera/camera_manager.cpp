#include "musher/modules/camera/camera_manager.hpp"

#include <algorithm>
#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/actuator/program/states.hpp"
#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/modules/camera/camera_code.hpp"
#include "musher/modules/camera/media.hpp"

namespace musher::camera {

CameraManager::CameraManager(const std::string& actuator_name, CamerasConfig config)
    : MachineActuator(actuator_name), config_(std::move(config)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

CameraManager::~CameraManager() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    cameras_.reset();
    clock_.reset();
  });
}

Result<> CameraManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  node_->RunOnLoop([&] { cameras_->Enter(state); });
  return Ok();
}

Result<> CameraManager::SetUp() {
  constexpr std::int32_t kCode = CameraCode(KeyCode::kParametersInvalid);
  if (Result<> known = program::CheckStates(machine_config(), "on_in", config_.on_in, kCode);
      !known) {
    return known;
  }
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!cameras_) made = MakeCameras();
  });
  return made;
}

Result<> CameraManager::MakeCameras() {
  if (config_.service.folder.empty()) {
    config_.service.folder = machine_config().state_dir + "/camera";
  }
  transport::Node& node = node_->node();
  auto clock = transport::Clock::Of(machine_config().clock, node);
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  const Dependencies dependencies = {
      node,
      machine_config().name_space,
      [this] { return clock_->Stamp(); },
      [this](const LogLine& log) {
        Log({log.code, log.text});
      },
      [this] { return Allowed("camera", cyberdog::module_code::kCameraServer); },
      [this, &node](const CameraConfig& camera,
                    SourceEvents events) -> Result<std::unique_ptr<Source>> {
        if (camera.source == SourceKind::kWorld) {
          return OpenTopic(node, transport::ResolveName(machine_config().name_space, camera.from),
                           std::move(events));
        }
        return OpenCapture(node.loop(), threads_, camera, std::move(events));
      }};
  auto cameras =
      Cameras::Make(dependencies, config_, MakeStore(node.loop(), config_.service.folder));
  if (!cameras) return cameras.error();
  cameras_ = std::move(cameras).value();
  return Ok();
}

// Two hundred libraries take seconds to load while a robot starts: these are not the silence of a
// camera. Why they could not be loaded is said by the camera that needs them.
void CameraManager::LoadCodecs() {
  const auto needs_codecs = [this](const CameraConfig& camera) {
    const bool skipped =
        std::find(config_.skip.begin(), config_.skip.end(), camera.name) != config_.skip.end();
    return camera.source != SourceKind::kWorld && !skipped;
  };
  if (std::any_of(config_.cameras.begin(), config_.cameras.end(), needs_codecs)) {
    static_cast<void>(LoadMedia());
  }
}

// A camera may need a moment to its first picture: failed checks are repeated until the timeout.
Result<> CameraManager::SelfCheck() {
  LoadCodecs();
  SelfCheckVerdict result;
  node_->RunOnLoop([&] { cameras_->SetChecked(true); });
  const auto check = [&]() -> Result<> {
    result = EvaluateSelfCheck(cameras_->Check(), config_.critical);
    if (result.failing.empty()) return Ok();
    return Error{kCodeFailed, result.failing};
  };
  static_cast<void>(program::AwaitOnLoop(*node_, config_.self_check_time, check,
                                         [this] { return StopRequested(); }));
  // Not in SelfCheck itself: only a check, and the state stays.
  const State from = CurrentState();
  const bool enters = from == kSetUp || from == kSelfCheck || from == kError;
  node_->RunOnLoop([&] {
    if (result.result && enters) cameras_->Enter(State(kSelfCheck));
    cameras_->SetChecked(false);
  });
  if (result.result && !result.failing.empty()) {
    constexpr std::int32_t kCode = CameraCode(KeyCode::kSelfCheckFailed);
    ReportDegraded({kCode, result.failing});
    Log({kCode, "self-check, degraded: " + result.failing});
  }
  return result.result;
}

}  // namespace musher::camera
