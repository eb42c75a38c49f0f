#include "musher/modules/vision/vision_manager.hpp"

#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/actuator/program/states.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/modules/vision/picture/vision_code.hpp"

namespace musher::vision {

VisionManager::VisionManager(const std::string& actuator_name, VisionConfig config,
                             DetectorMaker maker)
    : VisionManager(actuator_name, std::move(config),
                    FaceWorkerMaker([this, maker = std::move(maker)](OnFaces on_result) {
                      return MakeThread(maker, std::move(on_result));
                    })) {}

VisionManager::VisionManager(const std::string& actuator_name, VisionConfig config,
                             FaceWorkerMaker make_worker)
    : MachineActuator(actuator_name),
      config_(std::move(config)),
      make_worker_(std::move(make_worker)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

VisionManager::~VisionManager() {
  if (!node_) return;
  // From here on pictures may arrive and are passed to the detectors.
  node_->RunOnLoop([this] {
    topics_.reset();
    for (const auto& detection : detections_) detection->CloseTopics();
  });
  face_worker_.reset();
  detections_.clear();
  node_->RunOnLoop([this] { clock_.reset(); });
}

Result<> VisionManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  if (config_.LooksIn(state)) {
    if (Result<> loaded = Load(); !loaded) return loaded;
  }
  return Enter(state);
}

Result<> VisionManager::Load() {
  if (face_worker_) {
    if (Result<> loaded = face_worker_->Load(); !loaded) return loaded;
  }
  for (const auto& detection : detections_) {
    if (Result<> loaded = detection->Load(); !loaded) return loaded;
  }
  return Ok();
}

Result<> VisionManager::SetUp() {
  constexpr std::int32_t kCode = VisionCode(KeyCode::kParametersInvalid);
  if (Result<> known = program::CheckStates(machine_config(), "look_in", config_.look_in, kCode);
      !known) {
    return known;
  }
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!clock_) made = MakeTopics();
  });
  return made;
}

Result<> VisionManager::MakeTopics() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node());
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  const Dependencies dependencies = {
      .node = node_->node(),
      .clock = *clock_,
      .name_space = machine_config().name_space,
      .stamp_ns = [this] { return msg::FromStamp(clock_->Stamp()).count(); },
      .log = [this](const Error& error) { Log(error); }};
  if (config_.detect_faces) {
    if (Result<> made = MakeFaceTopics(dependencies); !made) return made;
  }
  return MakeDetections(dependencies);
}

std::unique_ptr<DetectorWorker<Detector>> VisionManager::MakeThread(const DetectorMaker& maker,
                                                                    OnFaces on_result) {
  return std::make_unique<DetectorThread<Detector>>(
      node_->loop(), maker, config_.limits,
      DetectorThreadEvents<Detector>{
          .on_result = std::move(on_result),
          .on_left_out = [this] { topics_->OnLeftOut(); },
          .checkpoint = [this](Duration allowance) { Checkpoint(allowance); },
          .on_detector_lost = [this](const Error& error) { OnLost(error); }});
}

Result<> VisionManager::MakeFaceTopics(const Dependencies& dependencies) {
  face_worker_ = make_worker_([this](const DetectionResult<Detector>& result) {
    if (topics_) topics_->OnResult(result);
  });
  auto topics = FaceTopics::Make(dependencies, *face_worker_, config_);
  if (!topics) return topics.error();
  topics_ = std::move(topics).value();
  return Ok();
}

Result<> VisionManager::MakeDetections(const Dependencies& dependencies) {
  const DetectionEvents events = {
      .checkpoint = [this](Duration allowance) { Checkpoint(allowance); },
      .on_lost = [this](const Error& error) { OnLost(error); }};
  for (const CourseEntry& entry : config_.detectors) {
    auto made = CourseDetection::Make(dependencies, entry, config_.silence, events);
    if (!made) return made.error();
    detections_.push_back(std::move(made).value());
  }
  return Ok();
}

void VisionManager::OnLost(const Error& error) {
  Log({error.code, "the detector is lost: " + error.message});
  GiveUp({error.code, "the detector is lost"});
}

Result<> VisionManager::SetOn(bool on) {
  if (topics_) {
    if (Result<> set = topics_->SetOn(on); !set) return set;
  }
  for (const auto& detection : detections_) {
    if (Result<> set = detection->topics().SetOn(on); !set) return set;
  }
  return Ok();
}

Result<> VisionManager::SetChecked(bool checked) {
  if (topics_) {
    if (Result<> set = topics_->SetChecked(checked); !set) return set;
  }
  checked_.clear();
  for (const auto& detection : detections_) {
    if (Result<> set = detection->topics().SetChecked(checked); !set) return set;
    if (checked) checked_.push_back(detection.get());
  }
  return Ok();
}

// On a busy computer those that have passed would take the CPU from the others: all of them never
// pass in the same time.
Result<> VisionManager::Check() {
  if (topics_) {
    if (Result<> checked = topics_->Check(); !checked) return checked;
  }
  Result<> result;
  std::erase_if(checked_, [&result](CourseDetection* detection) {
    Result<> passed = detection->topics().Check();
    if (passed) passed = detection->topics().SetChecked(false);
    if (!passed && result) {
      result = Error{passed.error().code, detection->name() + ": " + passed.error().message};
    }
    return static_cast<bool>(passed);
  });
  return result;
}

Result<> VisionManager::Enter(const State& state) {
  Result<> entered;
  node_->RunOnLoop([&] {
    const bool looked = topics_ && topics_->looks();
    entered = SetOn(config_.LooksIn(state));
    if (looked && !topics_->looks()) {
      Log("detection is off in " + state + "; so far " + std::to_string(topics_->looked_at()) +
          " pictures, and " + std::to_string(topics_->left_out()) + " dropped for a newer one");
    }
  });
  return entered;
}

Result<> VisionManager::SelfCheck() {
  if (Result<> loaded = Load(); !loaded) {
    return Error{VisionCode(KeyCode::kSelfCheckFailed), loaded.error().message};
  }
  Result<> result;
  node_->RunOnLoop([&] { result = SetChecked(true); });
  if (result) {
    result = program::AwaitOnLoop(
        *node_, config_.self_check_time, [this] { return Check(); },
        [this] { return StopRequested(); });
  }
  node_->RunOnLoop([&] { static_cast<void>(SetChecked(false)); });
  return result;
}

}  // namespace musher::vision
