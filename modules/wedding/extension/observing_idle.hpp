#pragma once
// IDLE of the robot's second generation: it moves and speaks for a while, then stands still and
// observes. Faces count only while it observes: a swaying camera sees guests who do not stay.

#include <cstdint>
#include <random>

#include "musher/modules/wedding/extension/actions.hpp"
#include "musher/modules/wedding/extension/search.hpp"

namespace musher::wedding {

struct ActionRules {
  std::uint64_t seed = 1;
  Duration idle_least = Milliseconds(10'000);  // that it moves and speaks,
  Duration idle_most = Milliseconds(20'000);
  double greeting_probability = 0.3;  // after observing; else it moves again as before
  Duration greeting = Milliseconds(3500);
  Duration observe_least = Milliseconds(3000);  // that it observes
  Duration observe_most = Milliseconds(5000);
  Duration confirm = Milliseconds(500);  // from the first to the last sighting of a face
  Duration lost = Milliseconds(200);     // longer without a sighting: it is another face
  double same_within = 0.15;             // of the picture, for a face without a number

  friend bool operator==(const ActionRules&, const ActionRules&) = default;
};

// Registered as IDLE.
class ObservingIdle : public SearchingIdle {
 public:
  enum class Phase { kActive, kGreeting, kObserve };

  ObservingIdle(ShowData& data, const IdleRules& idle, const ActionRules& rules,
                ActionPlayer& player)
      : SearchingIdle(data, idle), rules_(rules), player_(player), random_(rules.seed) {}

  void OnEnter(const fsm::Tick& tick) override;
  void Run(const fsm::Tick& tick) override;
  void Persist(fsm::Archive& archive) override;

 protected:
  bool SeesGuest(const fsm::Tick& tick) override;

 private:
  Phase PhaseAfter();
  Duration LengthOf(Phase phase);
  void Begin(Phase phase, Duration elapsed);
  Duration DrawBetween(Duration least, Duration most);
  bool IsConfirmed(const fsm::Tick& tick);

  const ActionRules rules_;
  ActionPlayer& player_;
  std::mt19937_64 random_;
  Phase phase_ = Phase::kActive;
  Duration phase_ends_{};  // since the state was entered
  // The face that is observed.
  bool candidate_ = false;
  Duration first_seen_{};  // since the state was entered
  int face_id_ = -1;
  Gaze position_;
};

}  // namespace musher::wedding
