#pragma once
// Sound into a folder of WAV files: 0001.wav, 0002.wav, ..., each holds what would have been
// played, at its volume. Takes as long as the sound by the module's clock.

#include <cstddef>
#include <memory>
#include <string>

#include "musher/base/work_queue.hpp"
#include "musher/modules/audio/output.hpp"

namespace musher::audio {

class WavOutput : public Output {
 public:
  // The folder need not exist yet. Files in it are kept; the numbers continue.
  WavOutput(transport::EventLoop& loop, transport::Clock& clock, std::string folder);
  ~WavOutput() override { WavOutput::Stop(); }

  void Play(std::shared_ptr<const Sound> sound, Ended ended) override;
  void Stop() override;
  void SetVolume(int volume) override;
  Result<> Check() override;

 private:
  // Appends what has been played by now to played_.
  void CollectPlayed();
  // Writes what was played, then calls `ended`.
  void Write(Ended ended);

  transport::EventLoop& loop_;
  transport::Clock& clock_;
  const std::string folder_;
  int number_ = 0;  // of the last file
  int volume_ = 100;
  std::shared_ptr<const Sound> sound_;  // that plays
  Time begun_{};
  Sound played_;
  transport::LoopHandlePtr end_;
  std::shared_ptr<int> playing_ =
      std::make_shared<int>(0);  // identifies the sound; shared with work posted to the loop
  WorkQueue thread_{{.name = "sound-file"}};
};

}  // namespace musher::audio
