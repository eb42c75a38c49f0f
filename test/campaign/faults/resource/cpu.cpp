// All cores are busy: a healthy actuator is starved at most, never lost.

#include <thread>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/campaign/faults/resource.hpp"

namespace musher::campaign::resource {

void CoresAreBusy(Trial& trial) {
  const auto each = trial.random.Between(2, 4);
  const auto time = Milliseconds(trial.random.Between(800, 2000));
  const std::string target = trial.state() == "Active" ? "DeActive" : "Active";
  trial.Drawn("hogs on each core", std::to_string(each));
  trial.Drawn("for", std::to_string(ToMilliseconds(time)) + " ms");
  trial.MayBecome(target);
  {
    std::vector<benchmark::Child> hogs;
    trial.Struck();
    for (unsigned i = 0; i < each * std::thread::hardware_concurrency(); ++i) {
      hogs.emplace_back(std::vector<std::string>{benchmark::Program("campaign_hog")});
    }
    const auto answer = trial.observer().SetState(target);
    trial.LetPass(time);
    trial.ExpectOutcome(Answer(answer), "done");
  }
  trial.RecoveredIn(target);
}

}  // namespace musher::campaign::resource
