// All cores are busy: a healthy actuator is starved at most, never lost.

#include <thread>

#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"

namespace musher::fault_injection::resource {

void CoresAreBusy(FaultRun& run) {
  const auto each = run.random.Between(2, 4);
  const auto time = Milliseconds(run.random.Between(800, 2000));
  const std::string target = run.state() == "Active" ? "DeActive" : "Active";
  run.Sampled("hogs on each core", std::to_string(each));
  run.Sampled("for", std::to_string(ToMilliseconds(time)) + " ms");
  run.MayBecome(target);
  {
    std::vector<benchmark::Child> hogs;
    run.FaultInjected();
    for (unsigned i = 0; i < each * std::thread::hardware_concurrency(); ++i) {
      hogs.emplace_back(std::vector<std::string>{benchmark::Program("fault_injection_hog")});
    }
    const auto reply = run.observer().SetState(target);
    run.LetPass(time);
    run.ExpectOutcome(AwaitFuture(reply), "done");
  }
  run.RecoveredIn(target);
}

}  // namespace musher::fault_injection::resource
