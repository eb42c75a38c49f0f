#pragma once
// What a match does with plans, with the word of a person, and with the end of its tree. The
// actuator (meilin_actuator.hpp) gives it messages and ticks; it decides what is on the blackboard,
// and when the tree begins.
//
//   a new process, RESET      WAITING_START: nothing moves until Start(). With `autostart` a robot
//                             whose fresh pose is outside the grid, and which has no progress (also
//                             not that of a match that has ended), begins by itself, once
//   Start(region)             full, meilin or final; "": goes on where the progress ends, with the
//                             parts that are not done and the rest of the plan. Refused where the
//                             way there is not flat, or where it is not certain how to come off an
//                             edge
//   StartSoon(region)         the same, once there is a fresh pose, the wheels report, where they
//                             did before, and the suspension rests: a process that has just started
//                             has received none of them. At most kStartWait, then Start() decides
//   a plan                    checked as a whole. Refused: refused_plan() says why, and what runs
//                             goes on. Accepted: it replaces the queue, the action that runs ends
//                             first, and a tree that has failed begins again. One that was taken
//                             before, also by an earlier process, is not taken again (progress.hpp)
//   the tree has failed       MISSION_FAILED, the robot stands, until a plan is accepted, or
//                             Start()
//   a pause                   PAUSED; the segment that was halted is the next one again, but after
//                             a halt during a climb the mission has failed
//
// A plan is checked and run from one start: the end of the segment that runs; else the live pose
// where it is fresh and inside the grid (on an edge, where the robot comes off it); else where the
// robot is by what it has done. The nodes start from the same, and refuse another cell. A plan of
// the old form has poses: its ways are checked from the live pose, else from its first pose on.
//
// Units: those of robot.hpp. Pure: no clock, no process. Threads: one at a time, like the tree.

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/tree/tree.hpp"
#include "musher/modules/meilin/mission/match_config.hpp"
#include "musher/modules/meilin/mission/progress.hpp"
#include "musher/modules/meilin/nodes/mission_board.hpp"
#include "musher/modules/meilin/nodes/segment_nodes.hpp"
#include "musher/modules/meilin/plan/action_sequence.hpp"
#include "musher/modules/meilin/robot.hpp"

namespace musher::meilin {

// What a match can begin with.
inline constexpr const char* kFullRegion = "full";
inline constexpr const char* kMeilinRegion = "meilin";
inline constexpr const char* kFinalRegion = "final";

class Mission {
 public:
  Mission(Robot& robot, const Settings& settings, MatchConfig match, bool autostart = false)
      : robot_(robot), settings_(settings), match_(std::move(match)), autostart_(autostart) {}

  // Of a new tree: the plans that it runs (default: all), and its first values.
  void SetForms(const PlanForms& forms) { forms_ = forms; }
  Result<> Fill(tree::Board& board);

  // The live pose goes to the blackboard.
  void BeforeTick(Time now);
  // `fault`: what a node threw; "" for none.
  void AfterTick(tree::Status status, const std::string& fault, Time now);
  // The tree is halted.
  void OnPause();
  // The tree is halted and rests, because what a person has watched it by is lost, or its process
  // could not run for a while. Nothing moves until Start(), also not by a new plan or `autostart`;
  // it goes on with what it had. `why`: a start that waits is refused with it.
  void Stand(const char* why);

  // The word of a person. The text says what begins; an error why nothing does.
  Result<std::string> Start(const std::string& region, Time now);
  using OnStart = std::function<void(const Result<std::string>&)>;
  static constexpr Duration kStartWait = std::chrono::seconds(2);
  // `done` is called once, perhaps at once.
  void StartSoon(const std::string& region, Time now, OnStart done);
  // The regions that Start() would begin with, "" for going on.
  std::vector<std::string> CanStart(Time now) const;
  // What it would go on with: "plan mf_action_seq_3 at segment 5 of 9, fetch (1, 2)". Empty:
  // nothing.
  std::string GoesOnWith() const;

