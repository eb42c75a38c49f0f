#pragma once
// INTERVIEW, of the robot's second generation: it asks a guest a few questions and listens to the
// answers. The camera records them if the config says so.
//
// An extension like SEARCH: it adds its state, and a TRACKING that leads to it.

#include <string>
#include <vector>

#include "musher/modules/wedding/states/tracking.hpp"

namespace musher::wedding {

namespace state {
inline constexpr std::string_view kInterview = "INTERVIEW";
}  // namespace state
namespace command {
inline constexpr std::string_view kInterview = "interview";
}  // namespace command
namespace pose {
inline constexpr std::string_view kMicHold = "mic_hold";
}  // namespace pose
namespace sound {
inline constexpr std::string_view kInterviewStart = "interview_start";
inline constexpr std::string_view kInterviewThanks = "interview_thanks";
// and interview_question_1, _2, ...
}  // namespace sound

struct InterviewRules {
  Duration greeting = Milliseconds(3000);
  Duration question = Milliseconds(2000);           // at least
  Duration question_begin = Milliseconds(1500);     // a question takes this time,
  Duration question_character = Milliseconds(250);  // and this for each of its characters
  std::vector<int> question_characters = {0, 0, 0};
  Duration listening = Milliseconds(8000);  // at most
  Duration silence = Milliseconds(1500);    // after speech
  double voice_threshold = 0.02;            // of the energy of the microphone's signal
  Duration ending = Milliseconds(2000);
  Duration done = Milliseconds(1000);
  Duration lost = Milliseconds(1500);  // unseen for this time: the guest has left
  bool video = false;                  // the camera records the interview
  // From TRACKING without a command: a guest who was seen for `stable` and then stays for `stays`
  // in all, or is lost for a time between the two limits.
  bool unasked = true;
  Duration stable = Milliseconds(2000);
  Duration stays = Milliseconds(3500);
  Duration lost_least = Milliseconds(500);
  Duration lost_most = Milliseconds(1500);

  friend bool operator==(const InterviewRules&, const InterviewRules&) = default;
};

class Interview : public WeddingState {
 public:
  enum class Phase { kGreeting, kQuestion, kListening, kEnding, kDone };

  Interview(ShowData& data, const InterviewRules& rules);

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void Run(const fsm::Tick& tick) override;
  void OnExit(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  bool IsOver(const fsm::Tick& tick);
  bool HasAnswered(const fsm::Tick& tick);
  void NextPhase(const fsm::Tick& tick);
  void PlayNextQuestion(const fsm::Tick& tick);
  void Begin(Phase phase, const fsm::Tick& tick);

  const InterviewRules rules_;
  std::vector<std::string> sounds_;  // of the questions
  Phase phase_ = Phase::kGreeting;
  Duration phase_began_{};  // since the state was entered, like the others
  std::int64_t question_ = 0;
  bool spoke_ = false;
  Duration spoke_at_{};
  fsm::StateId idle_ = fsm::kNoState;
};

// Registered as TRACKING.
class InterviewingTracking : public Tracking {
 public:
  InterviewingTracking(ShowData& data, const TrackingRules& tracking,
                       const InterviewRules& interview)
      : Tracking(data, tracking), rules_(interview) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override { archive.Field("stable", stable_); }

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  const InterviewRules rules_;
  bool stable_ = false;
  fsm::EventId command_ = fsm::kNoEvent;
  fsm::StateId interview_ = fsm::kNoState;
};

}  // namespace musher::wedding
