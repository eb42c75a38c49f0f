#include "musher/modules/audio/player.hpp"

#include <algorithm>
#include <utility>

#include "musher/base/toml/findings.hpp"
#include "musher/messages/protocol/audio.hpp"

namespace musher::audio {
namespace {

class Decision {
 public:
  Decision(const PlayRules& rules, Player& player, Time now)
      : rules_(rules), player_(player), now_(now) {}

  PlayActions Run(const PlayEvent& event) && {
    Rebase();
    ReleaseOverdue(now_ - Duration(1));  // a sound that ends at its deadline is in time
    std::visit([this](const auto& e) { Take(e); }, event);
    ReleaseOverdue(now_);
    Advance();
    ReportIfDue();
    return std::move(actions_);
  }

  Result<> Check(const PlayRequest& request) const {
    if (IsStop(request)) return Ok();
    const Result<Utterance> what = UtteranceOf(request);
    return what ? Ok() : Result<>(what.error());
  }

 private:
  // Time started with the first /clock, or again because the world was restarted: remaining times
  // are kept.
  void Rebase() {
    const Duration jump = now_ - player_.now;
    if (jump < Duration::zero() || player_.now == Time{}) {
      const auto shift = [jump](Player::Sound& sound) {
        if (sound.deadline) *sound.deadline += jump;
      };
      if (player_.current) shift(*player_.current);
      for (Player::Sound& sound : player_.waiting) shift(sound);
      player_.next_report += jump;
      player_.refusal_again += jump;
    }
    player_.now = now_;
  }

  static bool IsStop(const PlayRequest& request) {
    return !request.is_text && request.play_id == msg::AudioPlay::kStop;
  }

  void Take(const play_event::PlayRequested& event) {
    const PlayRequest& request = event.request;
    if (IsStop(request)) {
      StopAll();
      return Answer(request.token, kCodeOk);
    }
    const Result<Utterance> what = UtteranceOf(request);
    if (!what) {
      return Refuse(request.token, {what.error().code, "for " + config_toml::Quote(request.module) +
                                                           ": " + what.error().message});
    }
    Player::Sound sound{++player_.last_number, request.token, std::nullopt,
                        request.module,        what.value(),  false};
    if (!request.is_goal) sound.deadline = now_ + kAnswerTime;
    Enqueue(std::move(sound), request.token == 0);
  }

  void Take(const play_event::CueRequested& event) {
    const CueTopic& topic = rules_.cue_topics[event.topic];
    const auto cue = topic.cues.find(event.id);
    if (cue == topic.cues.end()) return LogUnknown(topic, event.id);
    const bool interrupts = cue->second.interrupts.value_or(topic.interrupts);
    if (const Result<> may = MayPlay(!interrupts); !may) {
      return Refuse(0, {may.error().code,
                        "cue " + config_toml::Quote(event.id) + ": " + may.error().message});
    }
    if (interrupts) {
      std::erase_if(player_.waiting,
                    [&](const Player::Sound& sound) { return sound.cue_topic == event.topic; });
    }
    Enqueue({++player_.last_number, 0, now_ + kAnswerTime, event.id,
             cue->second.spoken.In(rules_.language), false, event.topic},
            interrupts);
  }

  void Take(const play_event::StopRequested& event) {
    StopAll();
    Answer(event.token, kCodeOk);
  }

  void Take(const play_event::CancelRequested& event) {
    if (event.token == 0) return;
    const auto requested = [&event](const Player::Sound& sound) {
      return sound.token == event.token;
    };
    const std::int32_t code = AudioCode(AudioKey::kStopped);
    if (player_.current && requested(*player_.current)) return EndCurrent(code);
    if (std::erase_if(player_.waiting, requested) > 0) Answer(event.token, code);
  }

  void Take(const play_event::Made& event) {
    if (!IsCurrent(event.number) || player_.current->sounding) return;
    if (!event.result) return Fail(event.result.error());
    player_.current->sounding = true;
    Do(play_action::Play{event.number});
    player_.next_report = player_.reporting ? std::min(player_.next_report, now_) : now_;
    player_.reporting = true;
    const Utterance& what = player_.current->what;
    Log("plays " + config_toml::Quote(what.text.empty() ? what.recording : what.text) + " for " +
        config_toml::Quote(player_.current->module));
  }