  // False: refused, refused_plan() says why. `written_ns`: when its message was written; 0: not
  // known.
  bool OfferPlan(const msg::Float32MultiArray& plan, Time now, std::int64_t written_ns = 0);
  // A plan of a service that hands plans out, which is the same one until the service has said that
  // it has none. False: refused, or it is that.
  bool OfferHandedOut(const msg::Float32MultiArray& plan, Time now);
  void NothingHandedOut() { progress_.ForgetHandedOut(); }
  // A plan of the old form, JSON. Without an id it gets one.
  bool OfferSegments(const std::string& text, Time now, std::int64_t written_ns = 0);
  // What runs goes on; refused_plan() says why. One that is late is not taken of a service either.
  void RefusePlan(const std::string& why);
  void RefuseLate(const msg::Float32MultiArray& plan, const std::string& why);
  // Whether that message was taken before.
  bool WasTaken(std::int64_t written_ns) const { return progress_.IsTaken(written_ns); }
  // The boxes of the field, for plans.
  void SetBoxes(const BoxMap& map) { boxes_ = map; }
  // Fails where there is no such command.
  Result<> Command(const std::string& command);

  // What is saved, and what an earlier process has saved: before the first tick.
  Progress SavedProgress() const;
  // Fails where it is that of the other side of the field. A plan of a form that the tree does not
  // run is left out.
  Result<> Restore(const Progress& progress);

  // Whether there is nothing to do: a plan may be requested.
  bool WantsPlan() const;
  // Whether the tree is to begin at its root; asks once.
  bool TakeRestart() { return std::exchange(restart_, false); }
  // Whether the tree is to be halted and to rest; asks once.
  bool TakeStop() { return std::exchange(stop_, false); }
  bool failed() const { return failed_; }
  bool begun() const { return begun_; }  // to begin

  std::string state() const;
  std::string last_error() const;
  std::string plan_id() const;
  std::string refused_plan() const;
  std::int64_t plans() const { return progress_.plans; }       // that were accepted
  std::uint64_t refusals() const { return refusals_; }         // of plans
  std::string last_end() const { return progress_.last_end; }  // of this or an earlier run

 private:
  MissionBoard& board() { return *board_; }
  PlanRules Rules() const;
  // An error: the robot is where no plan can begin.
  Result<PlanStart> StartAt(Time now) const;
  Result<std::optional<Point2>> PointAt(Time now) const;  // the same of an old plan
  bool HasRest() const;
  // What is left of the plan, from where the robot is; an error: it does not fit there.
  Result<std::vector<Segment>> RemainingSegments(Time now) const;
  PlanReading CheckRest(Time now) const;
  Result<std::vector<Segment>> OldRest(Time now) const;
  std::int64_t steps() const;  // of the plan
  void QueueRest(Time now);
  void ForgetPlan();
  void NoteWheels(Time now);
  std::string AwaitedForStart(Time now) const;
  void UpdateStart(Time now);
  std::string WhyNot(const std::string& region, Time now) const;
  std::string WhyNotThere(const std::set<std::string>& done, Time now) const;
  std::optional<Point2> NextTarget(const std::set<std::string>& done) const;
  std::set<std::string> DoneFor(const std::string& region) const;
  std::set<std::string> DoneNow() const;
  void SetDone(const std::set<std::string>& done);
  bool IsRunning() const { return begun_ && !ended_; }
  void Begin();
  void Accept(std::vector<Segment> segments, const std::string& plan_id);
  void Fail(const std::string& otherwise);
  void NoteProgress();
  void RefuseLateStart(const char* why);

  struct LateStart {
    std::string region;
    Time until{};
    OnStart done;
  };

  Robot& robot_;
  const Settings& settings_;
  const MatchConfig match_;
  bool autostart_;  // until the first start, or Stand()
  std::optional<MissionBoard> board_;
  tree::Board* root_ = nullptr;
  PlanForms forms_;
  Progress progress_;         // its place and parts are those of the blackboard
  std::vector<Segment> old_;  // the present plan, where it is one of the old form
  std::optional<BoxMap> boxes_;
  std::uint64_t refusals_ = 0;
  std::optional<LateStart> late_start_;
  bool begun_ = false;
  bool ended_ = false;   // the tree: until it begins again
  bool failed_ = false;  // with a failure
  bool restart_ = false;
  bool stop_ = false;
};

}  // namespace musher::meilin
