// It ends: by a signal from outside, or by itself.

#include <signal.h>

#include "musher/test/campaign/faults/process.hpp"
#include "musher/test/campaign/faults/promise.hpp"

namespace musher::campaign::process {
namespace {

std::vector<std::string> Everybody() {
  std::vector<std::string> names;
  for (const Member& member : Crew()) names.push_back(member.name);
  return names;
}

// An exit code is told to the parent alone; an end that nobody can explain is a failure.
Loss AsSeen(Trial& trial, const std::string& victim, Loss loss) {
  return trial.robot.IsChildOfController(victim) ? loss : Loss::kFailure;
}

void Signal(Trial& trial, const std::string& victim, int signal, Loss loss) {
  const pid_t pid = trial.robot.PidOf(victim);
  loss = AsSeen(trial, victim, loss);
  trial.Struck();
  kill(pid, signal);
  trial.Detected(victim + " has crashed", IsKnownAs(victim, "crashed"));
  AwaitPromise(trial, victim, loss);
}

void EndByItself(Trial& trial, End end, Loss loss) {
  const std::string victim = trial.Victim(Modules());
  loss = AsSeen(trial, victim, loss);
  trial.Struck();
  trial.robot.board(victim).end = end;
  // An orderly end is no crash.
  trial.Detected(victim + " has ended", [&victim](const msg::MachineStatus& status) {
    const msg::ActuatorInfo& info = Find(status, victim);
    return info.health == "crashed" || info.presence != "present" || info.restarts > 0;
  });
  Relieve(trial.robot.board(victim));
  AwaitPromise(trial, victim, loss);
}

}  // namespace

void Killed(Trial& trial) {
  Signal(trial, trial.Victim(Everybody()), SIGKILL, Loss::kFailure);
}

void Terminated(Trial& trial) {
  const std::string victim = trial.Victim(Everybody());
  // musher-exec ends its program and itself in order, which is no failure.
  Signal(trial, victim, SIGTERM, MemberOf(victim).wrapped ? Loss::kClean : Loss::kFailure);
}

void SeveralKilled(Trial& trial) {
  std::vector<std::string> restarted = {"legs", "arm", "eyes", "hands", "voice"};
  trial.random.Shuffle(restarted);
  restarted.resize(static_cast<std::size_t>(trial.random.Between(2, 5)));
  std::vector<pid_t> pids;
  for (const std::string& victim : restarted) {
    trial.MayBeHurt(victim);
    trial.Drawn("victim", victim);
    pids.push_back(trial.robot.PidOf(victim));
  }
  trial.Struck();
  for (const pid_t pid : pids) kill(pid, SIGKILL);
  trial.Detected("all of them have crashed", [&](const msg::MachineStatus& status) {
    return std::all_of(restarted.begin(), restarted.end(), [&](const std::string& victim) {
      return Find(status, victim).health == "crashed";
    });
  });
  trial.RecoveredIn(trial.state());
}

void Exits(Trial& trial, int code) {
  for (const std::string& name : Modules()) trial.robot.board(name).exit_code = code;
  EndByItself(trial, End::kExit, code == 0 ? Loss::kClean : Loss::kFailure);
}

void Aborts(Trial& trial) {
  EndByItself(trial, End::kAbort, Loss::kFailure);
}

void Segfaults(Trial& trial) {
  EndByItself(trial, End::kSegfault, Loss::kFailure);
}

}  // namespace musher::campaign::process
