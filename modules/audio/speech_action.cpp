#include "musher/modules/audio/speech_action.hpp"

#include <utility>

#include "musher/base/code.hpp"

namespace musher::audio {
namespace {

constexpr std::uint8_t kSuccess = 0;  // of msg::Speech::Result
constexpr std::uint8_t kFailed = 1;

PlayRequest RequestOf(const msg::Speech::Goal& goal) {
  return {0, goal.module_name, goal.is_online, goal.speech.play_id, goal.text, true};
}

}  // namespace

SpeechAction::SpeechAction(transport::Endpoints& endpoints, transport::Clock& clock, Player player)
    : player_(std::move(player)) {
  transport::ActionHandlers<msg::Speech> handlers;
  handlers.accept = [this](const msg::Speech::Goal& goal, transport::ParticipantId) {
    return Accept(goal);
  };
  handlers.start = [this](const Goal& goal) { Start(goal); };
  handlers.cancel = [this](const Goal& goal) { Cancel(goal); };
  transport::ActionServerOptions options;
  options.stamp = [&clock] { return clock.Stamp(); };
  endpoints.ServeAction<msg::Speech>("speech_text_action", handlers, options);
}

bool SpeechAction::Accept(const msg::Speech::Goal& goal) {
  const PlayRequest request = RequestOf(goal);
  const bool accepted = player_.may_play(request);
  // The player logs why it refuses.
  if (!accepted) player_.play(request, [](std::int32_t) {});
  return accepted;
}

void SpeechAction::Start(const Goal& goal) {
  const Number number = ++last_;
  goals_.try_emplace(number, Requested{goal});
  const CallToken token = player_.play(RequestOf(goal.goal()),
                                       [this, number](std::int32_t code) { OnEnd(number, code); });
  const auto requested = goals_.find(number);
  if (requested != goals_.end()) requested->second.token = token;
}

void SpeechAction::Cancel(const Goal& goal) {
  for (const auto& [number, requested] : goals_) {
    if (requested.goal.id() == goal.id()) {
      return player_.cancel(requested.token);  // ends it, see OnEnd()
    }
  }
}

void SpeechAction::OnSounding(CallToken token) {
  for (auto& [number, requested] : goals_) {
    if (requested.token != token) continue;
    requested.goal.Execute();
    requested.goal.PublishFeedback({true});
  }
}

void SpeechAction::OnEnd(Number number, std::int32_t code) {
  Goal goal = goals_.extract(number).mapped().goal;
  if (code == kCodeOk) {
    goal.Succeed({kSuccess});
  } else if (goal.state() == transport::GoalState::kCanceling) {
    goal.Canceled({kFailed});
  } else {
    goal.Abort({kFailed});
  }
}

}  // namespace musher::audio
