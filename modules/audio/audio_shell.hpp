#pragma once
// The audio module on its topics and services: turns messages into the player's events, and the
// player's actions into sound and replies. Runs on any transport.
//
// Threads: the loop's.

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/std_msgs/basic.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/messages/std_srvs/empty.hpp"
#include "musher/messages/std_srvs/set_bool.hpp"
#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/modules/audio/output.hpp"
#include "musher/modules/audio/player.hpp"
#include "musher/modules/audio/sound_maker.hpp"
#include "musher/modules/audio/speech_action.hpp"
#include "musher/modules/audio/speech_input.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"

namespace musher::audio {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;  // of the module's behaviour
  std::string name_space;
  std::function<void(const std::string&)> log;  // one line, without its end
};

class AudioShell {
 public:
  // All arguments outlive the shell.
  static Result<std::unique_ptr<AudioShell>> Make(const Dependencies& dependencies,
                                                  const AudioConfig& config, SoundMaker& maker,
                                                  Output& output);
  ~AudioShell();

  // The machine goes to that state.
  void Enter(const State& state) { Take(play_event::StateEntered{state}); }
  // The clock went back.
  void OnTimeJumped() { Take(play_event::TimePassed{}); }

 private:
  using AnswerCode = std::function<void(std::int32_t code)>;

  AudioShell(const Dependencies& dependencies, const AudioConfig& config, SoundMaker& maker,
             Output& output);
  void OpenPlay();
  void OpenAction();
  void OpenCues();
  void OpenSettings();

  // Whether what was recognised counts now; logs where it is dropped.
  bool Listens();
  CallToken Expect(AnswerCode answer);
  void Take(const PlayEvent& event);
  void Do(const play_action::Make& action);
  void Do(const play_action::Play& action);
  void Do(const play_action::Silence& action);
  void Do(const play_action::SetVolume& action);
  void Do(const play_action::Answer& action);
  void Do(const play_action::Report& action);
  void Do(const play_action::Log& action);

  const Dependencies dependencies_;
  const PlayRules rules_;
  SoundMaker& maker_;
  Output& output_;
  Player player_;
  std::shared_ptr<const Sound> made_;
  CallToken last_token_ = 0;
  std::map<CallToken, AnswerCode> calls_;
  transport::LoopHandlePtr timer_;
  transport::LoopBreaks breaks_;
  transport::Publisher<msg::Bool>* report_ = nullptr;
  std::unique_ptr<SpeechInput> speech_input_;
  std::unique_ptr<SpeechAction> speech_action_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::audio
