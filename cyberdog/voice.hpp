#pragma once
// Decides the manager's phrases and their times: (state, event, now) → what to play. Plain values,
// no clock, no I/O; the shell is speaker.hpp.
//
//   event ──▶ is it an occasion? ──▶ waiting ──(audio available and free)──▶ playing ──▶ ended
//                                       └─(audio not available for 10 s)──▶ dropped
//
// Plays one utterance at a time, with `speech_text_play`, whose reply is its end. Waits for a
// player that does not reply only until the deadline. Nothing is repeated: states of the robot
// (ready, low battery) are announced once per change, sentences not again within 30 s.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/coordinator/coordinator.hpp"

namespace musher::cyberdog {

// A phrase by its number, or a sentence if `text` is not empty.
struct Utterance {
  std::uint16_t id = 0;
  std::string text;

  friend bool operator==(const Utterance&, const Utterance&) = default;
};

// The part of the machine that matters here.
struct MachineSummary {
  struct Fault {
    std::string actuator;
    Error error;

    friend bool operator==(const Fault&, const Fault&) = default;
  };

  Phase phase = Phase::kIdle;
  State state;
  bool adopted = false;        // it already ran when this controller began
  bool loaded = false;         // all stages are up
  std::optional<int> battery;  // in percent
  BatteryLevel level = BatteryLevel::kFree;
  bool empty = false;     // samples in a row have confirmed that the battery is empty
  bool charging = false;  // by cable
  bool battery_silent = false;
  bool stopped = false;       // by an emergency stop
  std::vector<Fault> faults;  // of degraded actuators

  friend bool operator==(const MachineSummary&, const MachineSummary&) = default;
};
MachineSummary SummaryOf(const MachineConfig& config, const Machine& machine);

namespace voice_event {

struct MachineSeen {  // follows the records of its changes
  MachineSummary machine;
};
struct Recorded {
  action::Record record;
};
struct DoubleTapped {};
struct AppConnected {};
struct PlayerMatched {  // whether a server of `speech_text_play` is matched
  bool available = false;
};
struct PlayReported {  // audio_notification_report: a sound of any client plays, or has ended
  bool playing = false;
};
struct PlayEnded {  // the reply, or the call failed
  std::uint64_t number = 0;
};
struct TimePassed {};

}  // namespace voice_event

using VoiceEvent =
    std::variant<voice_event::MachineSeen, voice_event::Recorded, voice_event::DoubleTapped,
                 voice_event::AppConnected, voice_event::PlayerMatched, voice_event::PlayReported,
                 voice_event::PlayEnded, voice_event::TimePassed>;

namespace voice_action {

struct Play {
  std::uint64_t number = 0;  // returned in PlayEnded
  Utterance utterance;
  friend bool operator==(const Play&, const Play&) = default;
};
struct StandUp {  // motion 111, as the app would request it
  friend bool operator==(const StandUp&, const StandUp&) = default;
};
struct LogDropped {  // log once that no player is available
  friend bool operator==(const LogDropped&, const LogDropped&) = default;
};

}  // namespace voice_action

using VoiceAction =
    std::variant<voice_action::Play, voice_action::StandUp, voice_action::LogDropped>;

// Timeouts for a phrase and a sentence once they are sent; the player's own limit is 10 s.
inline constexpr Duration kPhraseTime = std::chrono::seconds(6);
inline constexpr Duration kSentenceTime = std::chrono::seconds(11);
// How long an utterance waits: then it is played although other sounds play, or dropped without a
// player.
inline constexpr Duration kVoiceTimeout = std::chrono::seconds(10);
// How long a report that a sound plays is valid; it comes twice a second.
inline constexpr Duration kReportLasts = Milliseconds(800);
inline constexpr Duration kTapPause = Milliseconds(2000);
inline constexpr Duration kSameSentence = std::chrono::seconds(30);
inline constexpr std::size_t kMostWaiting = 8;  // the oldest is dropped

struct VoiceState {
  struct WaitingUtterance {
    Utterance utterance;
    Time until{};           // by then it is played or dropped
    bool stand_up = false;  // after it was played

    friend bool operator==(const WaitingUtterance&, const WaitingUtterance&) = default;
  };
  struct Sentence {
    std::string text;
    Time said{};

    friend bool operator==(const Sentence&, const Sentence&) = default;
  };

  MachineSummary machine;
  Time now{};  // of the last step
  std::vector<WaitingUtterance> waiting;
  std::optional<WaitingUtterance> playing;  // until its deadline
  std::uint64_t number = 0;                 // of the last one sent
  bool player = false;
  Time busy_until{};  // other sounds play

  bool start_announced = false;
  bool failure_announced = false;
  bool loading_announced = false;
  bool silence_announced = false;
  bool greeted = false;       // the app
  int battery_announced = 0;  // urgency of the last announcement
  std::vector<MachineSummary::Fault> faults_announced;
  CommandNumber switch_number = 0;  // of the last switch that began …
  std::vector<std::int32_t> known;  // … and the codes of the actuators degraded then
  std::optional<Time> tapped;
  std::vector<Sentence> sentences;  // of the last 30 s

  friend bool operator==(const VoiceState&, const VoiceState&) = default;
};

std::vector<VoiceAction> Speak(const MachineConfig& config, VoiceState& voice,
                               const VoiceEvent& event, Time now);

// When to step next with TimePassed; nullopt: never.
std::optional<Time> NextVoiceDeadline(const VoiceState& voice);

}  // namespace musher::cyberdog
