#pragma once
// Sound into a folder: 0001.wav, 0002.wav, ..., each what would have been heard, as loud as it
// would have been. Takes as long as the sound does by the module's clock.

#include <cstddef>
#include <memory>
#include <string>

#include "musher/modules/audio/output.hpp"
#include "musher/modules/audio/work_thread.hpp"

namespace musher::audio {

class WavOutput : public Output {
 public:
  // The folder need not be there yet. Files in it stay; the numbers go on.
  WavOutput(transport::EventLoop& loop, transport::Clock& clock, std::string folder);
  ~WavOutput() override { WavOutput::Stop(); }

  void Play(std::shared_ptr<const Sound> sound, Ended ended) override;
  void Stop() override;
  void SetVolume(int volume) override;
  Result<> Check() override;

 private:
  // Moves what has been played by now into heard_.
  void Hear();
  // Writes what was heard, then calls `ended`.
  void Write(Ended ended);

  transport::EventLoop& loop_;
  transport::Clock& clock_;
  const std::string folder_;
  int number_ = 0;  // of the last file
  int volume_ = 100;
  std::shared_ptr<const Sound> sound_;  // that plays
  Time begun_{};
  Sound heard_;
  transport::LoopHandlePtr end_;
  std::shared_ptr<int> playing_ = std::make_shared<int>(0);  // which one; outlives what is posted
  WorkThread thread_;
};

}  // namespace musher::audio
