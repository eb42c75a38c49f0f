#include "musher/modules/audio/speech_input.hpp"

#include <utility>

#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/speech_text.hpp"

namespace musher::audio {
namespace {

Result<> CheckName(const std::string& what, const std::string& name) {
  const bool good = !name.empty() && name.size() <= SpeechInput::kLongestName &&
                    CharactersIn(name) && HasSomethingToSay(name);
  if (good) return Ok();
  return Error{
      AudioCode(KeyCode::kParametersInvalid),
      what + " must be UTF-8 of 1 to " + std::to_string(SpeechInput::kLongestName) + " bytes"};
}

}  // namespace

SpeechInput::SpeechInput(transport::Endpoints& endpoints, std::function<bool()> microphone_on,
                         Log log)
    : microphone_on_(std::move(microphone_on)),
      log_(std::move(log)),
      board_(endpoints.Advertise<msg::UInt8>("audio_board_state")),
      text_(endpoints.Advertise<msg::String>("asr_text")),
      wake_up_(endpoints.Advertise<msg::Bool>("dog_wakeup")) {
  endpoints.Subscribe<msg::String>("world/speech_text",
                                   [this](const msg::String& text) { OnText(text.data); });
  endpoints.Serve<msg::AudioNickName>("set_nick_name", [this](const auto& names, auto reply) {
    const Result<> done = SetNames(names);
    if (!done) log_("set_nick_name refused: " + done.error().message);
    reply({done.ok(), done ? kCodeOk : done.error().code});
  });
  endpoints.Serve<msg::SetBool>("nick_name_switch", [this](const auto& on, auto reply) {
    own_name_ = on.data;
    reply({true, own_name_ ? wake_name_ : kWakeName});
  });
  // The app queries whether the voice is activated with the manufacturer's account.
  endpoints.Serve<msg::ProtocolTrigger>("audio_active_state", [](const auto&, auto reply) {
    reply({false, "the voice needs no account, and has none", AudioCode(KeyCode::kUnSupport)});
  });
}

void SpeechInput::SetSpeaking(bool speaking) {
  if (std::exchange(speaking_, speaking) == speaking) return;
  Publish(speaking ? BoardState::kSpeaking : BoardState::kSaid);
}

void SpeechInput::Publish(BoardState state) {
  static_cast<void>(board_->Publish({static_cast<std::uint8_t>(state)}));
}

void SpeechInput::OnText(const std::string& text) {
  if (!microphone_on_()) return;
  if (text.empty()) return;  // many recognisers send an empty text for silence
  const bool bad = text.size() > kLongestText || !CharactersIn(text) || !HasSomethingToSay(text);
  if (std::exchange(refusing_, bad) != bad && bad) {
    log_("world/speech_text: refused: expected UTF-8 of 1 to " + std::to_string(kLongestText) +
         " bytes");
  }
  if (bad) return;
  Publish(BoardState::kRecognised);
  static_cast<void>(text_->Publish({text}));
  const std::string wake_name = own_name_ ? wake_name_ : kWakeName;
  if (text.find(wake_name) != std::string::npos) static_cast<void>(wake_up_->Publish({true}));
}

Result<> SpeechInput::SetNames(const msg::AudioNickName::Request& names) {
  if (Result<> good = CheckName("nick_name", names.nick_name); !good) return good;
  if (Result<> good = CheckName("wake_name", names.wake_name); !good) return good;
  nick_name_ = names.nick_name;
  wake_name_ = names.wake_name;
  log_("the robot is called " + nick_name_ + ", its wake word is " + wake_name_);
  return Ok();
}

}  // namespace musher::audio
