#pragma once
// SEARCH, of the robot's second generation: a face was seen in IDLE; a face that stays is tracked.
//
// An extension: neither the engine nor the five states know it. It adds its state, and an IDLE
// that leads to it instead of TRACKING.

#include "musher/modules/wedding/states/idle.hpp"

namespace musher::wedding {

namespace state {
inline constexpr std::string_view kSearch = "SEARCH";
}  // namespace state
namespace command {
inline constexpr std::string_view kSearch = "search";
}  // namespace command

struct SearchRules {
  Duration confirm = Milliseconds(2000);   // a face that stays this long is tracked
  Duration no_face = Milliseconds(5000);   // without a face: back to IDLE
  Duration timeout = Milliseconds(10000);  // in all
  double scan = 0.25;                      // of the gaze, to each side
  Duration scan_period = Milliseconds(8000);

  friend bool operator==(const SearchRules&, const SearchRules&) = default;
};

class Search : public WeddingState {
 public:
  Search(ShowData& data, const SearchRules& rules)
      : WeddingState(data, state::kSearch), rules_(rules) {}

  void Declare(fsm::Transitions& transitions) override;
  void OnEnter(const fsm::Tick& tick) override;
  void Run(const fsm::Tick& tick) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  const SearchRules rules_;
  fsm::StateId tracking_ = fsm::kNoState;
  fsm::StateId idle_ = fsm::kNoState;
};

// Registered as IDLE.
class SearchingIdle : public Idle {
 public:
  using Idle::Idle;

  void Declare(fsm::Transitions& transitions) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  fsm::EventId command_ = fsm::kNoEvent;
  fsm::StateId search_ = fsm::kNoState;
};

}  // namespace musher::wedding
