#pragma once
// Where sound goes. One sound at a time.
//
// Threads: the loop's, except for Check().

#include <functional>
#include <memory>
#include <string>

#include "musher/base/result.hpp"
#include "musher/modules/audio/audio_config.hpp"
#include "musher/modules/audio/sound.hpp"
#include "musher/transport/clock.hpp"

namespace musher::audio {

class Output {
 public:
  using Ended = std::function<void(Result<>)>;

  virtual ~Output() = default;

  // `ended` runs on the loop when the sound has been played, or with the reason why not (the code
  // of a device that takes no sound); never inside Play(). Ends a sound that plays.
  virtual void Play(std::shared_ptr<const Sound> sound, Ended ended) = 0;
  // Stops the sound at once; `ended` does not run.
  virtual void Stop() = 0;
  // In %; applies also to a sound that plays.
  virtual void SetVolume(int volume) = 0;
  // Whether sound can be played. From any thread; may take a moment.
  virtual Result<> Check() = 0;
};

// The output of the config. With `auto`, logs which one was chosen.
std::unique_ptr<Output> MakeOutput(const OutputConfig& config, transport::EventLoop& loop,
                                   transport::Clock& clock,
                                   const std::function<void(const std::string&)>& log);

// Takes as long as the sound by the module's clock, and makes none.
class SilentOutput : public Output {
 public:
  explicit SilentOutput(transport::Clock& clock) : clock_(clock) {}

  void Play(std::shared_ptr<const Sound> sound, Ended ended) override;
  void Stop() override { end_.reset(); }
  void SetVolume(int /*volume*/) override {}
  Result<> Check() override { return Ok(); }

 private:
  transport::Clock& clock_;
  transport::LoopHandlePtr end_;
};

}  // namespace musher::audio
