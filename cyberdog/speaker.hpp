#pragma once
// The I/O of the manager's voice: its inputs (the machine, `touch_status`, `app_connection_state`,
// `audio_notification_report`) go to the decision in voice.hpp, its utterances to
// `speech_text_play`. Nothing waits for it.
//
// Its times follow the policy's clock. A call also has a timeout on the steady clock, in case the
// world stands still.
//
// Threads: loop thread only.

#include <memory>
#include <optional>

#include "musher/controller/shell/controller_shell.hpp"
#include "musher/cyberdog/voice.hpp"
#include "musher/messages/protocol/audio.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"

namespace musher::cyberdog {

class Speaker {
 public:
  // Null without [policy] voice. Both must outlive it.
  static Result<std::unique_ptr<Speaker>> Make(transport::Endpoints& endpoints,
                                               ControllerShell& shell);

  // Call for every record of the shell.
  void OnRecord(const action::Record& record);

 private:
  explicit Speaker(ControllerShell& shell) : shell_(shell) {}
  Result<> Open(transport::Endpoints& endpoints);

  void Handle(const VoiceEvent& event);
  void Look();
  void Arm();
  void Do(const voice_action::Play& play);
  void Do(const voice_action::StandUp& stand_up);
  void Do(const voice_action::LogDropped& dropped);

  ControllerShell& shell_;
  VoiceState voice_;
  transport::Client<msg::AudioTextPlay>* player_ = nullptr;
  transport::Client<msg::MotionResultCmd>* motion_ = nullptr;
  std::unique_ptr<transport::Clock> clock_;
  transport::EventLoop* loop_ = nullptr;
  transport::LoopHandlePtr first_time_;  // the first sample of /clock
  std::optional<Time> armed_for_;
  transport::LoopHandlePtr timer_;
  transport::LoopHandlePtr look_soon_;
  transport::LoopHandlePtr look_;
};

}  // namespace musher::cyberdog
