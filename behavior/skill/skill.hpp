#pragma once
// One skill: something a robot can do that takes time, as a small state machine. Derive from Skill,
// or give a step function to StepFunction. run.hpp executes it.
//
//   class TakeOff : public skill::Skill {
//    public:
//     explicit TakeOff(Drone& drone) : drone_(drone) {}
//     void Declare(skill::Table& table) override {
//       table.Does("Rises to an altitude above the ground");
//       table.Takes("altitude", 1.0, "m above the ground");
//       rising_ = table.State("EXECUTING", std::chrono::seconds(30));
//       table.To(rising_, skill::kSucceeded, "at most 0.1 m below the altitude");
//     }
//     skill::Next Step(skill::Tick& tick) override {
//       const double target = tick.parameters.Number("altitude");
//       if (target <= 0) return skill::Next::Fail("the altitude is not above 0 m");
//       if (drone_.height >= target - 0.1) return skill::Next::Succeed("Reached altitude");
//       drone_.climb = 0.5;
//       tick.Report(100 * drone_.height / target, "Taking off");
//       return skill::Next::Stay();
//     }
//     void OnEnd(const skill::Ended& end) override { if (!end.paused) drone_.climb = 0; }
//    ...
//   };
//
// Each step makes at most one transition, and returns at once: it does not sleep, wait, lock or
// read a clock. The tick has the time, futures (future.hpp) have results of others.
//
// An exception fails the skill. A cancellation is seen in every state: in the next step Cancel() is
// called instead of Step(). From then on the run cannot succeed any more.
//
// Threads: those of its run, one at a time.

#include <functional>
#include <string>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/behavior/fsm/archive.hpp"
#include "musher/behavior/skill/feedback.hpp"
#include "musher/behavior/skill/table.hpp"

namespace musher::skill {

class Run;

// The argument of the functions of a skill. Times are run time: the sum of the steps since the run
// began, which stands still while it is paused and never goes back.
struct Tick {
  StateId state = kIdle;
  bool entered = false;      // the first step in this state
  Duration now{};            // since the run began
  Duration step{};           // since the last step
  Duration elapsed{};        // since this state was entered
  const Values& parameters;  // complete and of the declared kinds
  Values& data;              // of the skill; empty at the begin of a run; saved and restored
  bool cancelling = false;   // the end will be a cancellation or a failure
  int retries = 0;
  int replans = 0;

  // Feedback. Percent; values outside of 0 to 99 are moved there. Message and progress stay until
  // the next report, details until the next step.
  void Report(double progress, std::string message) {
    reported_progress = progress;
    reported_message = std::move(message);
    reported = true;
  }
  void Detail(std::string_view name, Value value) { details.Set(name, std::move(value)); }

  // What was reported, for the run.
  bool reported = false;
  double reported_progress = 0;
  std::string reported_message{};
  Values details{};
};

// What a step decides.
class Next {
 public:
  enum class Kind : std::uint8_t { kStay, kTo, kRetry, kReplan, kSucceed, kFail, kCancel };

  static Next Stay() { return {Kind::kStay, kIdle, {}}; }
  static Next To(StateId state, std::string message = {}) {
    return {Kind::kTo, state, std::move(message)};
  }
  // After an error that another attempt may overcome: goes to `state`, or fails when the limit of
  // retries is reached. `why` is kept as an error.
  static Next Retry(StateId state, std::string why) {
    return {Kind::kRetry, state, std::move(why)};
  }
  // Because the world has changed. Not counted as a retry, so only the limits of time end it.
  static Next Replan(StateId state, std::string why) {
    return {Kind::kReplan, state, std::move(why)};
  }
  static Next Succeed(std::string message = {}) {
    return {Kind::kSucceed, kSucceeded, std::move(message)};
  }
  static Next Fail(std::string why) { return {Kind::kFail, kFailed, std::move(why)}; }
  // The end of a cancellation, or of a skill that cancels itself.
  static Next Cancelled(std::string message = {}) {
    return {Kind::kCancel, kCancelled, std::move(message)};
  }

  Kind kind() const { return kind_; }
  StateId target() const { return target_; }
  const std::string& message() const { return message_; }

 private:
  Next(Kind kind, StateId target, std::string message)
      : kind_(kind), target_(target), message_(std::move(message)) {}

  Kind kind_;
  StateId target_;
  std::string message_;
};

// How a run ended.
struct Ended {
  Status status = Status::kFailed;
  StateId from = kIdle;  // the last state before
  std::string message;
  // In a pause: OnPause() has brought the outputs to neutral, and another skill may use the same
  // parts of the robot by now. Command nothing.
  bool paused = false;
};

class Skill {
 public:
  Skill() = default;
  virtual ~Skill() = default;
  Skill(const Skill&) = delete;
  Skill& operator=(const Skill&) = delete;

  // Once, when a run is made: declares states, transitions, limits and parameters.
  virtual void Declare(Table& table) = 0;
  virtual Next Step(Tick& tick) = 0;
  // Once, in the step after a cancellation was requested. To end in an orderly way, it goes to a
  // declared state or stays; the end is then at the latest after Limits::cancel.
  virtual Next Cancel(Tick& tick);
  // The time of the state is over, and Step() has decided to stay. By default it fails. Called in
  // each further step if it stays.
  virtual Next OnLimit(Tick& tick);
  // Exactly once at the end of a run, however it ends: bring the outputs to neutral, unless
  // Ended::paused. An exception makes a success a failure.
  virtual void OnEnd(const Ended& ended);
  // The run is not stepped for a while: bring the outputs to neutral. An exception fails the run.
  virtual void OnPause();
  virtual void OnResume();
  // Before a run that was paused by a request goes on: whether its preconditions still hold, as at
  // its begin. A failure refuses it, with the reason, and the run stays paused.
  virtual Result<> MayResume();
  // Saves and restores members that another process needs to continue. See fsm/archive.hpp.
  virtual void Persist(fsm::Archive& archive);

  // Runs of the skills that this skill runs, and their charts in the picture of its own.
  virtual std::vector<Run*> inside();
  virtual void Draw(fsm::Chart& chart) const;
};

// A plain step function as a skill, with its states and parameters. Its data is in tick.data. For
// more than one run, the function must not keep data of its own.
class StepFunction : public Skill {
 public:
  using Function = std::function<Next(Tick&)>;

  // `pause` brings the outputs to neutral; without it a run is not paused by a request.
  StepFunction(std::function<void(Table&)> declare, Function step, std::function<void()> pause = {})
      : declare_(std::move(declare)), step_(std::move(step)), pause_(std::move(pause)) {}
  void Declare(Table& table) override;
  Next Step(Tick& tick) override { return step_(tick); }
  void OnPause() override;

 private:
  const std::function<void(Table&)> declare_;
  const Function step_;
  const std::function<void()> pause_;
};

}  // namespace musher::skill
