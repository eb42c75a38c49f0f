#include "musher/modules/audio/audio_manager.hpp"

#include <utility>

#include "musher/modules/audio/audio_code.hpp"

namespace musher::audio {

AudioManager::AudioManager(const std::string& actuator_name, AudioConfig config,
                           SoundMakerFactory make_voice)
    : MachineActuator(actuator_name),
      config_(std::move(config)),
      make_voice_(std::move(make_voice)) {
  RegisterStateCallback([this](const State& state) { return Run(state); });
}

AudioManager::~AudioManager() {
  if (!node_) return;
  node_->RunOnLoop([this] {
    shell_.reset();
    output_.reset();
    maker_.reset();
    clock_.reset();
  });
}

Result<> AudioManager::Run(const State& state) {
  if (state == kSetUp) return SetUp();
  if (state == kSelfCheck) return SelfCheck();
  node_->RunOnLoop([&] { shell_->Enter(state); });
  return Ok();
}

Result<> AudioManager::SetUp() {
  node_ = node();
  Result<> made;
  node_->RunOnLoop([&] {
    if (!shell_) made = MakeAll();
  });
  return made;
}

Result<> AudioManager::MakeAll() {
  const auto log = [this](const std::string& line) { Log(line); };
  auto clock = transport::Clock::Of(machine_config().clock, node_->node(), [this] {
    if (shell_) shell_->OnTimeJumped();
  });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  maker_ = make_voice_ ? make_voice_(node_->loop())
                       : std::make_unique<VoiceMaker>(node_->loop(), config_.voice);
  output_ = MakeOutput(config_.output, node_->loop(), *clock_, log);
  auto shell = AudioShell::Make({node_->node(), *clock_, machine_config().name_space, log}, config_,
                                *maker_, *output_);
  if (!shell) return shell.error();
  shell_ = std::move(shell).value();
  return Ok();
}

// Checks both voice and output: the message names all failures.
Result<> AudioManager::SelfCheck() {
  const Result<> voice = maker_->Check();
  Result<> output = output_->Check();
  if (voice && output) return Ok();
  if (voice) return output;
  Error error{AudioCode(KeyCode::kSelfCheckFailed), voice.error().message};
  if (!output) error.message += "; " + output.error().message;
  return error;
}

}  // namespace musher::audio
