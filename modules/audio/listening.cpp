#include "musher/modules/audio/listening.hpp"

#include <utility>

#include "musher/modules/audio/audio_code.hpp"
#include "musher/modules/audio/speech_text.hpp"

namespace musher::audio {
namespace {

Result<> CheckName(const std::string& what, const std::string& name) {
  const bool good = !name.empty() && name.size() <= Listening::kLongestName && CharactersIn(name) &&
                    HasSomethingToSay(name);
  if (good) return Ok();
  return Error{
      AudioCode(KeyCode::kParametersInvalid),
      what + " must be UTF-8 of 1 to " + std::to_string(Listening::kLongestName) + " bytes"};
}

}  // namespace

Result<std::unique_ptr<Listening>> Listening::Make(transport::Node& node,
                                                   const std::string& name_space,
                                                   std::function<bool()> microphone_on, Log log) {
  std::unique_ptr<Listening> listening(new Listening(std::move(microphone_on), std::move(log)));
  if (Result<> connected = listening->Connect(node, name_space); !connected) {
    return connected.error();
  }
  return listening;
}

Result<> Listening::Connect(transport::Node& node, const std::string& name_space) {
  const auto resolved = [&](const char* name) { return transport::ResolveName(name_space, name); };
  Result<> connected;
  const auto keep = [&](auto made, auto& kept) {
    if (made) {
      kept = std::move(made).value();
    } else {
      connected = made.error();
    }
  };
  const auto serve = [&](auto made) {
    std::shared_ptr<void> server;
    keep(std::move(made), server);
    servers_.push_back(std::move(server));
  };
  keep(transport::MakePublisher<msg::UInt8>(node, resolved("audio_board_state")), board_);
  keep(transport::MakePublisher<msg::String>(node, resolved("asr_text")), text_);
  keep(transport::MakePublisher<msg::Bool>(node, resolved("dog_wakeup")), wake_up_);
  keep(transport::MakeSubscription<msg::String>(
           node, resolved("world/speech_text"),
           [this](const msg::String& text, const auto&) { OnText(text.data); }),
       recognised_);
  serve(transport::MakeServer<msg::AudioNickName>(
      node, resolved("set_nick_name"), [this](const auto& names, auto reply) {
        const Result<> done = SetNames(names);
        if (!done) log_("set_nick_name refused: " + done.error().message);
        reply({done.ok(), done ? kCodeOk : done.error().code});
      }));
  serve(transport::MakeServer<msg::SetBool>(node, resolved("nick_name_switch"),
                                            [this](const msg::SetBool::Request& on, auto reply) {
                                              own_name_ = on.data;
                                              reply({true, own_name_ ? wake_name_ : kWakeName});
                                            }));
  // The app queries whether the voice is activated with the manufacturer's account.
  serve(transport::MakeServer<msg::ProtocolTrigger>(
      node, resolved("audio_active_state"), [](const auto&, auto reply) {
        reply({false, "the voice needs no account, and has none", AudioCode(KeyCode::kUnSupport)});
      }));
  return connected;
}

void Listening::SetSpeaking(bool speaking) {
  if (std::exchange(speaking_, speaking) == speaking) return;
  Publish(speaking ? BoardState::kSpeaking : BoardState::kSaid);
}

void Listening::Publish(BoardState state) {
  static_cast<void>(board_->Publish({static_cast<std::uint8_t>(state)}));
}

void Listening::OnText(const std::string& text) {
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

Result<> Listening::SetNames(const msg::AudioNickName::Request& names) {
  if (Result<> good = CheckName("nick_name", names.nick_name); !good) return good;
  if (Result<> good = CheckName("wake_name", names.wake_name); !good) return good;
  nick_name_ = names.nick_name;
  wake_name_ = names.wake_name;
  log_("the robot is called " + nick_name_ + ", its wake word is " + wake_name_);
  return Ok();
}

}  // namespace musher::audio
