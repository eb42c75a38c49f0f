// A process ends, by a signal or by itself.

#include <signal.h>

#include "musher/test/fault_injection/faults/expectation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"

namespace musher::fault_injection::process {
namespace {

std::vector<std::string> AllActuators() {
  std::vector<std::string> names;
  for (const Member& member : Members()) names.push_back(member.name);
  return names;
}

// Only the parent knows an exit code; an end without a known code counts as a failure.
Loss LossAsSeen(FaultRun& run, const std::string& victim, Loss loss) {
  return run.robot.IsChildOfController(victim) ? loss : Loss::kFailure;
}

// An exit with code 0 is not a crash.
Observer::Is HasEnded(const std::string& victim) {
  return [victim](const msg::MachineStatus& status) {
    const msg::ActuatorInfo& info = Find(status, victim);
    return info.health == "crashed" || info.presence != "present" || info.restarts > 0;
  };
}

void Signal(FaultRun& run, const std::string& victim, int signal, Loss loss) {
  const pid_t pid = run.robot.PidOf(victim);
  loss = LossAsSeen(run, victim, loss);
  run.FaultInjected();
  kill(pid, signal);
  const bool clean = loss == Loss::kClean;
  run.Detected(victim + " has ended", clean ? HasEnded(victim) : IsKnownAs(victim, "crashed"));
  AwaitExpectation(run, victim, loss);
}

void EndByItself(FaultRun& run, End end, Loss loss) {
  const std::string victim = run.Victim(Modules());
  loss = LossAsSeen(run, victim, loss);
  run.FaultInjected();
  run.robot.board(victim).end = end;
  run.Detected(victim + " has ended", HasEnded(victim));
  ClearFaults(run.robot.board(victim));
  AwaitExpectation(run, victim, loss);
}

}  // namespace

void Killed(FaultRun& run) {
  Signal(run, run.Victim(AllActuators()), SIGKILL, Loss::kFailure);
}

void Terminated(FaultRun& run) {
  const std::string victim = run.Victim(AllActuators());
  // musher-exec ends its program and exits with code 0, and so does a ROS 2 node: not a failure.
  const bool clean = MemberOf(victim).wrapped || MemberOf(victim).ros2;
  Signal(run, victim, SIGTERM, clean ? Loss::kClean : Loss::kFailure);
}

void SeveralKilled(FaultRun& run) {
  std::vector<std::string> restarted = {"legs", "arm", "eyes", "hands", "voice"};
  run.random.Shuffle(restarted);
  restarted.resize(static_cast<std::size_t>(run.random.Between(2, 5)));
  std::vector<pid_t> pids;
  for (const std::string& victim : restarted) {
    run.MayBeAffected(victim);
    run.Sampled("victim", victim);
    pids.push_back(run.robot.PidOf(victim));
  }
  run.FaultInjected();
  for (const pid_t pid : pids) kill(pid, SIGKILL);
  run.Detected("all of them have crashed", [&](const msg::MachineStatus& status) {
    return std::all_of(restarted.begin(), restarted.end(), [&](const std::string& victim) {
      return Find(status, victim).health == "crashed";
    });
  });
  run.RecoveredIn(run.state());
}

void Exits(FaultRun& run, int code) {
  for (const std::string& name : Modules()) run.robot.board(name).exit_code = code;
  EndByItself(run, End::kExit, code == 0 ? Loss::kClean : Loss::kFailure);
}

void Aborts(FaultRun& run) {
  EndByItself(run, End::kAbort, Loss::kFailure);
}

void Segfaults(FaultRun& run) {
  EndByItself(run, End::kSegfault, Loss::kFailure);
}

}  // namespace musher::fault_injection::process
