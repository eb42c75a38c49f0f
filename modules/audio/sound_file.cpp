#include "musher/modules/audio/sound_file.hpp"

#include <sndfile.h>

#include <cstddef>
#include <memory>

#include "musher/modules/audio/audio_code.hpp"

namespace musher::audio {
namespace {

struct CloseFile {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using File = std::unique_ptr<SNDFILE, CloseFile>;

Result<File> Open(const std::string& path, SF_INFO& info) {
  File file(sf_open(path.c_str(), SFM_READ, &info));
  const auto refuse = [&path](const std::string& why) {
    return Error{AudioCode(AudioKey::kRecording), path + ": " + why};
  };
  if (!file) return refuse(sf_strerror(nullptr));
  if (info.frames <= 0) return refuse("there is no sound in it");
  if (std::chrono::seconds(info.frames / info.samplerate) >= kLongestRecording) {
    return refuse("it is longer than 10 minutes");
  }
  return file;
}

}  // namespace

Result<> CheckSound(const std::string& path) {
  SF_INFO info{};
  const auto file = Open(path, info);
  return file ? Ok() : Result<>(file.error());
}

Result<Sound> ReadSound(const std::string& path) {
  SF_INFO info{};
  const auto file = Open(path, info);
  if (!file) return file.error();
  const auto channels = static_cast<std::size_t>(info.channels);
  std::vector<std::int16_t> read(static_cast<std::size_t>(info.frames) * channels);
  const sf_count_t frames = sf_readf_short(file.value().get(), read.data(), info.frames);
  Sound sound{info.samplerate, {}};
  sound.samples.reserve(static_cast<std::size_t>(frames));
  for (std::size_t frame = 0; frame < static_cast<std::size_t>(frames); ++frame) {
    int sum = 0;
    for (std::size_t channel = 0; channel < channels; ++channel) {
      sum += read[frame * channels + channel];
    }
    sound.samples.push_back(static_cast<std::int16_t>(sum / info.channels));
  }
  return sound;
}

Result<> WriteWav(const std::string& path, const Sound& sound) {
  SF_INFO info{};
  info.samplerate = sound.rate_hz;
  info.channels = 1;
  info.format = SF_FORMAT_WAV | SF_FORMAT_PCM_16;
  const File file(sf_open(path.c_str(), SFM_WRITE, &info));
  const auto size = static_cast<sf_count_t>(sound.samples.size());
  if (file && sf_write_short(file.get(), sound.samples.data(), size) == size) return Ok();
  return Error{AudioCode(KeyCode::kDeviceError), path + ": " + sf_strerror(file.get())};
}

}  // namespace musher::audio
