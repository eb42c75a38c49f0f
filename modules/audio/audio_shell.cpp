#include "musher/modules/audio/audio_shell.hpp"

#include <utility>

#include "musher/base/check.hpp"

namespace musher::audio {

AudioShell::AudioShell(const Dependencies& dependencies, const AudioConfig& config,
                       SoundMaker& maker, Output& output)
    : dependencies_(dependencies),
      rules_{config.phrases, config.language, config.longest_text, config.cue_topics},
      maker_(maker),
      output_(output) {
  player_.volume = config.volume;
  output_.SetVolume(config.volume);
}

AudioShell::~AudioShell() {
  maker_.Cancel();
  output_.Stop();
}

Result<std::unique_ptr<AudioShell>> AudioShell::Make(const Dependencies& dependencies,
                                                     const AudioConfig& config, SoundMaker& maker,
                                                     Output& output) {
  std::unique_ptr<AudioShell> shell(new AudioShell(dependencies, config, maker, output));
  if (Result<> connected = shell->Connect(); !connected) return connected.error();
  return shell;
}

Result<> AudioShell::Connect() {
  auto report = transport::MakePublisher<msg::Bool>(
      dependencies_.node, dependencies_.Name("audio_notification_report"));
  if (!report) return report.error();
  report_ = std::move(report).value();
  if (Result<> connected = ConnectPlay(); !connected) return connected;
  if (Result<> connected = ConnectCues(); !connected) return connected;
  auto listening = Listening::Make(
      dependencies_.node, dependencies_.name_space,
      [this] { return !player_.microphone_off && player_.state != kTearDown; }, dependencies_.log);
  if (!listening) return listening.error();
  listening_ = std::move(listening).value();
  return ConnectSettings();
}

Result<> AudioShell::ConnectPlay() {
  auto play = transport::MakeSubscription<msg::AudioPlay>(
      dependencies_.node, dependencies_.Name("speech_play"),
      [this](const msg::AudioPlay& m, const auto&) {
        Take(play_event::PlayRequested{{0, m.module_name, false, m.play_id, {}}});
      });
  if (!play) return play.error();
  subscriptions_.push_back(std::move(play).value());
  auto extended = transport::MakeSubscription<msg::AudioPlayExtend>(
      dependencies_.node, dependencies_.Name("speech_play_extend"),
      [this](const msg::AudioPlayExtend& m, const auto&) {
        Take(play_event::PlayRequested{{0, m.module_name, m.is_online, m.speech.play_id, m.text}});
      });
  if (!extended) return extended.error();
  subscriptions_.push_back(std::move(extended).value());
  Result<> served = Serve<
      msg::AudioTextPlay>("speech_text_play", [this](const msg::AudioTextPlay::Request& m,
                                                     auto reply) {
    const CallToken token = Expect([reply](std::int32_t code) {
      const bool good = code == kCodeOk;
      reply({good ? msg::AudioTextPlay::kFinished : msg::AudioTextPlay::kFailed, code});
    });
    Take(play_event::PlayRequested{{token, m.module_name, m.is_online, m.speech.play_id, m.text}});
  });
  if (!served) return served;
  return Serve<msg::EmptyService>("stop_play", [this](const msg::Empty&, auto reply) {
    Take(play_event::StopRequested{Expect([reply](std::int32_t) { reply({}); })});
  });
}

Result<> AudioShell::ConnectCues() {
  for (std::size_t i = 0; i < rules_.cue_topics.size(); ++i) {
    auto cues = transport::MakeSubscription<msg::String>(
        dependencies_.node, dependencies_.Name(rules_.cue_topics[i].topic),
        [this, i](const msg::String& cue, const auto&) {
          Take(play_event::CueRequested{i, cue.data});
        });
    if (!cues) return cues.error();
    subscriptions_.push_back(std::move(cues).value());
  }
  return Ok();
}

Result<> AudioShell::ConnectSettings() {
  const auto code_reply = [](auto reply) {
    return [reply](std::int32_t code) { reply({code == kCodeOk, code}); };
  };
  for (const Result<>&served :
       {Serve<msg::AudioVolumeSet>(
            "audio_volume_set",
            [=, this](const auto&m, auto reply) {
              Take(play_event::VolumeRequested{Expect(code_reply(reply)), m.volume});
            }),
        Serve<msg::AudioVolumeGet>("audio_volume_get",
                                   [this](const auto&, auto reply) {
                                     reply({static_cast<std::uint8_t>(player_.volume), kCodeOk});
                                   }),
        Serve<msg::AudioExecute>(
            "set_audio_state",
            [=, this](const auto&m, auto reply) {
              Take(play_event::MicrophoneRequested{Expect(code_reply(reply)), m.status.state});
            }),
        Serve<msg::AudioExecute>("get_audio_state",
                                 [this](const auto&, auto reply) {
                                   reply({player_.microphone_off, kCodeOk});
                                 }),
        Serve<msg::SetBool>("audio_action_set",
                            [this](const auto&m, auto reply) {
                              const CallToken token = Expect([reply](std::int32_t code) {
                                reply({code == kCodeOk, AudioCodeText(code)});
                              });
                              Take(play_event::VoiceControlRequested{token, m.data});
                            }),
        Serve<msg::Trigger>("audio_action_get",
                            [this](const auto&, auto reply) {
                              reply({player_.voice_control, player_.voice_control ? "on" : "off"});
                            }),
        Serve<msg::SdcardPlayIdQuery>("sdcard_playid_query", [this](const auto&m, auto reply) {
          reply({rules_.phrases.Has(m.play_id), kCodeOk});
        })}) {
    if (!served) return served;
  }
  return Ok();
}

template <msg::Service S>
Result<> AudioShell::Serve(const char* name, typename transport::Server<S>::Handler handler) {
  auto server =
      transport::MakeServer<S>(dependencies_.node, dependencies_.Name(name), std::move(handler));
  if (!server) return server.error();
  servers_.push_back(std::move(server).value());
  return Ok();
}

CallToken AudioShell::Expect(AnswerCode answer) {
  calls_.emplace(++last_token_, std::move(answer));
  return last_token_;
}

void AudioShell::Take(const PlayEvent& event) {
  for (const PlayAction& action : Step(rules_, player_, event, dependencies_.clock.Now())) {
    std::visit([this](const auto& a) { Do(a); }, action);
  }
  timer_.reset();
  if (const auto next = NextTime(player_)) {
    timer_ = dependencies_.clock.At(*next, [this] { Take(play_event::TimePassed{}); });
  }
}

void AudioShell::Do(const play_action::Make& action) {
  maker_.Make(action.what, [this, number = action.number](Result<Sound> sound) {
    Result<> result;
    if (sound) {
      made_ = std::make_shared<const Sound>(std::move(sound).value());
    } else {
      result = sound.error();
    }
    Take(play_event::Made{number, result});
  });
}

void AudioShell::Do(const play_action::Play& action) {
  output_.Play(std::exchange(made_, nullptr), [this, number = action.number](Result<> result) {
    Take(play_event::Ended{number, std::move(result)});
  });
}

void AudioShell::Do(const play_action::Silence& /*action*/) {
  maker_.Cancel();
  output_.Stop();
}

void AudioShell::Do(const play_action::SetVolume& action) {
  output_.SetVolume(action.volume);
}

void AudioShell::Do(const play_action::Answer& action) {
  const auto call = calls_.extract(action.token);
  MUSHER_CHECK(!call.empty());
  call.mapped()(action.code);
}

void AudioShell::Do(const play_action::Report& action) {
  static_cast<void>(report_->Publish({action.sounds}));  // the next one follows
  listening_->SetSpeaking(action.sounds);
}

void AudioShell::Do(const play_action::Log& action) {
  dependencies_.log(action.text);
}

}  // namespace musher::audio
