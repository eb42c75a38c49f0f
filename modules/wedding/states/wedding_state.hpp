#pragma once
// The common base of the show's states: the commands that each of them accepts.

#include "musher/behavior/fsm/state.hpp"
#include "musher/modules/wedding/data/show_data.hpp"

namespace musher::wedding {

class WeddingState : public fsm::State {
 public:
  // `name` is the name it is registered under: no transition leads to the same state.
  WeddingState(ShowData& data, std::string_view name) : data_(data), name_(name) {}

  void Declare(fsm::Transitions& transitions) override;
  // stop and idle lead to IDLE, photo to PHOTO_POSING, tracking to TRACKING; else Decide() is
  // called.
  fsm::Next CheckTransition(const fsm::Tick& tick) final;

 protected:
  virtual fsm::Next Decide(const fsm::Tick& tick) = 0;

  ShowData& data() { return data_; }

  // Moves the gaze one step towards the face, if its direction is known.
  void FollowFace(const fsm::Tick& tick);
  // The same towards `target`.
  void LookTo(Gaze target, const fsm::Tick& tick);
  // Since the face was last seen, or the state was entered.
  Duration Lost(const fsm::Tick& tick) const;
  // How long the face has been seen without a gap, in this state.
  Duration Seen(const fsm::Tick& tick) const;

 private:
  ShowData& data_;
  const std::string_view name_;
  fsm::EventId stop_ = fsm::kNoEvent;
  fsm::EventId idle_ = fsm::kNoEvent;
  fsm::EventId photo_ = fsm::kNoEvent;
  fsm::EventId tracking_ = fsm::kNoEvent;
  fsm::StateId to_idle_ = fsm::kNoState;
  fsm::StateId to_photo_ = fsm::kNoState;
  fsm::StateId to_tracking_ = fsm::kNoState;
};

}  // namespace musher::wedding
