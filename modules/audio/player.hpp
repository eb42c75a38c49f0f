#pragma once
// The decision code of the audio module: what is played, in which order, and what each caller is
// answered. Pure: Step(rules, player, event, now) changes the player and returns the actions; the
// shell around it (audio_shell.hpp) turns messages into events and actions into sound and replies.
//
// clang-format off
//          requested                   made                      ended
//   silent ─────────▶ being made ─────────────▶ sounding ───────────────▶ the next that waits
//      ▲                  │                         │                     or silent
//      └──────────────────┴─────────────────────────┘
//        stopped, or interrupted by another sound
// clang-format on
//
// Rules:
//   - A request by topic interrupts what plays. The interrupted caller is answered with that code.
//     Waiting requests stay in the queue.
//   - A request by the service waits for its turn. It is answered at the end of its sound, or 10 s
//     after the request. A sound that has not begun by then is dropped; one that plays is
//     finished.
//   - A goal of the action waits like a request by the service, without a time limit. It is
//     answered at the end of its sound, and may be cancelled.
//   - A cue, a sound requested by name on a topic, interrupts or waits, as it or its topic is
//     configured; there is no reply. A cue that interrupts also drops the waiting cues of its
//     topic: they are outdated. An unknown cue is logged once.
//   - A stop ends what plays and drops all that waits.
//   - A refused request changes nothing that plays, and is answered with a code.
//   - The state of microphone and voice control is kept and answered; speech_input.hpp uses the
//     former.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/cues.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

inline constexpr Duration kAnswerTime = Milliseconds(10'000);  // from the request
inline constexpr Duration kReportPeriod = Milliseconds(500);
inline constexpr Duration kRefusalPause = Milliseconds(10'000);  // of the log, for the same text
inline constexpr std::size_t kMostWaiting = 16;
inline constexpr std::size_t kMostUnknownCues = 32;  // that are logged
inline constexpr int kFullVolume = 100;

// A request, which gets exactly one reply; the shell has its caller. 0: no caller.
using CallToken = std::uint64_t;
using SoundNumber = std::uint64_t;

// What the decision depends on; outlives the step.
struct PlayRules {
  const Phrases& phrases;
  Language language;         // of phrases, and of texts whose characters leave it open
  std::size_t longest_text;  // characters
  std::span<const CueTopic> cue_topics{};
};

struct PlayRequest {
  CallToken token = 0;  // 0: by a topic
  std::string module;   // the requesting module
  bool is_text = false;
  std::uint16_t play_id = 0;  // unless it is a text
  std::string text;
  bool is_goal = false;  // without a time limit

  friend bool operator==(const PlayRequest&, const PlayRequest&) = default;
};

namespace play_event {
struct PlayRequested {
  PlayRequest request;
};
struct CueRequested {
  std::size_t topic = 0;  // index into the rules' topics
  std::string id;
};
struct StopRequested {
  CallToken token = 0;
};
// The sound of one request is dropped.
struct CancelRequested {
  CallToken token = 0;
};
struct Made {
  SoundNumber number = 0;
  Result<> result;
};
struct Ended {
  SoundNumber number = 0;
  Result<> result;
};
struct VolumeRequested {
  CallToken token = 0;
  int volume = 0;
};
struct MicrophoneRequested {
  CallToken token = 0;
  int state = 0;  // msg::AudioStatus
};
struct VoiceControlRequested {
  CallToken token = 0;
  bool on = false;
};
// The machine goes to that state.
struct StateEntered {
  State state;
};
struct TimePassed {};
}  // namespace play_event

using PlayEvent = std::variant<play_event::PlayRequested, play_event::CueRequested,
                               play_event::StopRequested, play_event::CancelRequested,
                               play_event::Made, play_event::Ended, play_event::VolumeRequested,
                               play_event::MicrophoneRequested, play_event::VoiceControlRequested,
                               play_event::StateEntered, play_event::TimePassed>;

namespace play_action {
// Turn it into sound and report it by Made.
struct Make {
  SoundNumber number = 0;
  Utterance what;
  friend bool operator==(const Make&, const Make&) = default;
};
// Play the sound that was made, and report its end by Ended.
struct Play {
  SoundNumber number = 0;
  friend bool operator==(const Play&, const Play&) = default;
};
// Drop the sound that is being made or played.
struct Silence {
  friend bool operator==(const Silence&, const Silence&) = default;
};
struct SetVolume {
  int volume = 0;
  friend bool operator==(const SetVolume&, const SetVolume&) = default;
};
struct Answer {
  CallToken token = 0;
  std::int32_t code = 0;
  friend bool operator==(const Answer&, const Answer&) = default;
};
// Publish whether there is sound.
struct Report {
  bool sounds = false;
  friend bool operator==(const Report&, const Report&) = default;
};
struct Log {
  std::string text;
  friend bool operator==(const Log&, const Log&) = default;
};
}  // namespace play_action

using PlayAction =
    std::variant<play_action::Make, play_action::Play, play_action::Silence, play_action::SetVolume,
                 play_action::Answer, play_action::Report, play_action::Log>;
using PlayActions = std::vector<PlayAction>;

// The whole state. Start with `volume` from the config.
struct Player {
  struct Sound {
    SoundNumber number = 0;
    CallToken token = 0;                          // 0: no caller waits (any more)
    std::optional<Time> deadline = std::nullopt;  // of its reply, and of its beginning
    std::string module;
    Utterance what;
    bool sounding = false;
    std::optional<std::size_t> cue_topic = std::nullopt;  // that it was requested on

    friend bool operator==(const Sound&, const Sound&) = default;
  };

  std::optional<Sound> current;
  std::deque<Sound> waiting;
  SoundNumber last_number = 0;
  Time now{};  // of the last step
  bool reporting = false;
  Time next_report{};
  int volume = kFullVolume;
  bool microphone_off = false;
  bool voice_control = true;
  bool device_lost = false;            // and that is logged
  std::string refusal;                 // the last one that was logged …
  Time refusal_again{};                // … and when it may be logged again
  std::set<std::string> unknown_cues;  // those that were logged
  State state;

  friend bool operator==(const Player&, const Player&) = default;
};

PlayActions Step(const PlayRules& rules, Player& player, const PlayEvent& event, Time now);

// Whether the request would be accepted now, else the reason. With the step of a refused request
// the reason is logged, too.
Result<> CheckRequest(const PlayRules& rules, const Player& player, const PlayRequest& request);

// When the player needs the next TimePassed.
std::optional<Time> NextTime(const Player& player);

}  // namespace musher::audio
