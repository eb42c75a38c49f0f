// Calls that come while a switch is under way.

#include "musher/test/campaign/faults/operation.hpp"

namespace musher::campaign::operation {

void Superseded(Trial& trial) {
  const std::string target = trial.state() == "Active" ? "LowPower" : "Active";
  trial.MayBecome(target);
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 100;
  const auto begun = trial.observer().Once(
      [target](const auto& status) { return status.target == target; }, [] {});
  const auto older = trial.observer().SetState(target);
  Answer(begun);
  trial.Struck();
  const auto newer = trial.observer().SetState("Error");
  trial.ExpectOutcome(Answer(older), "superseded");
  trial.DetectedNow();
  trial.ExpectOutcome(Answer(newer), "done");
  trial.RecoveredIn("Error");
}

void ManyCalls(Trial& trial) {
  std::vector<std::string> targets = {"Protected", "DeActive", "LowPower", "Active"};
  trial.random.Shuffle(targets);
  trial.MayBecome("Active");
  for (const std::string& name : Modules()) trial.robot.board(name).callback_ms = 50;
  trial.Struck();
  std::vector<std::shared_future<Result<msg::SetState::Response>>> answers;
  for (const std::string& target : targets) answers.push_back(trial.observer().SetState(target));
  int done = 0;
  std::string state = trial.state();
  for (const auto& future : answers) {
    const auto answer = Answer(future);
    trial.Require(answer.ok(), "a call was not answered");
    const msg::SetState::Response& result = answer.value();
    const bool is_done = result.outcome == "done";
    trial.Expect(is_done || (result.outcome == "refused" && result.code == 111),
                 "the switch to " + result.target + " is " + result.outcome + ": " + result.reason);
    if (is_done) state = result.target;
    if (is_done) ++done;
  }
  trial.Expect(done >= 1, "no call was followed");
  for (const std::string& name : Modules()) Relieve(trial.robot.board(name));
  trial.RecoveredIn(state);
}

}  // namespace musher::campaign::operation
