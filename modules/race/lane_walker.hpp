#pragma once
// A walk of the line walker (modules/line_walker): START, its status until its end, STOP. Pure.
//
// Times are those of the machine, which stands still in a pause. One thread.

#include <optional>
#include <string>
#include <string_view>

#include "musher/modules/race/outputs.hpp"

namespace musher::race {

class LaneWalker {
 public:
  LaneWalker(const Course& course, RaceOutputs& outputs) : course_(course), outputs_(outputs) {}

  enum class End : std::uint8_t { kNone, kGood, kOther, kLost };

  void Begin(Index walk);
  // Each tick until an end. kGood: the course's end; kOther: another end, kStopGrace after it, or
  // the limit; kLost: no status. `reason` has the last two as text.
  End Advance(Duration now, std::string& reason);
  // STOP, if START was sent.
  void Stop();
  // It is started again by the next Advance().
  void Pause();

  void OnStatus(Index walk, std::string_view status);

 private:
  const Course& course_;
  RaceOutputs& outputs_;
  std::optional<Index> walk_;
  bool started_ = false;
  Duration started_at_{};
  Duration walked_{};  // before the last pause
  Duration received_at_{};
  bool received_ = false;             // since the last tick
  bool running_ = false;              // a status without an end was received since START
  std::string end_;                   // of the last status
  std::optional<Duration> ended_at_;  // with another end than the course's
};

}  // namespace musher::race
