#include "musher/modules/audio/sound_maker.hpp"

#include <future>
#include <utility>

#include "musher/modules/audio/sound_file.hpp"

namespace musher::audio {

VoiceMaker::VoiceMaker(transport::EventLoop& loop, const VoiceConfig& config)
    : loop_(loop), wanted_(std::make_shared<std::atomic<std::uint64_t>>(0)) {
  thread_.Do([this, config] { voice_.emplace(config); });
}

VoiceMaker::~VoiceMaker() {
  VoiceMaker::Cancel();
}

void VoiceMaker::Make(const Utterance& what, Done done) {
  const std::uint64_t number = ++last_;
  *wanted_ = number;
  thread_.Do([this, number, what, done = std::move(done)] {
    const auto given_up = [this, number] { return *wanted_ != number; };
    if (given_up()) return;
    Result<Sound> sound = what.recording.empty() ? voice_->Speak(what.text, what.language, given_up)
                                                 : ReadSound(what.recording);
    loop_.Post([wanted = wanted_, number, done, sound = std::move(sound)]() mutable {
      if (*wanted == number) done(std::move(sound));
    });
  });
}

Result<> VoiceMaker::Check() {
  std::promise<Result<>> verdict;
  thread_.Do([&] { verdict.set_value(voice_->Check()); });
  return verdict.get_future().get();
}

}  // namespace musher::audio
