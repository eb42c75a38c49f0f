#pragma once
// The action speech_text_action: a goal is a text or a phrase, which waits for its turn in the
// queue. The goal is accepted while it waits, executing while it sounds, with feedback, and ends
// with its sound. A goal that cannot be played is rejected.
//
// Threads: the loop's.

#include <cstdint>
#include <functional>
#include <map>

#include "musher/messages/protocol/speech.hpp"
#include "musher/modules/audio/player.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::audio {

class SpeechAction {
 public:
  struct Player {
    // Whether a request would be accepted now.
    std::function<bool(const PlayRequest&)> may_play;
    // Requests a sound; `on_end` runs once, with the code of its end, also inside play(): then it
    // was refused, or done at once.
    std::function<CallToken(PlayRequest, std::function<void(std::int32_t code)> on_end)> play;
    // Drops the sound of that request, which then ends.
    std::function<void(CallToken)> cancel;
  };

  SpeechAction(transport::Endpoints& endpoints, transport::Clock& clock, Player player);

  // The sound of that request is audible; called again while it is.
  void OnSounding(CallToken token);

 private:
  using Goal = transport::ServerGoal<msg::Speech>;

  // A goal that was passed to the player.
  struct Requested {
    Goal goal;
    CallToken token = 0;
  };
  using Number = std::uint64_t;

  bool Accept(const msg::Speech::Goal& goal);
  void Start(const Goal& goal);
  void Cancel(const Goal& goal);
  void OnEnd(Number number, std::int32_t code);

  const Player player_;
  Number last_ = 0;
  std::map<Number, Requested> goals_;  // until they end
};

}  // namespace musher::audio
