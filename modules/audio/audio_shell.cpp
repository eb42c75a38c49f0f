#include "musher/modules/audio/audio_shell.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "musher/base/check.hpp"

namespace musher::audio {

AudioShell::AudioShell(const Dependencies& dependencies, const AudioConfig& config,
                       SoundMaker& maker, Output& output)
    : dependencies_(dependencies),
      rules_{config.phrases, config.language, config.longest_text, config.cue_topics},
      maker_(maker),
      output_(output),
      breaks_(dependencies.node.loop()),
      endpoints_(dependencies.node, dependencies.name_space) {
  player_.volume = config.volume;
  output_.SetVolume(config.volume);
  report_ = endpoints_.Advertise<msg::Bool>("audio_notification_report");
  OpenPlay();
  OpenAction();
  OpenCues();
  speech_input_ = std::make_unique<SpeechInput>(
      endpoints_, [this] { return Listens(); }, dependencies_.log);
  OpenSettings();
}

AudioShell::~AudioShell() {
  maker_.Cancel();
  output_.Stop();
}

Result<std::unique_ptr<AudioShell>> AudioShell::Make(const Dependencies& dependencies,
                                                     const AudioConfig& config, SoundMaker& maker,
                                                     Output& output) {
  std::unique_ptr<AudioShell> shell(new AudioShell(dependencies, config, maker, output));
  if (!shell->endpoints_.opened()) return shell->endpoints_.opened().error();
  return shell;
}

void AudioShell::OpenPlay() {
  endpoints_.Subscribe<msg::AudioPlay>("speech_play", [this](const msg::AudioPlay& m) {
    Take(play_event::PlayRequested{{0, m.module_name, false, m.play_id, {}}});
  });
  endpoints_.Subscribe<msg::AudioPlayExtend>(
      "speech_play_extend", [this](const msg::AudioPlayExtend& m) {
        Take(play_event::PlayRequested{{0, m.module_name, m.is_online, m.speech.play_id, m.text}});
      });
  endpoints_.Serve<msg::AudioTextPlay>("speech_text_play", [this](const auto& m, auto reply) {
    const CallToken token = Expect([reply](std::int32_t code) {
      const bool good = code == kCodeOk;
      reply({good ? msg::AudioTextPlay::kFinished : msg::AudioTextPlay::kFailed, code});
    });
    Take(play_event::PlayRequested{{token, m.module_name, m.is_online, m.speech.play_id, m.text}});
  });
  endpoints_.Serve<msg::EmptyService>("stop_play", [this](const auto&, auto reply) {
    Take(play_event::StopRequested{Expect([reply](std::int32_t) { reply({}); })});
  });
}

void AudioShell::OpenAction() {
  SpeechAction::Player player;
  player.may_play = [this](const PlayRequest& request) {
    return CheckRequest(rules_, player_, request).ok();
  };
  player.play = [this](PlayRequest request, AnswerCode on_end) {
    const CallToken token = Expect(std::move(on_end));
    request.token = token;
    Take(play_event::PlayRequested{std::move(request)});
    return token;
  };
  player.cancel = [this](CallToken token) { Take(play_event::CancelRequested{token}); };
  speech_action_ = std::make_unique<SpeechAction>(endpoints_, dependencies_.clock, player);
}

void AudioShell::OpenCues() {
  for (std::size_t i = 0; i < rules_.cue_topics.size(); ++i) {
    endpoints_.Subscribe<msg::String>(rules_.cue_topics[i].topic,
                                      [this, i](const msg::String& cue) {
                                        Take(play_event::CueRequested{i, cue.data});
                                      });
  }
}

void AudioShell::OpenSettings() {
  const auto code_reply = [](auto reply) {
    return [reply](std::int32_t code) { reply({code == kCodeOk, code}); };
  };
  endpoints_.Serve<msg::AudioVolumeSet>("audio_volume_set", [=, this](const auto& m, auto reply) {
    Take(play_event::VolumeRequested{Expect(code_reply(reply)), m.volume});
  });
  endpoints_.Serve<msg::AudioVolumeGet>("audio_volume_get", [this](const auto&, auto reply) {
    reply({static_cast<std::uint8_t>(player_.volume), kCodeOk});
  });
  endpoints_.Serve<msg::AudioExecute>("set_audio_state", [=, this](const auto& m, auto reply) {
    Take(play_event::MicrophoneRequested{Expect(code_reply(reply)), m.status.state});
  });
  endpoints_.Serve<msg::AudioExecute>("get_audio_state", [this](const auto&, auto reply) {
    reply({player_.microphone_off, kCodeOk});
  });
  endpoints_.Serve<msg::SetBool>("audio_action_set", [this](const auto& m, auto reply) {
    const CallToken token = Expect([reply](std::int32_t code) {
      reply({code == kCodeOk, AudioCodeText(code)});
    });
    Take(play_event::VoiceControlRequested{token, m.data});
  });
  endpoints_.Serve<msg::Trigger>("audio_action_get", [this](const auto&, auto reply) {
    reply({player_.voice_control, player_.voice_control ? "on" : "off"});
  });
  endpoints_.Serve<msg::SdcardPlayIdQuery>("sdcard_playid_query",
                                           [this](const auto& m, auto reply) {
                                             reply({rules_.phrases.Has(m.play_id), kCodeOk});
                                           });
}

// What waited while this process could not run was said long ago: the robot must not stand up by
// it.
bool AudioShell::Listens() {
  if (player_.microphone_off || player_.state == kTearDown) return false;
  const auto could_not_run = breaks_.Recent();
  if (could_not_run) {
    dependencies_.log("a recognised text is dropped: this process could not run for " +
                      std::to_string(ToMilliseconds(*could_not_run) / 1000) +
                      " s, and it may be as old; say it again");
  }
  return !could_not_run;
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
  speech_input_->SetSpeaking(action.sounds);
  if (player_.current && player_.current->sounding) {
    speech_action_->OnSounding(player_.current->token);
  }
}

void AudioShell::Do(const play_action::Log& action) {
  dependencies_.log(action.text);
}

}  // namespace musher::audio
