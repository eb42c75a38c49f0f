#pragma once
// Makes the sound of a phrase or a text, beside the loop: by the voice, or from a recording.

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "musher/modules/audio/phrases.hpp"
#include "musher/modules/audio/sound.hpp"
#include "musher/modules/audio/voice.hpp"
#include "musher/modules/audio/work_thread.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::audio {

// Threads: the loop's.
class SoundMaker {
 public:
  using Done = std::function<void(Result<Sound>)>;

  virtual ~SoundMaker() = default;

  // `done` runs on the loop, never inside Make(). One at a time: the next one ends the last.
  virtual void Make(const Utterance& what, Done done) = 0;
  // What is being made is not wanted any more: its `done` does not run.
  virtual void Cancel() = 0;
};

class VoiceMaker : public SoundMaker {
 public:
  VoiceMaker(transport::EventLoop& loop, const VoiceConfig& config);
  ~VoiceMaker() override;

  void Make(const Utterance& what, Done done) override;
  void Cancel() override { *wanted_ = 0; }

  // Whether it can speak. From any thread but the loop's: it waits.
  Result<> Check();

 private:
  transport::EventLoop& loop_;
  // The number of the one that is wanted, 0: none. What is posted to the loop may outlive the
  // maker.
  const std::shared_ptr<std::atomic<std::uint64_t>> wanted_;
  std::uint64_t last_ = 0;
  std::optional<Voice> voice_;  // of the thread
  WorkThread thread_;           // last: it uses the rest
};

}  // namespace musher::audio
