#include "musher/cyberdog/speaker.hpp"

#include <utility>

#include "musher/cyberdog/voice_policy.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/std_msgs/basic.hpp"

namespace musher::cyberdog {
namespace {

constexpr const char* kName = "cyberdog_manager";          // the node name of CyberDog's manager
constexpr Duration kLookPeriod = std::chrono::seconds(1);  // for changes without a record
constexpr Duration kCallTime = std::chrono::minutes(1);    // by the steady clock
constexpr Duration kStandUpTime = std::chrono::seconds(20);

}  // namespace

Result<std::unique_ptr<Speaker>> Speaker::Make(transport::Endpoints& endpoints,
                                               ControllerShell& shell) {
  if (VoiceOf(*shell.config().policy).say.empty()) return std::unique_ptr<Speaker>();
  std::unique_ptr<Speaker> speaker(new Speaker(shell));
  if (auto opened = speaker->Open(endpoints); !opened) return opened.error();
  return speaker;
}

Result<> Speaker::Open(transport::Endpoints& endpoints) {
  loop_ = &endpoints.node().loop();
  auto clock = transport::Clock::Of(shell_.config().clock, endpoints.node(),
                                    [this] { Handle(voice_event::TimePassed{}); });
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  first_time_ = clock_->At(Time{}, [this] { Handle(voice_event::TimePassed{}); });
  player_ = endpoints.OpenClient<msg::AudioTextPlay>("speech_text_play", [this] { Look(); });
  motion_ = endpoints.OpenClient<msg::MotionResultCmd>("motion_result_cmd");
  endpoints.Subscribe<msg::TouchStatus>("touch_status", [this](const msg::TouchStatus& touch) {
    if (touch.touch_state == msg::TouchStatus::kDoubleTouch) Handle(voice_event::DoubleTapped{});
  });
  endpoints.Subscribe<msg::Bool>("app_connection_state", [this](const msg::Bool& connected) {
    if (connected.data) Handle(voice_event::AppConnected{});
  });
  endpoints.Subscribe<msg::Bool>("audio_notification_report", [this](const msg::Bool& playing) {
    Handle(voice_event::PlayReported{playing.data});
  });
  if (!endpoints.opened()) return endpoints.opened().error();
  look_ = loop_->Every(kLookPeriod, [this] { Look(); });
  return Ok();
}

// Handles the record before the machine's change: the change is read on the loop's next turn.
void Speaker::OnRecord(const action::Record& record) {
  Handle(voice_event::Recorded{record});
  if (look_soon_) return;
  look_soon_ = loop_->At(loop_->Now(), [this] {
    look_soon_ = nullptr;
    Look();
  });
}

void Speaker::Look() {
  if (const bool matched = player_->Ready(); matched != voice_.player) {
    Handle(voice_event::PlayerMatched{matched});
  }
  const MachineSummary machine = SummaryOf(shell_.config(), shell_.machine());
  if (machine != voice_.machine) Handle(voice_event::MachineSeen{machine});
}

void Speaker::Handle(const VoiceEvent& event) {
  for (const VoiceAction& action : Speak(shell_.config(), voice_, event, clock_->Now())) {
    std::visit([this](const auto& a) { Do(a); }, action);
  }
  Arm();
}

void Speaker::Arm() {
  const auto next = NextVoiceDeadline(voice_);
  if (next == armed_for_) return;
  armed_for_ = next;
  timer_ = nullptr;
  if (!next) return;
  timer_ = clock_->At(*next, [this] {
    armed_for_.reset();
    Handle(voice_event::TimePassed{});
  });
}

void Speaker::Do(const voice_action::Play& play) {
  const Utterance& utterance = play.utterance;
  const msg::AudioTextPlay::Request request{
      kName, !utterance.text.empty(), {kName, utterance.id}, utterance.text};
  player_->Call(request, kCallTime,
                [this, number = play.number](const Result<msg::AudioTextPlay::Response>&) {
                  Handle(voice_event::PlayEnded{number});
                });
}

void Speaker::Do(const voice_action::StandUp&) {
  msg::MotionResultCmd::Request request;
  request.motion_id = msg::MotionId::kRecoveryStand;
  request.cmd_source = msg::MotionSource::kApp;
  motion_->Call(request, kStandUpTime,
                [this](const Result<msg::MotionResultCmd::Response>& answer) {
                  if (answer && answer.value().result) return;
                  shell_.Remark(answer ? answer.value().code : answer.error().code,
                                "app connected, but the robot does not stand up");
                });
}

void Speaker::Do(const voice_action::LogDropped&) {
  if (!shell_.config().IndexOf("audio")) return;  // no player is expected
  shell_.Remark(kCodeNetError,
                "the manager's announcements are not played: no service speech_text_play");
}

}  // namespace musher::cyberdog
