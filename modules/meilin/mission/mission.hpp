#pragma once
// What a match does with plans and with the end of its tree. The actuator (meilin_actuator.hpp)
// gives it messages and ticks; it decides what is on the blackboard, and when the tree begins
// again.
//
//   a plan                    checked as a whole. Refused: PLAN_REJECTED and last_error; what runs
//                             goes on. Accepted: it replaces the queue, the action that runs ends
//                             first, and a tree that has ended begins again
//   the tree has failed       MISSION_FAILED, the robot stands, until a plan is accepted or RESET
//   RESET                     the match begins at its start, without a plan
//   a pause                   the segment that was halted is the next one again, but after a halt
//                             during a climb the mission has failed
//
// A plan is checked from the end of the segment that runs; else from the live pose where it is
// fresh and inside the grid, else from the initial cell.
//
// Units: those of robot.hpp. Pure: no clock, no process. Threads: one at a time, like the tree.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "musher/behavior/tree/tree.hpp"
#include "musher/modules/meilin/mission/match_config.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

class Mission {
 public:
  Mission(Robot& robot, const Settings& settings, MatchConfig match)
      : robot_(robot), settings_(settings), match_(std::move(match)) {}

  // Of a new tree: its first values.
  Result<> Fill(tree::Board& board);

  // The live pose goes to the blackboard.
  void BeforeTick();
  // `fault`: what a node threw; "" for none.
  void AfterTick(tree::Status status, const std::string& fault);
  // The tree is halted.
  void OnPause();

  // False: refused, last_error() says why.
  bool OfferPlan(const msg::Float32MultiArray& plan, Time now);
  // An old plan, that is already checked.
  void OfferSegments(std::vector<Segment> segments, const std::string& plan_id);
  void RefusePlan(const std::string& why);
  // Fails where there is no such command.
  Result<> Command(const std::string& command);

  // Whether there is nothing to do: a plan may be requested.
  bool WantsPlan() const;
  // Whether the tree is to begin at its root; asks once.
  bool TakeRestart() { return std::exchange(restart_, false); }
  // Whether the tree is to be halted and to rest; asks once.
  bool TakeStop() { return std::exchange(stop_, false); }
  bool failed() const { return failed_; }

  std::string state() const;
  std::string last_error() const;
  std::string plan_id() const;

 private:
  MissionBoard& board() { return *board_; }
  PlanStart StartAt(Time now) const;
  void Begin();
  void Accept(std::vector<Segment> segments, const std::string& plan_id);
  void Fail(const std::string& otherwise);

  Robot& robot_;
  const Settings& settings_;
  const MatchConfig match_;
  std::optional<MissionBoard> board_;
  tree::Board* root_ = nullptr;
  std::uint64_t plans_ = 0;
  bool ended_ = false;   // the tree: until it begins again
  bool failed_ = false;  // with a failure
  bool restart_ = false;
  bool stop_ = false;
};

}  // namespace musher::meilin