  void Take(const play_event::Ended& event) {
    if (!IsCurrent(event.number) || !player_.current->sounding) return;
    if (!event.result) return Fail(event.result.error());
    if (std::exchange(player_.device_lost, false)) Log("the sound device is available again");
    Answer(player_.current->token, kCodeOk);
    player_.current.reset();
  }

  void Take(const play_event::VolumeRequested& event) {
    if (event.volume < 0 || event.volume > kFullVolume) {
      return Refuse(event.token,
                    {AudioCode(KeyCode::kParametersInvalid),
                     "volume " + std::to_string(event.volume) + ": expected 0 to 100"});
    }
    player_.volume = event.volume;
    Do(play_action::SetVolume{event.volume});
    Answer(event.token, kCodeOk);
  }

  void Take(const play_event::MicrophoneRequested& event) {
    if (event.state != msg::AudioStatus::kNormal && event.state != msg::AudioStatus::kOffMic) {
      return Refuse(event.token, {AudioCode(KeyCode::kParametersInvalid),
                                  "unknown audio state " + std::to_string(event.state)});
    }
    player_.microphone_off = event.state == msg::AudioStatus::kOffMic;
    Answer(event.token, kCodeOk);
  }

  void Take(const play_event::VoiceControlRequested& event) {
    if (event.on && player_.state == kOta) {
      return Refuse(event.token,
                    {AudioCode(KeyCode::kStateInvalid), "voice control during an upgrade"});
    }
    player_.voice_control = event.on;
    Answer(event.token, kCodeOk);
  }

  void Take(const play_event::StateEntered& event) {
    player_.state = event.state;
    if (event.state == kOta) player_.voice_control = false;
    if (event.state == kTearDown) StopAll();
  }

  void Take(const play_event::TimePassed& /*event*/) {}

  Result<> MayPlay(bool waits) const {
    if (player_.state == kTearDown) {
      return Error{AudioCode(KeyCode::kStateInvalid), "the robot is being shut down"};
    }
    if (waits && player_.waiting.size() >= kMostWaiting) {
      return Error{AudioCode(KeyCode::kTargetBusy),
                   std::to_string(kMostWaiting) + " sounds are queued already"};
    }
    return Ok();
  }

  Result<Utterance> UtteranceOf(const PlayRequest& request) const {
    const bool waits = request.token != 0 || request.is_goal;
    if (const Result<> may = MayPlay(waits); !may) return may.error();
    return request.is_text ? EvaluateText(request.text) : EvaluatePhrase(request.play_id);
  }

  Result<Utterance> EvaluatePhrase(std::uint16_t id) const {
    if (auto phrase = rules_.phrases.Find(id, rules_.language)) return *std::move(phrase);
    return Error{AudioCode(AudioKey::kNoPhrase), "unknown phrase " + std::to_string(id)};
  }

  Result<Utterance> EvaluateText(const std::string& text) const {
    const auto characters = CharactersIn(text);
    if (!characters) return Error{AudioCode(AudioKey::kNotUtf8), "the text is not UTF-8"};
    if (!HasSomethingToSay(text)) {
      return Error{AudioCode(AudioKey::kNothingToSay), "the text is empty"};
    }
    if (*characters > rules_.longest_text) {
      return Error{AudioCode(AudioKey::kTextTooLong),
                   "the text has " + std::to_string(*characters) + " characters, the limit is " +
                       std::to_string(rules_.longest_text)};
    }
    return Utterance{Speakable(text), LanguageOf(text, rules_.language), {}};
  }

  void Enqueue(Player::Sound sound, bool interrupts) {
    if (!interrupts) return player_.waiting.push_back(std::move(sound));
    EndCurrent(AudioCode(AudioKey::kInterrupted));
    Begin(std::move(sound));
  }

  void Begin(Player::Sound sound) {
    Do(play_action::Make{sound.number, sound.what});
    player_.current = std::move(sound);
  }

  // Starts the next sound, unless one is being made or played.
  void Advance() {
    if (player_.current || player_.waiting.empty()) return;
    Player::Sound next = std::move(player_.waiting.front());
    player_.waiting.pop_front();
    Begin(std::move(next));
  }

