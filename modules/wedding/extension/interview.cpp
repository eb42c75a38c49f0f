#include "musher/modules/wedding/extension/interview.hpp"

#include <algorithm>

namespace musher::wedding {

Interview::Interview(ShowData& data, const InterviewRules& rules)
    : WeddingState(data, state::kInterview), rules_(rules) {
  for (std::size_t i = 1; i <= rules_.question_characters.size(); ++i) {
    sounds_.push_back("interview_question_" + std::to_string(i));
  }
}

void Interview::Declare(fsm::Transitions& transitions) {
  WeddingState::Declare(transitions);
  idle_ = transitions.To(state::kIdle, "all questions asked, or the face is lost");
}

void Interview::OnEnter(const fsm::Tick& tick) {
  question_ = 0;
  data().motion.target_pose = pose::kMicHold;
  data().Speak(sound::kInterviewStart);
  if (rules_.video) data().video_wanted = true;
  Begin(Phase::kGreeting, tick);
}

void Interview::Run(const fsm::Tick& tick) {
  FollowFace(tick);
}

fsm::Next Interview::Decide(const fsm::Tick& tick) {
  if (Lost(tick) >= rules_.lost) return fsm::Next::To(idle_);
  if (!IsOver(tick)) return fsm::Next::Stay();
  if (phase_ == Phase::kDone) return fsm::Next::To(idle_);
  NextPhase(tick);
  return fsm::Next::Stay();
}

bool Interview::IsOver(const fsm::Tick& tick) {
  const Duration time = tick.elapsed - phase_began_;
  switch (phase_) {
    case Phase::kGreeting:
      return time >= rules_.greeting;
    case Phase::kQuestion: {
      const int characters = rules_.question_characters.at(static_cast<std::size_t>(question_ - 1));
      return time >= std::max(rules_.question,
                              rules_.question_begin + characters * rules_.question_character);
    }
    case Phase::kListening:
      return HasAnswered(tick) || time >= rules_.listening;
    case Phase::kEnding:
      return time >= rules_.ending;
    default:
      return time >= rules_.done;
  }
}

bool Interview::HasAnswered(const fsm::Tick& tick) {
  if (data().audio.voice_level > rules_.voice_threshold) {
    spoke_ = true;
    spoke_at_ = tick.elapsed;
  }
  return spoke_ && tick.elapsed - spoke_at_ >= rules_.silence;
}

// Enters the phase after the present one.
void Interview::NextPhase(const fsm::Tick& tick) {
  if (phase_ == Phase::kQuestion) return Begin(Phase::kListening, tick);
  if (phase_ == Phase::kEnding) return Begin(Phase::kDone, tick);
  PlayNextQuestion(tick);
}

// Plays the next question, or thanks.
void Interview::PlayNextQuestion(const fsm::Tick& tick) {
  if (static_cast<std::size_t>(question_) < sounds_.size()) {
    data().Speak(sounds_.at(static_cast<std::size_t>(question_)));
    ++question_;
    return Begin(Phase::kQuestion, tick);
  }
  data().Speak(sound::kInterviewThanks);
  Begin(Phase::kEnding, tick);
}

void Interview::Begin(Phase phase, const fsm::Tick& tick) {
  phase_ = phase;
  phase_began_ = tick.elapsed;
  spoke_ = false;
}

void Interview::OnExit(const fsm::Tick& /*tick*/) {
  if (rules_.video) data().video_wanted = false;
  data().motion.target_pose = pose::kNeutral;
}

void Interview::Persist(fsm::Archive& archive) {
  archive.Field("phase", phase_);
  archive.Field("phase_began", phase_began_);
  archive.Field("question", question_);
  archive.Field("spoke", spoke_);
  archive.Field("spoke_at", spoke_at_);
}

void InterviewingTracking::Declare(fsm::Transitions& transitions) {
  Tracking::Declare(transitions);
  command_ = transitions.On(command::kInterview);
  interview_ =
      transitions.To(state::kInterview,
                     rules_.unasked ? "a guest stays, or command interview" : "command interview");
}

void InterviewingTracking::OnEnter(const fsm::Tick& tick) {
  Tracking::OnEnter(tick);
  stable_ = false;
}

// A photo and a farewell take precedence over an interview without a command.
fsm::Next InterviewingTracking::Decide(const fsm::Tick& tick) {
  const fsm::Next next = Tracking::Decide(tick);
  if (tick.command != fsm::kNoEvent && tick.command == command_) return fsm::Next::To(interview_);
  if (!next.stays() || !rules_.unasked) return next;
  const Duration seen = Seen(tick);
  if (seen >= rules_.stable) stable_ = true;
  const Duration lost = Lost(tick);
  const bool stays = stable_ && seen >= rules_.stays;
  const bool hides = stable_ && lost >= rules_.lost_least && lost < rules_.lost_most;
  return stays || hides ? fsm::Next::To(interview_) : next;
}

}  // namespace musher::wedding
