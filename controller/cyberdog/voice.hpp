#pragma once
// What the manager says and when: (state, what was heard, now) → what to play. Plain values, no
// clock, no IO; the shell is speaker.hpp.
//
//   heard ──▶ is it an occasion? ──▶ waiting ──(audio is there and free)──▶ playing ──▶ ended
//                                       └─(audio is not there for 10 s)──▶ dropped
//
// One thing is played at a time, by `speech_text_play`, whose answer is its end. A player that does
// not answer is waited for no longer than the deadline. Nothing is said twice: what the robot is
// (ready, low on battery) once each way, sentences not again within half a minute.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/lifecycle/coordinator.hpp"

namespace musher::cyberdog {

// A phrase by its number, or a sentence where `text` is not empty.
struct Utterance {
  std::uint16_t id = 0;
  std::string text;

  friend bool operator==(const Utterance&, const Utterance&) = default;
};

// What of the machine matters here.
struct Glimpse {
  struct Fault {
    std::string actuator;
    Error error;

    friend bool operator==(const Fault&, const Fault&) = default;
  };

  Phase phase = Phase::kIdle;
  State state;
  bool adopted = false;        // it ran when this controller began
  bool loaded = false;         // all stages are up
  std::optional<int> battery;  // in percent
  BatteryLevel level = BatteryLevel::kFree;
  bool charging = false;  // by cable
  bool battery_silent = false;
  std::vector<Fault> faults;  // of degraded actuators

  friend bool operator==(const Glimpse&, const Glimpse&) = default;
};
Glimpse GlimpseOf(const MachineConfig& config, const Machine& machine);

namespace heard {

struct MachineSeen {  // comes after the records of what has changed it
  Glimpse machine;
};
struct Recorded {
  action::Record record;
};
struct DoubleTapped {};
struct AppConnected {};
struct PlayerMatched {  // whether somebody serves `speech_text_play`
  bool there = false;
};
struct PlayReported {  // audio_notification_report: somebody's sound plays, or has ended
  bool playing = false;
};
struct PlayEnded {  // it answered, or the call came to nothing
  std::uint64_t number = 0;
};
struct TimePassed {};

}  // namespace heard

using Heard =
    std::variant<heard::MachineSeen, heard::Recorded, heard::DoubleTapped, heard::AppConnected,
                 heard::PlayerMatched, heard::PlayReported, heard::PlayEnded, heard::TimePassed>;

namespace voice_action {

struct Play {
  std::uint64_t number = 0;  // comes back in PlayEnded
  Utterance utterance;
  friend bool operator==(const Play&, const Play&) = default;
};
struct StandUp {  // motion 111, as the app would ask for it
  friend bool operator==(const StandUp&, const StandUp&) = default;
};
struct TellDropped {  // for the log: nobody plays, for the first time
  friend bool operator==(const TellDropped&, const TellDropped&) = default;
};

}  // namespace voice_action

using VoiceAction =
    std::variant<voice_action::Play, voice_action::StandUp, voice_action::TellDropped>;

// How long a phrase and a sentence are waited for once they are sent; the player itself gives up
// after 10 s.
inline constexpr Duration kPhraseTime = std::chrono::seconds(6);
inline constexpr Duration kSentenceTime = std::chrono::seconds(11);
// How long something waits: then it is said although others speak, or dropped where nobody plays.
inline constexpr Duration kVoicePatience = std::chrono::seconds(10);
// After the last report that something plays, which comes twice a second.
inline constexpr Duration kReportLasts = Milliseconds(800);
inline constexpr Duration kTapPause = Milliseconds(2000);
inline constexpr Duration kSameSentence = std::chrono::seconds(30);
inline constexpr std::size_t kMostWaiting = 8;  // the oldest is dropped

struct VoiceState {
  struct Waiting {
    Utterance utterance;
    Time until{};           // by then it is said or dropped
    bool stand_up = false;  // once it is said

    friend bool operator==(const Waiting&, const Waiting&) = default;
  };
  struct Sentence {
    std::string text;
    Time said{};

    friend bool operator==(const Sentence&, const Sentence&) = default;
  };

  Glimpse machine;
  Time now{};  // of the last step
  std::vector<Waiting> waiting;
  std::optional<Waiting> playing;  // until its deadline
  std::uint64_t number = 0;        // of the last one that was sent
  bool player = false;
  Time busy_until{};  // others are heard

  bool start_told = false;
  bool failure_told = false;
  bool loading_told = false;
  bool silence_told = false;
  bool greeted = false;  // the app
  int battery_told = 0;  // how urgent the last word was
  std::vector<Glimpse::Fault> faults_told;
  std::uint64_t switch_number = 0;  // of the last one that began …
  std::vector<std::int32_t> known;  // … and the codes of what was degraded then
  std::optional<Time> tapped;
  std::vector<Sentence> sentences;  // of the last half minute

  friend bool operator==(const VoiceState&, const VoiceState&) = default;
};

std::vector<VoiceAction> Speak(const MachineConfig& config, VoiceState& voice, const Heard& heard,
                               Time now);

// When to step next with TimePassed; nullopt: never.
std::optional<Time> NextVoiceDeadline(const VoiceState& voice);

}  // namespace musher::cyberdog
