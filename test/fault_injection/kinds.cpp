#include "musher/test/fault_injection/kind.hpp"

#include <cctype>

#include "musher/test/fault_injection/faults/callback.hpp"
#include "musher/test/fault_injection/faults/controller.hpp"
#include "musher/test/fault_injection/faults/network.hpp"
#include "musher/test/fault_injection/faults/operation.hpp"
#include "musher/test/fault_injection/faults/process.hpp"
#include "musher/test/fault_injection/faults/resource.hpp"

namespace musher::fault_injection {
namespace {

void AddProcess(std::vector<Kind>& kinds) {
  using namespace process;
  const auto add = [&](const char* name, const char* about, std::function<void(FaultRun&)> inject) {
    kinds.push_back({name, "process", about, std::move(inject)});
  };
  const auto exits = [](int code) { return [code](FaultRun& run) { Exits(run, code); }; };
  add("kill", "SIGKILL", Killed);
  add("kill-several", "SIGKILL of two to five at once", SeveralKilled);
  add("term", "SIGTERM", Terminated);
  add("stop-long", "SIGSTOP until it is reported as hung", StoppedForLong);
  add("stop-short", "SIGSTOP and SIGCONT within its limit", StoppedShortly);
  add("exit-0", "exits with code 0", exits(0));
  add("exit-1", "exits with code 1", exits(1));
  add("exit-77", "exits with code 77", exits(77));
  add("abort", "calls abort()", Aborts);
  add("segfault", "a segmentation fault", Segfaults);
  add("crash-loop", "exits in each SetUp until it is given up", CrashesRepeatedly);
  add("wrapped-kill", "SIGKILL of the program in a musher-exec", WrappedProgramKilled);
}

// "hang-self-check" for SelfCheck.
std::string Hyphenated(const std::string& prefix, const std::string& state) {
  std::string name = prefix;
  for (const char c : state) {
    if (std::isupper(static_cast<unsigned char>(c))) name += '-';
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return name;
}

void AddCallback(std::vector<Kind>& kinds) {
  using namespace callback;
  for (const std::string state : kStates) {
    kinds.push_back({Hyphenated("hang", state), "callback",
                     "the callback of " + state + " does not return",
                     [state](FaultRun& run) { Hangs(run, state); }});
  }
  for (const std::string state : kStates) {
    kinds.push_back({Hyphenated("fail", state), "callback", "the callback of " + state + " fails",
                     [state](FaultRun& run) { Fails(run, state); }});
  }
  kinds.push_back({"silent-thread", "callback", "the work thread stops its checkpoints",
                   ThreadStopsCheckpoints});
}

void AddResource(std::vector<Kind>& kinds) {
  using namespace resource;
  const auto add = [&](const char* name, const char* about, std::function<void(FaultRun&)> inject,
                       Need need = Need::kNothing) {
    kinds.push_back({name, "resource", about, std::move(inject), Shape::kHere, need});
  };
  add("cpu-busy", "other processes keep all cores busy", CoresAreBusy);
  add("memory-limit", "a module allocates more memory than its limit", MemoryIsLimited);
  add("disk-full", "the disk of the state folder is full", DiskIsFull, Need::kMounts);
  add("file-size-limit", "RLIMIT_FSIZE of the controller", FileSizeIsLimited);
  add("files-limit", "RLIMIT_NOFILE of the controller, and a crash", FilesAreLimited);
  add("state-vanished", "the state folder is removed", StateFolderVanishes);
  add("state-read-only", "a controller starts on a read-only disk", StateFolderIsReadOnly,
      Need::kMounts);
  add("disk-stalls-estop", "the disk stalls, and an emergency stop is engaged", DiskStallsAndStops);
  add("disk-stalls-switch", "the disk stalls, and a switch", DiskStallsInSwitch);
  add("disk-stalls-kill", "the disk stalls, and SIGKILL of a module", DiskStallsAndKills);
  add("disk-stalls-stop", "the disk stalls, and the machine is torn down", DiskStallsAndTearsDown);
  add("disk-stalls-long", "the disk stalls for 12 s", DiskStallsForLong);
}

void AddController(std::vector<Kind>& kinds) {
  using namespace controller;
  const auto add = [&](const char* name, const char* about, std::function<void(FaultRun&)> inject) {
    kinds.push_back({name, "controller", about, std::move(inject)});
  };
  const auto at = [](SwitchPhase phase) {
    return [phase](FaultRun& run) { KilledAt(run, phase); };
  };
  add("controller-kill", "SIGKILL at rest", at(SwitchPhase::kAtRest));
  add("kill-requested", "SIGKILL as a switch is requested", at(SwitchPhase::kRequested));
  add("kill-commands-out", "SIGKILL as the first actuator begins", at(SwitchPhase::kCommandsOut));
  add("kill-some-replied", "SIGKILL as the first actuator is done", at(SwitchPhase::kSomeReplied));
  add("kill-in-self-check", "SIGKILL in a self-check", at(SwitchPhase::kSelfCheck));
  add("kill-in-rollback", "SIGKILL while a switch is undone", at(SwitchPhase::kRollback));
  add("kill-in-start-up", "SIGKILL while the robot starts", KilledInStartUp);
  add("kill-in-stop", "SIGKILL while the robot is torn down", KilledInStop);
  add("freeze-short", "SIGSTOP and SIGCONT, soon", FrozenShortly);
  add("freeze-long", "the same, beyond controller_lost_ms of the actuators", FrozenForLong);
  add("second-refused", "a second controller", SecondIsRefused);
  add("takeover", "a second controller with --takeover", TakenOver);
  add("takeover-frozen", "the same, while the first is frozen", TakenOverFrozen);
  add("takeover-in-switch", "the same during a switch", TakenOverInSwitch);
  add("stop-in-switch", "SIGTERM during a switch", StoppedInSwitch);
}

void AddOperation(std::vector<Kind>& kinds) {
  using namespace operation;
  const auto add = [&](const char* name, const char* about, std::function<void(FaultRun&)> inject) {
    kinds.push_back({name, "operation", about, std::move(inject)});
  };
  add("estop", "an emergency stop at rest", EmergencyStopAtRest);
  add("estop-in-switch", "an emergency stop in a switch up", EmergencyStopInSwitch);
  add("supersede", "Error requested during a switch", Superseded);
  add("many-calls", "four switches are requested at once", ManyCalls);
}

void AddNetwork(std::vector<Kind>& kinds) {
  using namespace network;
  const auto add = [&](const char* name, const char* about, std::function<void(FaultRun&)> inject,
                       Shape shape = Shape::kTwoHosts) {
    kinds.push_back({name, "network", about, std::move(inject), shape, Need::kNetwork});
  };
  add("loss", "2 to 50 % of packets are lost each way, and a switch", LosesPackets);
  add("delay", "5 to 100 ms each way, and switches", IsSlow);
  add("duplicates", "packets are duplicated, and switches", DoublesPackets);
  add("reordering", "packets are reordered, and switches", ReordersPackets);
  add("partition", "the link is cut", IsCut);
  add("one-way-deaf", "the actuators receive nothing, for less than a DDS lease",
      [](FaultRun& run) { IsDeaf(run, false); });
  add("one-way-deaf-long", "the same for longer", [](FaultRun& run) { IsDeaf(run, true); });
  add("one-way-mute", "nothing is received from the actuators", IsMute);
  add("partition-in-switch", "the link is cut during a switch", IsCutInSwitch);
  add("link-down", "an interface goes down and up", LinkGoesDown);
  add("stop-without-link", "the robot is torn down while an interface is down", StoppedWithoutLink);
  add("far-reboot", "the other host reboots, five times", IsRebooted);
  add("far-takeover", "a controller on the other host with --takeover, and back",
      [](FaultRun& run) { IsTakenOverFromThere(run, false); });
  add("far-takeover-deaf", "the same while the other host receives nothing from this one",
      [](FaultRun& run) { IsTakenOverFromThere(run, true); });
  add(
      "far-standby", "the link to the standby and all actuators is cut, short and long",
      [](FaultRun& run) { IsReplacedByStandby(run, false); }, Shape::kStandby);
  add(
      "far-standby-kill", "the controller is killed beside a standby of the other host",
      [](FaultRun& run) { IsReplacedByStandby(run, true); }, Shape::kStandby);
  add("far-kill", "SIGKILL on the other host", KilledOnOtherHost);
  add("outer-link-down", "the interface to other hosts goes down, the whole robot is here",
      OuterLinkGoesDown, Shape::kOnLan);
  add("other-robot", "another robot comes into range, is stopped, and is torn down",
      OtherRobotInRange, Shape::kOnLan);
}

}  // namespace

const std::vector<Kind>& AllKinds() {
  static const std::vector<Kind> kinds = [] {
    std::vector<Kind> all;
    AddProcess(all);
    AddCallback(all);
    AddResource(all);
    AddController(all);
    AddOperation(all);
    AddNetwork(all);
    return all;
  }();
  return kinds;
}

const Kind* FindKind(const std::string& name) {
  for (const Kind& kind : AllKinds()) {
    if (kind.name == name) return &kind;
  }
  return nullptr;
}

}  // namespace musher::fault_injection
