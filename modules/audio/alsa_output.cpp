#include "musher/modules/audio/alsa_output.hpp"

#include <alsa/asoundlib.h>

#include <algorithm>
#include <array>
#include <thread>
#include <utility>

#include "musher/modules/audio/audio_code.hpp"

namespace musher::audio {
namespace {

constexpr unsigned kLatencyUs = 100'000;  // of the device's buffer
constexpr std::size_t kChunk = 512;       // samples; a stop takes effect after one chunk
constexpr int kWaitMs = 20;               // for room in the buffer
constexpr int kDrainLookMs = 5;
constexpr Duration kProgressTimeout = Milliseconds(2'000);

struct Close {
  void operator()(snd_pcm_t* pcm) const { snd_pcm_close(pcm); }
};
using Pcm = std::unique_ptr<snd_pcm_t, Close>;

void SayNothing(const char* /*file*/, int /*line*/, const char* /*function*/, int /*error*/,
                const char* /*format*/, ...) {}

Time Now() {
  return std::chrono::steady_clock::now();
}

Error Failed(const std::string& device, int error) {
  return {AudioCode(KeyCode::kDeviceError), "sound device " + device + ": " + snd_strerror(error)};
}

Result<Pcm> Open(const std::string& device, int rate_hz) {
  snd_pcm_t* opened = nullptr;
  const int error =
      snd_pcm_open(&opened, device.c_str(), SND_PCM_STREAM_PLAYBACK, SND_PCM_NONBLOCK);
  if (error < 0) return Failed(device, error);
  Pcm pcm(opened);
  const int set = snd_pcm_set_params(opened, SND_PCM_FORMAT_S16, SND_PCM_ACCESS_RW_INTERLEAVED, 1,
                                     static_cast<unsigned>(rate_hz), 1, kLatencyUs);
  if (set < 0) return Failed(device, set);
  return pcm;
}

}  // namespace

AlsaOutput::AlsaOutput(transport::EventLoop& loop, std::string device)
    : loop_(loop),
      device_(std::move(device)),
      wanted_(std::make_shared<std::atomic<std::uint64_t>>(0)),
      thread_({.name = "sound-output"}) {
  snd_lib_error_set_handler(SayNothing);  // errors are returned and logged once
}

AlsaOutput::~AlsaOutput() {
  AlsaOutput::Stop();
}

void AlsaOutput::Play(std::shared_ptr<const Sound> sound, Ended ended) {
  Job job{++last_, std::move(sound), std::move(ended)};
  *wanted_ = last_;
  thread_.Do([this, job = std::move(job)] { Run(job); }, {.key = "sound"});
}

void AlsaOutput::Stop() {
  *wanted_ = 0;
}

void AlsaOutput::Run(const Job& job) {
  if (!Wanted(job)) return;
  const Result<> result = PlayOut(job);
  loop_.Post([wanted = wanted_, number = job.number, ended = job.ended, result] {
    if (*wanted != number) return;
    *wanted = 0;
    ended(result);
  });
}

Result<> AlsaOutput::PlayOut(const Job& job) {
  const std::lock_guard lock(in_use_);
  const Result<Pcm> opened = Open(device_, job.sound->rate_hz);
  if (!opened) return opened.error();
  snd_pcm_t* pcm = opened.value().get();
  const std::vector<std::int16_t>& samples = job.sound->samples;
  Time progress = Now();
  for (std::size_t at = 0; at < samples.size() && Wanted(job);) {
    std::array<std::int16_t, kChunk> chunk{};
    const std::size_t count = std::min(kChunk, samples.size() - at);
    std::transform(
        samples.begin() + static_cast<std::ptrdiff_t>(at),
        samples.begin() + static_cast<std::ptrdiff_t>(at + count), chunk.begin(),
        [volume = volume_.load()](std::int16_t sample) { return Scaled(sample, volume); });
    const snd_pcm_sframes_t written = snd_pcm_writei(pcm, chunk.data(), count);
    if (written >= 0) {
      at += static_cast<std::size_t>(written);
      progress = Now();
      continue;
    }
    if (Now() - progress > kProgressTimeout) return Failed(device_, -ETIMEDOUT);
    const int error = written == -EAGAIN ? snd_pcm_wait(pcm, kWaitMs) : static_cast<int>(written);
    if (error < 0 && snd_pcm_recover(pcm, error, 1) < 0) return Failed(device_, error);
  }
  const int drained = Drain(pcm, job);
  snd_pcm_drop(pcm);
  return drained < 0 ? Result<>(Failed(device_, drained)) : Ok();
}

// Waits until the device has played all samples, or the sound is not wanted any more.
int AlsaOutput::Drain(snd_pcm_t* pcm, const Job& job) {
  const Time deadline = Now() + kProgressTimeout;
  while (Wanted(job)) {
    const int error = snd_pcm_drain(pcm);
    if (error != -EAGAIN) return error;
    if (Now() > deadline) return -ETIMEDOUT;
    std::this_thread::sleep_for(Milliseconds(kDrainLookMs));
  }
  return 0;
}

Result<> AlsaOutput::Check() {
  if (*wanted_ != 0) return Ok();  // it plays, or will report its error
  const std::lock_guard lock(in_use_);
  const Result<Pcm> opened = Open(device_, Sound{}.rate_hz);
  return opened ? Ok() : Result<>(Error{kBoardFailed, opened.error().message});
}

}  // namespace musher::audio
