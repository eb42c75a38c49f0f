#pragma once
// The actuator `audio`: the voice of a robot. See README.md in this folder.
//
// Threads: state callbacks on the actuator's worker, topics and services on the loop of its node;
// sound is made and played on threads of its own.

#include <memory>
#include <string>

#include "musher/actuator/machine_actuator.hpp"
#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/audio_shell.hpp"
#include "musher/modules/audio/output.hpp"
#include "musher/modules/audio/sound_maker.hpp"
#include "musher/transport/clock.hpp"

namespace musher::audio {

class AudioManager : public MachineActuator {
 public:
  // `make_voice` empty: a VoiceMaker.
  AudioManager(const std::string& actuator_name, AudioConfig config,
               SoundMakerFactory make_voice = {});
  ~AudioManager() override;

 private:
  Result<> Run(const State& state);
  Result<> SetUp();
  Result<> SelfCheck();
  Result<> MakeAll();

  const AudioConfig config_;
  const SoundMakerFactory make_voice_;
  std::shared_ptr<transport::NodeThread> node_;  // from SetUp on
  std::unique_ptr<transport::Clock> clock_;
  std::unique_ptr<SoundMaker> maker_;
  std::unique_ptr<Output> output_;
  std::unique_ptr<AudioShell> shell_;
};

}  // namespace musher::audio
