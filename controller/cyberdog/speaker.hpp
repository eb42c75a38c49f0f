#pragma once
// The manager's voice on the wire: what it hears (the machine, `touch_status`,
// `app_connection_state`, `audio_notification_report`) goes to the decision in voice.hpp, what that
// wants said to `speech_text_play`. Nothing waits for it.
//
// Its times follow the policy's clock. A call ends by the steady one, too, for a world that stands
// still.
//
// Threads: loop thread only.

#include <memory>
#include <optional>

#include "musher/controller/controller_shell.hpp"
#include "musher/controller/cyberdog/voice.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Speaker {
 public:
  // Null where nothing is to be said. Both must outlive it.
  static Result<std::unique_ptr<Speaker>> Make(transport::Endpoints& endpoints,
                                               ControllerShell& shell);

  // To be told of every record of the shell.
  void OnRecord(const action::Record& record);

 private:
  explicit Speaker(ControllerShell& shell) : shell_(shell) {}
  Result<> Open(transport::Endpoints& endpoints);

  void Hear(const Heard& heard);
  void Look();
  void Arm();
  void Do(const voice_action::Play& play);
  void Do(const voice_action::StandUp& stand_up);
  void Do(const voice_action::TellDropped& dropped);

  ControllerShell& shell_;
  VoiceState voice_;
  transport::Client<msg::AudioTextPlay>* player_ = nullptr;
  transport::Client<msg::MotionResultCmd>* motion_ = nullptr;
  std::unique_ptr<transport::Clock> clock_;
  transport::EventLoop* loop_ = nullptr;
  transport::LoopHandlePtr first_time_;  // of a world that had not been heard yet
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  transport::LoopHandlePtr look_soon_;
  transport::LoopHandlePtr look_;
};

}  // namespace musher::cyberdog
