#pragma once
// One run of one skill: from its request to its end.
//
//   IDLE ── Begin() ──→ the skill's states ──→ SUCCEEDED | FAILED | CANCELLED   (and stays there)
//
// An end is final: no later step, cancellation or limit changes it. The run fails when the skill
// decides so, throws, makes a transition that it has not declared, needs more retries than its
// limit, or takes longer than its limit. It is cancelled when that was requested and the skill has
// not failed before; a skill that says it has succeeded after the request is cancelled, too.
//
// A run is paused by Pause(), until its next step, or by PauseUntilResumed(): then steps do
// nothing, and its time stands still, until Resume(). A cancellation ends a run that is paused so
// at once, without the skill's own one: another skill may use its parts of the robot by then.
//
// Threads: one at a time. A skill must not call its own run.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/behavior/recent.hpp"
#include "musher/behavior/skill/skill.hpp"

namespace musher::skill {

enum class Cause : std::uint8_t {
  kRequested,
  kDecided,  // by the skill
  kRetried,
  kReplanned,
  kLimit,      // of time or of retries
  kCancelled,  // by a request
  kFault,      // an exception, a transition that is not declared, or FailNow()
};
std::string_view Name(Cause cause);  // "requested", "decided", ...

struct Change {
  Duration at{};           // run time
  std::uint64_t tick = 0;  // the number of steps so far; 0: before the first
  StateId from = kIdle;
  StateId to = kIdle;
  Cause cause = Cause::kDecided;
  std::string why;  // may be empty

  friend bool operator==(const Change&, const Change&) = default;
};

// An error of a run, also one that a retry or a replan has overcome.
struct Failure {
  Duration at{};
  std::string state;
  std::string what;

  friend bool operator==(const Failure&, const Failure&) = default;
};

// What has started a run, for people and clients.
struct Origin {
  std::string goal_id;       // empty: no goal of skill_execution
  std::string requested_by;  // empty: not known

  friend bool operator==(const Origin&, const Origin&) = default;
};

struct Snapshot;  // snapshot.hpp

class Run {
 public:
  static constexpr std::size_t kChangesKept = 64;
  static constexpr std::size_t kErrorsKept = 16;

  // Calls Declare() and checks the table; see built().
  Run(std::string name, std::unique_ptr<Skill> skill, const Settings& settings = {});
  ~Run();  // ends nothing
  Run(const Run&) = delete;
  Run& operator=(const Run&) = delete;

  // All errors of the table and of the settings, a line each; then it cannot begin.
  const Result<>& built() const { return built_; }

  // Enters the first state. Fails, with all reasons, for invalid parameters, and when it has begun
  // before: each request has a run of its own.
  Result<> Begin(const Values& parameters);
  // One step of the skill, `step` after the last one; negative counts as none, and in the first
  // step of a run and after a pause no time has passed. Does nothing before the begin and after the
  // end.
  void Step(Duration step);
  // The time until the next step does not count.
  void Pause();
  // Fails with the reason: it does not run, is paused so already, is being cancelled, or it or a
  // skill inside of it declares that it cannot be paused. `why` is for people: "by a request".
  Result<> PauseUntilResumed(const std::string& why);
  // Goes on with the next step. Fails for a run that is not paused so, and with the reason of
  // Skill::MayResume(); then it stays paused.
  Result<> Resume();
  // Requests the cancellation; the next step does it. Only the first request counts. Ends a run at
  // once that PauseUntilResumed() has paused.
  void Cancel(const std::string& why);
  // Ends it at once, without the skill's own cancellation.
  void CancelNow(const std::string& why);
  // The same, as a failure: the robot cannot go on with it, for example with its battery.
  void FailNow(const std::string& why);

  // What OnEnd() has thrown, of this run or of one inside it: "grip: OnEnd: no reply". Its outputs
  // may not be neutral. Empty: nothing.
  std::string EndFault() const;

  bool running() const { return state_ != kIdle && !IsEnd(state_); }
  bool ended() const { return IsEnd(state_); }
  // Until Resume() or a cancellation. Such a run does not use its parts of the robot.
  bool pause_requested() const { return pause_requested_ && running(); }
  const std::string& pause_why() const { return pause_why_; }
  bool cancelling() const { return cancel_requested_ && running(); }
  StateId state() const { return state_; }
  // "EXECUTING"; of a skill that runs skills "RUNNING/take_off/EXECUTING".
  std::string Path() const;
  const Feedback& feedback() const { return feedback_; }
  const Recent<Change>& history() const { return history_; }
  const Recent<Failure>& errors() const { return errors_; }
  int retries() const { return retries_; }
  int replans() const { return replans_; }
  Duration now() const { return now_; }
  Duration elapsed() const { return elapsed_; }  // in the state
  const Values& parameters() const { return parameters_; }
  // The parts of the robot that the run uses with its parameters.
  std::vector<std::string> parts() const { return table_.PartsFor(parameters_); }

  const std::string& name() const { return name_; }
  // The number that the manager gave the run, from 1 on; a later run of the same skill has another
  // number. 0: no manager has started the run.
  std::uint64_t number() const { return number_; }
  const Origin& origin() const { return origin_; }
  const Table& table() const { return table_; }
  // For a picture (fsm/graph.hpp): with the skills inside, where it runs some.
  fsm::Chart chart() const;
  const std::vector<Run*>& inside() const { return inside_; }

  // See snapshot.hpp.
  Result<Snapshot> Save() const;

 private:
  friend class Manager;
  friend class Restorer;

  Tick MakeTick(Duration step);
  Next Decide(Tick& tick);
  void Take(Tick& tick);
  void Execute(const Next& next);
  void Move(StateId target, Cause cause, const std::string& why);
  void CheckLimits();
  void End(Status status, Cause cause, std::string message);
  void FailByFault(const std::string& what);
  void Note(const std::string& what);
  void ShowState();
  std::string WhyNotPaused() const;
  Result<> MayResume();
  template <class Call>
  std::optional<std::string> Thrown(const char* function, Call&& call);

  const std::string name_;
  std::uint64_t number_ = 0;
  Origin origin_;
  const std::unique_ptr<Skill> skill_;
  Table table_;
  Result<> built_;
  std::vector<Run*> inside_;
  std::function<void(const Run&, const Change&)> changed_;  // of its manager

  StateId state_ = kIdle;
  bool entered_ = false;  // no step in this state yet
  bool fresh_ = true;     // no time passes until the next step
  bool paused_ = false;
  bool pause_requested_ = false;
  std::string pause_why_;
  bool in_step_ = false;
  std::uint64_t ticks_ = 0;
  Duration now_{};
  Duration elapsed_{};
  int retries_ = 0;
  int replans_ = 0;
  bool cancel_requested_ = false;
  bool cancel_passed_ = false;  // to the skill
  std::string cancel_why_;
  Duration cancel_at_{};
  bool limit_decides_ = false;  // OnLimit() has made the decision
  Values parameters_;
  Values data_;
  Feedback feedback_;
  Recent<Change> history_{kChangesKept};
  Recent<Failure> errors_{kErrorsKept};
  std::string end_fault_;
};

}  // namespace musher::skill
