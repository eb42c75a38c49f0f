#include "musher/modules/vision/vision_manager.hpp"

#include <utility>

#include "musher/actuator/program/await.hpp"
#include "musher/actuator/program/states.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::vision {

VisionManager::VisionManager(const std::string& actuator_name, VisionConfig config,
                             DetectorMaker maker)
    : MachineActuator(actuator_name), config_(std::move(config)), maker_(std::move(maker)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

VisionManager::~VisionManager() {
  if (!node_) return;
  // From here on pictures may arrive and are passed to the looker.
  node_->RunOnLoop([this] { topics_.reset(); });
  looker_.reset();
  node_->RunOnLoop([this] { clock_.reset(); });
}

Result<> VisionManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  if (config_.LooksIn(state)) {
    if (Result<> loaded = looker_->Load(); !loaded) return loaded;
  }
  return Enter(state);
}

Result<> VisionManager::SetUp() {
  constexpr std::int32_t kCode = MakeCode(ModuleCode::kFace, KeyCode::kParametersInvalid);
  if (Result<> known = program::CheckStates(machine_config(), "look_in", config_.look_in, kCode);
      !known) {
    return known;
  }
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!topics_) made = MakeTopics();
  });
  return made;
}

Result<> VisionManager::MakeTopics() {
  auto clock = transport::Clock::Of(machine_config().clock, node_->node());
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  looker_ = std::make_unique<LookThread>(
      node_->loop(), maker_, config_.look,
      LookThreadEvents{.on_result =
                           [this](const LookResult& result) {
                             if (topics_) topics_->OnResult(result);
                           },
                       .on_left_out = [this] { topics_->OnLeftOut(); },
                       .checkpoint = [this](Duration allowance) { Checkpoint(allowance); },
                       .on_detector_lost =
                           [this](const Error& error) {
                             Log({error.code, "the detector is lost: " + error.message});
                             GiveUp({error.code, "the detector is lost"});
                           }});
  const Dependencies dependencies = {node_->node(),
                                     *clock_,
                                     machine_config().name_space,
                                     [this] { return msg::FromStamp(clock_->Stamp()).count(); },
                                     [this](const Error& error) { Log(error); },
                                     *looker_};
  auto topics = FaceTopics::Make(dependencies, config_);
  if (!topics) return topics.error();
  topics_ = std::move(topics).value();
  return Ok();
}

Result<> VisionManager::Enter(const State& state) {
  Result<> entered;
  node_->RunOnLoop([&] {
    const bool looked = topics_->looks();
    entered = topics_->SetOn(config_.LooksIn(state));
    if (looked && !topics_->looks()) {
      Log("detection is off in " + state + "; so far " + std::to_string(topics_->looked_at()) +
          " pictures, and " + std::to_string(topics_->left_out()) + " dropped for a newer one");
    }
  });
  return entered;
}

Result<> VisionManager::SelfCheck() {
  if (Result<> loaded = looker_->Load(); !loaded) {
    return Error{MakeCode(ModuleCode::kFace, KeyCode::kSelfCheckFailed), loaded.error().message};
  }
  Result<> result;
  node_->RunOnLoop([&] { result = topics_->SetChecked(true); });
  if (result) {
    result = program::AwaitOnLoop(
        *node_, config_.self_check_time, [this] { return topics_->Check(); },
        [this] { return StopRequested(); });
  }
  node_->RunOnLoop([&] { static_cast<void>(topics_->SetChecked(false)); });
  return result;
}

}  // namespace musher::vision
