#pragma once
// Skills whose steps a test decides, and a log of the calls.

#include <functional>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "musher/behavior/skill/manager.hpp"

namespace musher::skill::testing {

// What the test decides, by the name of the skill.
struct Script {
  std::function<Next(Tick&)> step = [](Tick&) { return Next::Stay(); };
  std::function<Next(Tick&)> cancel;          // none: Skill::Cancel()
  std::function<Next(Tick&)> on_limit;        // none: Skill::OnLimit()
  std::map<std::string, std::string> throws;  // by function: OnEnd, OnPause, OnResume, Declare
  std::vector<std::string> uses;              // parts of the robot
  std::vector<std::string> uses_when_fast;    // where `speed` is above 1
  std::string cannot_pause;                   // the reason
  std::string may_not_resume;                 // the reason
  std::vector<std::string> log;
};

// INITIALIZING → EXECUTING → SUCCEEDED, with a way back; EXECUTING lasts 1 s at most.
class Scripted : public Skill {
 public:
  explicit Scripted(Script& script) : script_(script) {}

  void Declare(Table& table) override {
    Log("Declare");
    const StateId initializing = table.State("INITIALIZING");
    const StateId executing = table.State("EXECUTING", std::chrono::seconds(1));
    table.To(initializing, executing, "ready");
    table.To(executing, kSucceeded, "done");
    table.To(executing, initializing, "retry");
    table.To(executing, executing, "replan");
    table.Takes("speed", 0.5, "m/s");
    table.Takes("goal", Numbers{0, 0}, "m, in the map");
    for (const std::string& part : script_.uses) table.Uses(part);
    for (const std::string& part : script_.uses_when_fast) {
      table.UsesWhen(part, [](const Values& given) { return given.Number("speed") > 1; });
    }
    table.CannotPause(script_.cannot_pause);
    table.Limit({.run = std::chrono::seconds(10), .cancel = std::chrono::seconds(2), .retries = 2});
  }
  Next Step(Tick& tick) override { return script_.step(tick); }
  Next Cancel(Tick& tick) override {
    script_.log.emplace_back("Cancel");
    return script_.cancel ? script_.cancel(tick) : Skill::Cancel(tick);
  }
  Next OnLimit(Tick& tick) override {
    return script_.on_limit ? script_.on_limit(tick) : Skill::OnLimit(tick);
  }
  void OnEnd(const Ended& ended) override {
    Log("OnEnd", std::string(Name(ended.status)) + (ended.paused ? " in its pause" : ""));
  }
  void OnPause() override { Log("OnPause"); }
  void OnResume() override { Log("OnResume"); }
  Result<> MayResume() override {
    Log("MayResume");
    if (script_.may_not_resume.empty()) return Ok();
    return Error{kCodeFailed, script_.may_not_resume};
  }

 private:
  void Log(const std::string& function, const std::string& detail = {}) {
    if (function != "Declare")
      script_.log.push_back(function + (detail.empty() ? "" : " ") + detail);
    const auto found = script_.throws.find(function);
    if (found != script_.throws.end()) throw std::runtime_error(found->second);
  }

  Script& script_;
};

inline constexpr StateId kInitializing{4};
inline constexpr StateId kExecuting{5};

// A step function: goes to EXECUTING, and then does this.
inline std::function<Next(Tick&)> InExecuting(std::function<Next(Tick&)> step) {
  return [step = std::move(step)](Tick& tick) {
    return tick.state == kInitializing ? Next::To(kExecuting) : step(tick);
  };
}

// Completes in its `count`th step in EXECUTING.
inline std::function<Next(Tick&)> CompletesAfter(int count) {
  return InExecuting([count, steps = 0](Tick& tick) mutable {
    ++steps;
    tick.Report(100.0 * steps / count, "step " + std::to_string(steps));
    return steps < count ? Next::Stay() : Next::Succeed("done");
  });
}

}  // namespace musher::skill::testing
