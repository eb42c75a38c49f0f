#include "musher/modules/audio/speech_action.hpp"

#include <utility>

#include "musher/base/code.hpp"

namespace musher::audio {
namespace {

constexpr std::uint8_t kSuccess = 0;  // of msg::Speech::Result
constexpr std::uint8_t kFailed = 1;

}  // namespace

SpeechAction::SpeechAction(transport::Endpoints& endpoints, transport::Clock& clock, Player player)
    : player_(std::move(player)) {
  transport::ActionHandlers<msg::Speech> handlers;
  handlers.accept = [this](const msg::Speech::Goal& goal, transport::PeerId) {
    return Accept(goal);
  };
  handlers.start = [this](Goal goal) { Start(std::move(goal)); };
  handlers.cancel = [this](const Goal& goal) { Cancel(goal); };
  transport::ActionServerOptions options;
  options.stamp = [&clock] { return clock.Stamp(); };
  endpoints.ServeAction<msg::Speech>("speech_text_action", handlers, options);
}

// The player decides: a goal that it refuses has ended when play() returns.
bool SpeechAction::Accept(const msg::Speech::Goal& goal) {
  const Number number = ++last_;
  goals_.try_emplace(number);
  const CallToken token =
      player_.play({0, goal.module_name, goal.is_online, goal.speech.play_id, goal.text, true},
                   [this, number](std::int32_t code) { OnEnd(number, code); });
  Requested& requested = goals_.at(number);
  requested.token = token;
  const bool refused = requested.code && *requested.code != kCodeOk;
  if (refused) goals_.erase(number);
  return !refused;
}

// Runs right after Accept().
void SpeechAction::Start(Goal goal) {
  goals_.at(last_).goal = std::move(goal);
  EndIfOver(last_);
}

void SpeechAction::Cancel(const Goal& goal) {
  for (const auto& [number, requested] : goals_) {
    if (requested.goal && requested.goal->id() == goal.id()) {
      return player_.cancel(requested.token);  // ends it, see OnEnd()
    }
  }
}

void SpeechAction::OnSounding(CallToken token) {
  for (auto& [number, requested] : goals_) {
    if (requested.token != token || !requested.goal) continue;
    requested.goal->Execute();
    requested.goal->PublishFeedback({true});
  }
}

void SpeechAction::OnEnd(Number number, std::int32_t code) {
  goals_.at(number).code = code;
  EndIfOver(number);
}

void SpeechAction::EndIfOver(Number number) {
  const Requested& requested = goals_.at(number);
  if (!requested.goal || !requested.code) return;
  Goal goal = *requested.goal;
  const bool done = *requested.code == kCodeOk;
  goals_.erase(number);
  if (done) {
    goal.Succeed({kSuccess});
  } else if (goal.state() == transport::GoalState::kCanceling) {
    goal.Canceled({kFailed});
  } else {
    goal.Abort({kFailed});
  }
}

}  // namespace musher::audio
