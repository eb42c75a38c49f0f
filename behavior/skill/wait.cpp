#include "musher/behavior/skill/wait.hpp"

namespace musher::skill {
namespace {

class WaitSkill : public Skill {
 public:
  void Declare(Table& table) override {
    table.Does("Waits for a time");
    table.Takes("duration_s", 1.0, "seconds, 0 or more");
    table.To(table.State("WAITING"), kSucceeded, "the time is over");
    table.MonotoneProgress();
    table.Limit({.run = kNoLimit});
  }
  Next Step(Tick& tick) override {
    const double duration_s = tick.parameters.Number("duration_s");
    if (duration_s < 0) return Next::Fail("duration_s is negative");
    const double passed_s = ToSeconds(tick.now);
    if (passed_s >= duration_s) return Next::Succeed("Waited");
    tick.Report(100 * passed_s / duration_s, "Waiting");
    tick.Detail("left_s", duration_s - passed_s);
    return Next::Stay();
  }
};

}  // namespace

Factory Wait() {
  return [] { return std::make_unique<WaitSkill>(); };
}

}  // namespace musher::skill
