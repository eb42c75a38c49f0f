#pragma once
// Speech of people to the robot: texts of a speech recogniser are published as `asr_text`, and as
// `dog_wakeup` if they contain the wake word, unless the microphone is off. The recogniser is
// another program, or the simulated world; it publishes on `world/speech_text`. Also serves the
// robot's name and wake word, and the app's queries about the voice.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <string>

#include "musher/base/result.hpp"
#include "musher/messages/protocol/speech.hpp"
#include "musher/messages/protocol/tasks.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::audio {

class SpeechInput {
 public:
  static constexpr const char* kNickName = "铁蛋";      // CyberDog's
  static constexpr const char* kWakeName = "铁蛋铁蛋";  // the same
  static constexpr std::size_t kLongestName = 64;       // bytes
  static constexpr std::size_t kLongestText = 4096;     // bytes; a longer one is dropped

  using Log = std::function<void(const std::string&)>;

  // Its topics and services are kept in `endpoints`, which is dropped first and has the error if
  // one could not be opened. `microphone_on` is called for each text.
  SpeechInput(transport::Endpoints& endpoints, std::function<bool()> microphone_on, Log log);
  SpeechInput(const SpeechInput&) = delete;
  SpeechInput& operator=(const SpeechInput&) = delete;

  // Whether there is sound; a change is published on `audio_board_state`.
  void SetSpeaking(bool speaking);

 private:
  // Of audio_board_state, as programs for CyberDog read it. 1, a recogniser begins, is never
  // published.
  enum class BoardState : std::uint8_t { kSaid = 0, kRecognised = 2, kSpeaking = 3 };

  void Publish(BoardState state);
  void OnText(const std::string& text);
  Result<> SetNames(const msg::AudioNickName::Request& names);

  const std::function<bool()> microphone_on_;
  const Log log_;
  std::string nick_name_ = kNickName;
  std::string wake_name_ = kWakeName;
  bool own_name_ = true;   // false: the wake word is CyberDog's
  bool refusing_ = false;  // the last text was refused
  bool speaking_ = false;
  transport::Publisher<msg::UInt8>* const board_;
  transport::Publisher<msg::String>* const text_;
  transport::Publisher<msg::Bool>* const wake_up_;
};

}  // namespace musher::audio
