// musher-audio-manager: the voice of a robot. See README.md beside this.

#include <iostream>

#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/audio_manager.hpp"
#include "musher/modules/program/module_main.hpp"

namespace {

using musher::program::kUsageError;

int Run(const musher::program::Options& options) {
  const musher::audio::AudioReading reading = musher::audio::ReadAudioFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return kUsageError;
  musher::audio::AudioManager manager(options.actuator, *reading.config);
  if (const musher::Result<> ready = manager.Prepare(options.state_config); !ready) {
    std::cerr << options.actuator << ": " << ready.error().message << std::endl;
    return kUsageError;
  }
  if (!manager.ActuatorStart()) return musher::program::kNotStarted;
  return manager.Wait();
}

}  // namespace

int main(int argc, char** argv) {
  return musher::program::Main(
      argc, argv,
      {"musher-audio-manager", "The voice of a robot, as the actuator audio.",
       "Exit codes: 0 torn down; 1 not started, which is said on stderr; 2 usage or config."},
      Run);
}
