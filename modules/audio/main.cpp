// musher-audio-manager: the voice of a robot. See README.md in this folder.

#include "musher/actuator/program/module_main.hpp"
#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/audio_manager.hpp"

namespace {

int Run(const musher::program::Options& options) {
  return musher::program::RunModule<musher::audio::AudioManager>(
      options, musher::audio::ReadAudioFile(options.file));
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-audio-manager", "The voice of a robot, as the actuator audio.",
       "Exit codes: 0 torn down; 1 not started (reason on stderr); 2 usage or config."},
      Run);
}
