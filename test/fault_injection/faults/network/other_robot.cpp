// The whole robot on this host, with the profile lan: its interface to other hosts goes, or another
// robot of the same namespace and domain comes.

#include <algorithm>

#include "musher/test/fault_injection/faults/network.hpp"

namespace musher::fault_injection::network {
namespace {

constexpr const char* kOther = "other";

// A person at this robot: it does what is asked for, and nothing else changes.
void ExpectObeys(FaultRun& run, const std::string& when) {
  for (const char* state : {"LowPower", "Active"}) {
    const int exit = run.robot.Musher({"set", state});
    run.Expect(exit == 0, std::string("`musher set ") + state + "` ends with " +
                              std::to_string(exit) + " " + when);
  }
}

bool KnowsOther(const msg::MachineStatus& status) {
  return std::any_of(
      status.other_machines.begin(), status.other_machines.end(),
      [](const std::string& machine) { return machine.find(kOther) != std::string::npos; });
}

}  // namespace

void OuterLinkGoesDown(FaultRun& run) {
  run.MayBecome("Active");
  // The lease of a participant is 2 s with the lan profile.
  const auto time = run.random.Between(2500, 5000);
  run.Sampled("for", std::to_string(time) + " ms");
  Link& link = run.robot.far_host()->link();
  run.FaultInjected();
  link.LinkDown(false);
  ExpectObeys(run, "without the link");
  run.LetPass(Milliseconds(time));
  ExpectObeys(run, "without the link");
  run.FaultInjected(FaultRun::Clock::kRecovery);
  link.LinkUp(false);
  ExpectObeys(run, "after the link is back");
  run.ExpectOutcome(AwaitFuture(run.observer().SetState(run.state())), "done");
  run.RecoveredIn(run.state());
}

void OtherRobotInRange(FaultRun& run) {
  run.MayBecome("Active");
  const auto before = run.observer().GetStatus();
  run.Require(before.ok(), "the controller does not reply");
  // That of the last fault of this kind counts as in range for some seconds.
  const auto is_alone = [](const msg::MachineStatus& status) { return !KnowsOther(status); };
  run.Require(run.observer().Await(is_alone, kTimeout).has_value(),
              "another machine stays in range");
  run.FaultInjected();
  benchmark::Child other = run.robot.StartOther();
  run.Detected("another machine is in range", KnowsOther);
  run.Expect(run.robot.OtherMusher({"wait", "Active"}) == 0, "the other robot does not come up");
  ExpectObeys(run, "beside the other robot");
  run.Expect(run.robot.OtherMusher({"estop"}) == 0, "the other robot is not stopped");
  ExpectObeys(run, "while the other robot is stopped");
  Link& link = run.robot.far_host()->link();
  link.LinkDown(true);
  ExpectObeys(run, "without the other robot");
  link.LinkUp(true);
  // Its state folder keeps an engaged stop for its next start, in the next fault of this kind.
  run.Expect(run.robot.OtherMusher({"estop", "--release"}) == 0, "its stop is not released");
  run.Expect(run.robot.OtherMusher({"down"}) == 0, "the other robot is not torn down");
  run.Expect(other.Wait() == 0, "the other controller does not end as it should");
  const auto after = run.observer().GetStatus();
  run.Require(after.ok(), "the controller does not reply");
  run.Expect(after.value().pid == before.value().pid && after.value().epoch == before.value().epoch,
             "the controller was replaced");
  run.Expect(!after.value().emergency_stop, "the other robot's stop has stopped this one");
  run.FaultInjected(FaultRun::Clock::kRecovery);
  run.ExpectOutcome(AwaitFuture(run.observer().SetState(run.state())), "done");
  run.RecoveredIn(run.state());
}

}  // namespace musher::fault_injection::network
