#pragma once
// Sound to an ALSA device. The device is opened for each sound, so that one that was unplugged and
// plugged in again works, and other programs can use it in between.

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "musher/base/work_queue.hpp"
#include "musher/modules/audio/output.hpp"

struct _snd_pcm;  // NOLINT(readability-identifier-naming,bugprone-reserved-identifier): ALSA's

namespace musher::audio {

class AlsaOutput : public Output {
 public:
  AlsaOutput(transport::EventLoop& loop, std::string device);
  ~AlsaOutput() override;

  void Play(std::shared_ptr<const Sound> sound, Ended ended) override;
  void Stop() override;
  void SetVolume(int volume) override { volume_ = volume; }
  Result<> Check() override;

 private:
  struct Job {
    std::uint64_t number = 0;
    std::shared_ptr<const Sound> sound;
    Ended ended;
  };

  void Run(const Job& job);
  Result<> PlayOut(const Job& job);
  int Drain(_snd_pcm* pcm, const Job& job);
  bool Wanted(const Job& job) const { return *wanted_ == job.number; }

  transport::EventLoop& loop_;
  const std::string device_;
  std::uint64_t last_ = 0;
  std::atomic<int> volume_ = 100;
  // The job that is wanted, 0: none. Work posted to the loop may outlive the output.
  const std::shared_ptr<std::atomic<std::uint64_t>> wanted_;
  std::mutex in_use_;  // guards the device
  WorkQueue thread_;   // last: it uses the rest
};

}  // namespace musher::audio
