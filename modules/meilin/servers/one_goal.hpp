#pragma once
// What the four servers have in common: an action with one goal at a time, served in Active only,
// and updates on the machine's clock while there is work. Runs on any transport.
//
//   - A goal is rejected, with a line in the log, when it is malformed, when the actuator is not in
//     Active, when a process of another machine has sent it (wire/other_machines.hpp), or one whose
//     status has not arrived yet, when it may have waited while this process could not run
//     (transport/loop_breaks.hpp), or when another goal runs (a server that preempts ends the
//     present one instead).
//   - A goal that cannot be done, and one that is interrupted, is aborted with the reason in its
//     result.
//
// Threads: the loop's.

#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "musher/application/refusal.hpp"
#include "musher/base/log.hpp"
#include "musher/base/rate_limited_log.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/wire/other_machines.hpp"

namespace musher::meilin::servers {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;
  std::string name_space;
  std::function<void(LogLevel level, const std::string& line)> log;
  const transport::OtherMachines* others = nullptr;  // outlives the server; null: with keys
};

// The interface of a server for its actuator.
class Server {
 public:
  virtual ~Server() = default;

  // Whether goals are accepted. With false the hardware is stopped and a goal is aborted with
  // `why`.
  virtual void Permit(bool permitted, const std::string& why) = 0;
  // The world was restarted, or its time has jumped for another reason: the same.
  virtual void OnTimeJump(const std::string& why) = 0;
  // What is missing for goals; empty: nothing.
  virtual std::string Missing() const = 0;
};

template <msg::Action A>
class OneGoalServer : public Server {
 public:
  using Goal = transport::ServerGoal<A>;

  void Permit(bool permitted, const std::string& why) final {
    permitted_ = permitted;
    if (!permitted) {
      not_permitted_ = why;
      Interrupt("Aborted: " + why);
    }
    OnPermit(permitted);
  }
  void OnTimeJump(const std::string& why) final {
    Interrupt("Aborted: " + why);
    Forget();
  }

 protected:
  OneGoalServer(const Dependencies& dependencies, bool preempts)
      : dependencies_(dependencies),
        preempts_(preempts),
        warnings_([this](const std::string& line) { Log(LogLevel::kWarning, line); }, kQuiet),
        breaks_(dependencies.node.loop()),
        endpoints_(dependencies.node, dependencies.name_space) {}

  // Why a goal is malformed; empty: it is not.
  virtual std::string WhyMalformed(const typename A::Goal& goal) const = 0;
  // Begins with a goal; the text is why it cannot be done, empty if it can.
  virtual std::string Begin(const typename A::Goal& goal) = 0;
  // Stops the hardware at once. The result of an unfinished goal, without a message.
  virtual typename A::Result StopWork() = 0;
  virtual std::string CancelText() const = 0;
  // An update; true: there is no work left.
  virtual bool Tick() = 0;
  virtual Duration Period() const = 0;
  // Inputs of before do not count.
  virtual void Forget() = 0;
  virtual void OnPermit(bool) {}

