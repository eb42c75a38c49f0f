#pragma once
// The usual phases of a skill, for skills that have them. None has to use it.
//
//   IDLE → INITIALIZING → PREPARING → EXECUTING → FINALIZING → SUCCEEDED
//
//   from          by                 to
//   each phase    Done()             the next one
//   each phase    Fail()             FAILED
//   each but FINALIZING   Retry()    INITIALIZING; counted, see Limits::retries
//   EXECUTING     Replan()           PREPARING; not counted
//   INITIALIZING  a cancellation     CANCELLED
//   the others    a cancellation     FINALIZING, then CANCELLED
//
// A function that is not overridden is done at once, which takes a step. Parameters and limits are
// declared in Describe(), where the states exist: table.SetLimit("PREPARING", 15 s).
//
// Threads: those of its run, one at a time.

#include <string>

#include "musher/behavior/skill/skill.hpp"

namespace musher::skill {

class PatternSkill : public Skill {
 public:
  void Declare(Table& table) final;
  Next Step(Tick& tick) final;
  Next Cancel(Tick& tick) final;

 protected:
  // What a phase decides.
  class Outcome {
   public:
    enum class Kind : std::uint8_t { kContinue, kDone, kFail, kRetry, kReplan };

    static Outcome Continue() { return {Kind::kContinue, {}}; }
    static Outcome Done(std::string message = {}) { return {Kind::kDone, std::move(message)}; }
    static Outcome Fail(std::string why) { return {Kind::kFail, std::move(why)}; }
    static Outcome Retry(std::string why) { return {Kind::kRetry, std::move(why)}; }
    static Outcome Replan(std::string why) { return {Kind::kReplan, std::move(why)}; }

    Kind kind() const { return kind_; }
    const std::string& message() const { return message_; }

   private:
    Outcome(Kind kind, std::string message) : kind_(kind), message_(std::move(message)) {}

    Kind kind_;
    std::string message_;
  };

  virtual void Describe(Table& /*table*/) {}
  // Checks the parameters, and takes what it needs to begin.
  virtual Outcome Initialize(Tick& tick);
  // What has to come before: a plan, a resource.
  virtual Outcome Prepare(Tick& tick);
  virtual Outcome Execute(Tick& tick) = 0;
  // Also during a cancellation (tick.cancelling): gives back what was taken.
  virtual Outcome Finalize(Tick& tick);

 private:
  Outcome Phase(Tick& tick);

  StateId initializing_ = kIdle;
  StateId preparing_ = kIdle;
  StateId executing_ = kIdle;
  StateId finalizing_ = kIdle;
};

}  // namespace musher::skill