  void EndCurrent(std::int32_t code) {
    if (!player_.current) return;
    Do(play_action::Silence{});
    Answer(player_.current->token, code);
    player_.current.reset();
  }

  void StopAll() {
    EndCurrent(AudioCode(AudioKey::kStopped));
    for (const Player::Sound& sound : player_.waiting) {
      Answer(sound.token, AudioCode(AudioKey::kStopped));
    }
    player_.waiting.clear();
  }

  // A lost device is logged once, until it is available again.
  void Fail(const Error& error) {
    const bool lost = error.code == AudioCode(KeyCode::kDeviceError);
    if (!lost || !std::exchange(player_.device_lost, true)) {
      Log(config_toml::Quote(player_.current->module) + " is not played: " + error.message);
    }
    Answer(player_.current->token, error.code);
    player_.current.reset();
  }

  // Releases the callers whose deadline is not later than `time`.
  void ReleaseOverdue(Time time) {
    const auto overdue = [time](const Player::Sound& sound) {
      return sound.deadline && *sound.deadline <= time;
    };
    const std::int32_t code = AudioCode(KeyCode::kTimeout);
    for (const Player::Sound& sound : player_.waiting) {
      if (!overdue(sound)) continue;
      Answer(sound.token, code);
      if (sound.token == 0)
        Log(config_toml::Quote(sound.module) + " was not played: timeout in the queue");
    }
    std::erase_if(player_.waiting, overdue);
    if (!player_.current || player_.current->token == 0 || !overdue(*player_.current)) return;
    if (!player_.current->sounding) return EndCurrent(code);
    Answer(std::exchange(player_.current->token, 0), code);
  }

  // Reports while there is sound, also between two sounds in a row, and once at the end.
  void ReportIfDue() {
    if (!player_.reporting) return;
    if (!player_.current) {
      player_.reporting = false;
      return Do(play_action::Report{false});
    }
    if (now_ < player_.next_report) return;
    Do(play_action::Report{true});
    player_.next_report = now_ + kReportPeriod;
  }

  bool IsCurrent(SoundNumber number) const {
    return player_.current && player_.current->number == number;
  }

  // Logged once, however often the request is repeated.
  void Refuse(CallToken token, const Error& error) {
    const std::string text = "refused " + error.message;
    if (text != player_.refusal || now_ >= player_.refusal_again) {
      Log(text);
      player_.refusal = text;
      player_.refusal_again = now_ + kRefusalPause;
    }
    Answer(token, error.code);
  }

  void LogUnknown(const CueTopic& topic, const std::string& id) {
    std::string text = topic.topic + " has no cue " + config_toml::Quote(id);
    if (player_.unknown_cues.size() == kMostUnknownCues) return;
    if (!player_.unknown_cues.insert(text).second) return;
    if (player_.unknown_cues.size() == kMostUnknownCues) text += "; further ones are not logged";
    Log(std::move(text));
  }

  void Answer(CallToken token, std::int32_t code) {
    if (token != 0) Do(play_action::Answer{token, code});
  }
  void Log(std::string text) { Do(play_action::Log{std::move(text)}); }
  void Do(PlayAction action) { actions_.push_back(std::move(action)); }

  const PlayRules& rules_;
  Player& player_;
  const Time now_;
  PlayActions actions_;
};

}  // namespace

PlayActions Step(const PlayRules& rules, Player& player, const PlayEvent& event, Time now) {
  return Decision(rules, player, now).Run(event);
}

Result<> CheckRequest(const PlayRules& rules, const Player& player, const PlayRequest& request) {
  Player copy = player;
  return Decision(rules, copy, player.now).Check(request);
}

std::optional<Time> NextTime(const Player& player) {
  std::optional<Time> next;
  const auto consider = [&next](Time time) { next = next ? std::min(*next, time) : time; };
  if (player.reporting) consider(player.next_report);
  const auto consider_deadline = [&](const Player::Sound& sound) {
    if (sound.deadline) consider(*sound.deadline);
  };
  if (player.current && player.current->token != 0) consider_deadline(*player.current);
  for (const Player::Sound& sound : player.waiting) consider_deadline(sound);
  return next;
}

}  // namespace musher::audio