  void Serve(const std::string& action) {
    transport::ActionHandlers<A> handlers;
    handlers.accept = [this](const typename A::Goal& goal, transport::ParticipantId caller) {
      const std::string why = WhyRejected(goal, caller);
      if (!why.empty()) Warn("rejected", "a goal is rejected: " + why);
      return why.empty();
    };
    handlers.start = [this](const Goal& goal) { OnGoal(goal); };
    handlers.cancel = [this](Goal goal) { OnCancel(std::move(goal)); };
    transport::ActionServerOptions options;
    options.stamp = [this] { return dependencies_.clock.Stamp(); };
    endpoints_.ServeAction<A>(action, std::move(handlers), std::move(options));
    auto& loop = dependencies_.node.loop();
    quiet_ = loop.Every(kQuiet, [this, &loop] { warnings_.Tick(loop.Now()); });
  }
  // Ends the goal, if there is one.
  void Conclude(typename A::Result result) {
    if (!goal_) return;
    Goal goal = *std::exchange(goal_, std::nullopt);
    Log(result.success ? LogLevel::kInfo : LogLevel::kWarning, result.message);
    if (result.success) {
      goal.Succeed(result);
    } else {
      goal.Abort(result);
    }
  }
  // Stops the hardware; a goal is aborted.
  void Interrupt(const std::string& why) {
    if (!goal_) return;
    typename A::Result result = StopWork();
    result.message = why;
    Conclude(std::move(result));
  }
  // Updates from now on, until there is no work left.
  void Arm() {
    armed_ = Period();
    ticks_ = dependencies_.clock.Every(armed_, [this] { OnTick(); });
  }
  void Feedback(const typename A::Feedback& feedback) {
    if (goal_) goal_->PublishFeedback(feedback);
  }
  void Warn(const std::string& kind, const std::string& line) {
    warnings_.Log(kind, line, dependencies_.node.loop().Now());
  }
  void Log(LogLevel level, const std::string& line) const { dependencies_.log(level, line); }
  bool busy() const { return goal_.has_value(); }
  transport::Endpoints& endpoints() { return endpoints_; }
  transport::Clock& clock() const { return dependencies_.clock; }
  Time Now() const { return dependencies_.clock.Now(); }

 private:
  static constexpr Duration kQuiet = std::chrono::seconds(2);  // between warnings of one kind

  // A goal names no machine: each robot of the namespace in reach receives it.
  std::string WhyNotMeant(transport::ParticipantId caller) const {
    if (dependencies_.others == nullptr) return "";
    if (dependencies_.others->IsAwaited(caller)) {
      return "the status of its sender has not arrived, which may be of another robot; send it "
             "again";
    }
    const MachineIdentity* other = dependencies_.others->Of(caller);
    if (other == nullptr) return "";
    return "it is of another machine, " + MachineText(*other) +
           ", with the same namespace and domain; give each machine its namespace";
  }
  std::string WhyRejected(const typename A::Goal& goal, transport::ParticipantId caller) {
    if (const std::string why = WhyNotMeant(caller); !why.empty()) return why;
    if (!permitted_) return not_permitted_;
    if (const auto could_not_run = breaks_.Recent()) {
      const Error late = Refused<ApplicationRefusal::kMayBeLate>(
          "this server", ToMilliseconds(*could_not_run) / 1000);
      if (preempts_) Interrupt("Aborted: " + late.message);
      return late.message;
    }
    if (busy() && !preempts_) return "another goal runs; cancel it or wait for its end";
    return WhyMalformed(goal);
  }
  // As after a restart: who sent the goal does not see that it is so old.
  void EndAfterBreak() {
    const auto could_not_run = breaks_.Take();
    if (!could_not_run || *could_not_run <= BreakWatch::kLong) return;
    Interrupt("Aborted: this server could not run for " +
              std::to_string(ToMilliseconds(*could_not_run) / 1000) + " s");
  }
  void OnGoal(const Goal& goal) {
    EndAfterBreak();  // of before this goal
    Interrupt("Preempted by a newer goal");
    goal_ = goal;
    goal_->Execute();
    std::string why = permitted_ ? Begin(goal.goal()) : "Aborted: " + not_permitted_;
    if (!why.empty()) {
      typename A::Result result{};
      result.message = std::move(why);
      return Conclude(std::move(result));
    }
    Arm();
  }
  void OnCancel(Goal goal) {
    if (!goal_ || goal_->id() != goal.id()) {
      goal.Canceled({});
      return;
    }
    const std::string text = CancelText();
    typename A::Result result = StopWork();
    result.message = text;
    goal_.reset();
    goal.Canceled(result);
    Log(LogLevel::kInfo, text);
  }
  void OnTick() {
    EndAfterBreak();
    if (Tick()) {
      ticks_.reset();
    } else if (Period() != armed_) {
      Arm();
    }
  }

  const Dependencies dependencies_;
  const bool preempts_;
  RateLimitedLog warnings_;
  transport::LoopBreaks breaks_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  std::optional<Goal> goal_;
  Duration armed_{};
  transport::LoopHandlePtr quiet_;
  transport::LoopHandlePtr ticks_;  // while there is work
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::meilin::servers
