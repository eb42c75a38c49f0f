#pragma once
// SEARCH, of the robot's second generation: somebody was seen in IDLE; who stays is tracked.
//
// An extension: neither the engine nor the five states know of it. It brings its state, and an IDLE
// that goes there where the plain one would go to TRACKING.

#include "musher/modules/wedding/states/idle.hpp"

namespace musher::wedding {

namespace state {
inline constexpr std::string_view kSearch = "SEARCH";
}  // namespace state
namespace command {
inline constexpr std::string_view kSearch = "search";
}  // namespace command

struct SearchRules {
  Duration confirm = Milliseconds(2000);   // a face that stays so long is tracked
  Duration nobody = Milliseconds(5000);    // without a face for so long: back to IDLE
  Duration timeout = Milliseconds(10000);  // so long in all
  double scan = 0.25;                      // of the gaze, to each side
  Duration scan_period = Milliseconds(8000);

  friend bool operator==(const SearchRules&, const SearchRules&) = default;
};

class Search : public WeddingState {
 public:
  Search(ShowData& data, const SearchRules& rules)
      : WeddingState(data, state::kSearch), rules_(rules) {}

  void Declare(fsm::Ways& ways) override;
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

  void Declare(fsm::Ways& ways) override;

 protected:
  fsm::Next Decide(const fsm::Tick& tick) override;

 private:
  fsm::EventId command_ = fsm::kNoEvent;
  fsm::StateId search_ = fsm::kNoState;
};

}  // namespace musher::wedding
