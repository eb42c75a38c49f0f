#include "musher/modules/audio/output.hpp"

#include <utility>

#include "musher/modules/audio/alsa_output.hpp"
#include "musher/modules/audio/wav_output.hpp"

namespace musher::audio {

std::unique_ptr<Output> MakeOutput(const OutputConfig& config, transport::EventLoop& loop,
                                   transport::Clock& clock,
                                   const std::function<void(const std::string&)>& log) {
  if (config.kind == OutputKind::kWav) {
    return std::make_unique<WavOutput>(loop, clock, config.folder);
  }
  if (config.kind == OutputKind::kSilent) return std::make_unique<SilentOutput>(clock);
  auto alsa = std::make_unique<AlsaOutput>(loop, config.device);
  const Result<> works = alsa->Check();
  if (works) return alsa;
  if (config.kind == OutputKind::kAlsa) {
    log("no sound yet: " + works.error().message);
    return alsa;
  }
  log("no sound device, the output is silent: " + works.error().message);
  return std::make_unique<SilentOutput>(clock);
}

void SilentOutput::Play(std::shared_ptr<const Sound> sound, Ended ended) {
  end_ = clock_.At(clock_.Now() + sound->Length(), [ended = std::move(ended)] { ended(Ok()); });
}

}  // namespace musher::audio
