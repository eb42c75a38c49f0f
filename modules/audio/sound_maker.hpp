#pragma once
// Makes the sound of a phrase or a text beside the loop: by the voice, or from a recording.

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "musher/base/work_queue.hpp"
#include "musher/modules/audio/phrases.hpp"
#include "musher/modules/audio/sound.hpp"
#include "musher/modules/audio/voice.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::audio {

// Threads: the loop's.
class SoundMaker {
 public:
  using Done = std::function<void(Result<Sound>)>;

  virtual ~SoundMaker() = default;

  // `done` runs on the loop, never inside Make(). One at a time: a new one cancels the last.
  virtual void Make(const Utterance& what, Done done) = 0;
  // Cancels what is being made: its `done` does not run.
  virtual void Cancel() = 0;
  // Whether it works. From any thread but the loop's: it may block.
  virtual Result<> Check() = 0;
};

using SoundMakerFactory = std::function<std::unique_ptr<SoundMaker>(transport::EventLoop&)>;

class VoiceMaker : public SoundMaker {
 public:
  VoiceMaker(transport::EventLoop& loop, const VoiceConfig& config);
  ~VoiceMaker() override;

  void Make(const Utterance& what, Done done) override;
  void Cancel() override { *wanted_ = 0; }

  Result<> Check() override;

 private:
  transport::EventLoop& loop_;
  // The number of the sound that is wanted, 0: none. Work posted to the loop may outlive the
  // maker.
  const std::shared_ptr<std::atomic<std::uint64_t>> wanted_;
  std::uint64_t last_ = 0;
  std::optional<Voice> voice_;           // used by the thread only
  WorkQueue thread_{{.name = "voice"}};  // last: it uses the rest
};

}  // namespace musher::audio
