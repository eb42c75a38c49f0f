#pragma once
// The decision code of the audio module: what is heard, in which order, and what everybody is
// answered. Pure: Step(rules, player, event, now) changes the player and gives the actions; the
// shell around it (audio_shell.hpp) turns messages into events and actions into sound and answers.
//
// clang-format off
//            asked                    made                      ended
//   silent ─────────▶ being made ─────────────▶ sounding ───────────────▶ the next that waits
//      ▲                  │                         │                     or silent
//      └──────────────────┴─────────────────────────┘
//        stopped, or another sound takes its place
// clang-format on
//
// Rules:
//   - What is asked by a topic takes the place of whatever plays. Who is interrupted is answered
//     so. Those that wait go on waiting.
//   - What is asked by the service waits for its turn. It is answered at the end of its sound, or
//     when its time is over: 10 s from the moment it was asked. What has not begun by then never
//     is; what sounds goes on to its end.
//   - A cue, a sound asked for by its name on a topic, does the one or the other, as it or its
//     topic is configured; nobody is answered. One that interrupts also takes the place of those of
//     its topic that wait: they belong to what is over. One that is not known is told in the log,
//     once.
//   - A stop ends what plays and all that waits.
//   - Whatever is refused changes nothing that plays, and is told why, with a code.
//   - The microphone and the voice control are kept and told; listening.hpp asks for the first.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/state.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/cues.hpp"
#include "musher/modules/audio/phrases.hpp"

namespace musher::audio {

inline constexpr Duration kAnswerTime = Milliseconds(10'000);  // from the request
inline constexpr Duration kReportPeriod = Milliseconds(500);
inline constexpr Duration kRefusalPause = Milliseconds(10'000);  // of the log, for the same words
inline constexpr std::size_t kMostWaiting = 16;
inline constexpr std::size_t kMostUnknownCues = 32;  // that are told
inline constexpr int kFullVolume = 100;

// A request that must be answered exactly once; the shell knows to whom. 0: nobody waits.
using CallToken = std::uint64_t;
using SoundNumber = std::uint64_t;

// What the decision goes by; outlives the step.
struct PlayRules {
  const Phrases& phrases;
  Language language;         // of phrases, and of texts whose characters do not tell
  std::size_t longest_text;  // characters
  std::span<const CueTopic> cue_topics{};
};

struct PlayOrder {
  CallToken token = 0;  // 0: by a topic
  std::string module;   // who asks
  bool is_text = false;
  std::uint16_t play_id = 0;  // unless it is a text
  std::string text;

  friend bool operator==(const PlayOrder&, const PlayOrder&) = default;
};

namespace play_event {
struct Asked {
  PlayOrder order;
};
struct CueAsked {
  std::size_t topic = 0;  // which of the rules'
  std::string id;
};
struct StopAsked {
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
struct VolumeAsked {
  CallToken token = 0;
  int volume = 0;
};
struct MicrophoneAsked {
  CallToken token = 0;
  int state = 0;  // msg::AudioStatus
};
struct VoiceControlAsked {
  CallToken token = 0;
  bool on = false;
};
// The machine goes to that state.
struct StateEntered {
  State state;
};
struct TimePassed {};
}  // namespace play_event

using PlayEvent =
    std::variant<play_event::Asked, play_event::CueAsked, play_event::StopAsked, play_event::Made,
                 play_event::Ended, play_event::VolumeAsked, play_event::MicrophoneAsked,
                 play_event::VoiceControlAsked, play_event::StateEntered, play_event::TimePassed>;

namespace play_action {
// Turn it into sound and say so by Made.
struct Make {
  SoundNumber number = 0;
  Utterance what;
  friend bool operator==(const Make&, const Make&) = default;
};
// Play what was made, and say its end by Ended.
struct Play {
  SoundNumber number = 0;
  friend bool operator==(const Play&, const Play&) = default;
};
// Forget what is made or played.
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
// Whether there is sound.
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
    CallToken token = 0;  // 0: nobody waits (any more)
    Time deadline{};      // of its answer, and of its beginning
    std::string module;
    Utterance what;
    bool sounding = false;
    std::optional<std::size_t> cue_topic = std::nullopt;  // that asked for it

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
  bool device_lost = false;            // and that is told
  std::string refusal;                 // the last one that was said …
  Time refusal_again{};                // … and when it may be again
  std::set<std::string> unknown_cues;  // what was said of them
  State state;

  friend bool operator==(const Player&, const Player&) = default;
};

PlayActions Step(const PlayRules& rules, Player& player, const PlayEvent& event, Time now);

// When the player wants to hear that time has passed.
std::optional<Time> NextTime(const Player& player);

}  // namespace musher::audio
