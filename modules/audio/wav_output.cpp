#include "musher/modules/audio/wav_output.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/sound_file.hpp"

namespace musher::audio {
namespace {

namespace fs = std::filesystem;

// The highest number of a file in the folder.
int LastNumber(const std::string& folder) {
  int last = 0;
  for (const fs::path& file : EntriesOf(folder)) {
    int number = 0;
    if (file.extension() != ".wav") continue;
    if (std::sscanf(file.stem().c_str(), "%9d", &number) == 1) last = std::max(last, number);
  }
  return last;
}

}  // namespace

WavOutput::WavOutput(transport::EventLoop& loop, transport::Clock& clock, std::string folder)
    : loop_(loop), clock_(clock), folder_(std::move(folder)), number_(LastNumber(folder_)) {}

void WavOutput::Play(std::shared_ptr<const Sound> sound, Ended ended) {
  Stop();
  ++*playing_;
  sound_ = std::move(sound);
  played_ = {sound_->rate_hz, {}};
  begun_ = clock_.Now();
  // By the timer, not by the time: when the clock jumps, the rest of a timer is kept.
  end_ = clock_.At(begun_ + sound_->Length(), [this, ended = std::move(ended)] {
    const Ended then = ended;  // the timer is destroyed below
    begun_ = clock_.Now() - sound_->Length();
    CollectPlayed();
    Write(then);
  });
}

void WavOutput::Stop() {
  ++*playing_;
  if (!sound_) return;
  CollectPlayed();
  Write(nullptr);
}

void WavOutput::SetVolume(int volume) {
  if (sound_) CollectPlayed();
  volume_ = volume;
}

void WavOutput::CollectPlayed() {
  const double seconds = ToSeconds(clock_.Now() - begun_);
  const double reached =
      std::clamp(seconds * sound_->rate_hz + 0.5, 0.0, static_cast<double>(sound_->samples.size()));
  for (std::size_t i = played_.samples.size(); i < static_cast<std::size_t>(reached); ++i) {
    played_.samples.push_back(Scaled(sound_->samples[i], volume_));
  }
}

void WavOutput::Write(Ended ended) {
  sound_.reset();
  end_.reset();
  char name[32];
  std::snprintf(name, sizeof name, "%04d.wav", ++number_);
  thread_.Do([this, path = (fs::path(folder_) / name).string(), played = std::move(played_),
              playing = playing_, which = *playing_, ended = std::move(ended)] {
    std::error_code error;
    fs::create_directories(folder_, error);  // WriteWav() reports the error
    const Result<> written = WriteWav(path, played);
    if (!ended) return;
    loop_.Post([playing, which, ended, written] {
      if (*playing == which) ended(written);
    });
  });
}

Result<> WavOutput::Check() {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (!error && access(folder_.c_str(), W_OK) == 0) return Ok();
  return Error{kBoardFailed, folder_ + " cannot be written to"};
}

}  // namespace musher::audio
