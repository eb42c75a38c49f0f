#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <thread>

#include "musher/base/host.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/observed_controller.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/test/benchmark/health/hand_started.hpp"
#include "musher/test/benchmark/health/parts.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::benchmark {
namespace {

constexpr int kVictims = 8;

// A pid namespace counts as a host of its own: pids of one mean nothing in the other, so only
// messages report an exit. Its init is the given program.
std::vector<std::string> OnOtherHost(std::vector<std::string> argv) {
  std::vector<std::string> whole = {"/usr/bin/unshare", "--pid", "--fork", "--mount-proc",
                                    "--kill-child"};
  if (geteuid() != 0) whole.insert(whole.end(), {"--user", "--map-root-user"});
  whole.insert(whole.end(), argv.begin(), argv.end());
  return whole;
}

// Pids of this namespace, by the board files of the modules.
std::map<std::string, pid_t> FindModules() {
  std::map<std::string, pid_t> found;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream file(entry.path() / "cmdline");
    std::string program;
    std::string name;
    std::string board;
    std::getline(file, program, '\0');
    std::getline(file, name, '\0');
    std::getline(file, board, '\0');
    if (program == Program("benchmark_module")) {
      found[board] = std::atoi(entry.path().filename().c_str());
    }
  }
  return found;
}

// Actuators of the fleet on a host of their own, for as long as this object exists.
class Host {
 public:
  Host(const Fleet& fleet, const std::vector<ActuatorIndex>& actuators) {
    std::string script;
    for (const ActuatorIndex actuator : actuators) {
      const std::string& name = fleet.names()[actuator.value()];
      for (const std::string& word : fleet.Module(name, 0)) script += "'" + word + "' ";
      script += "& ";
      locks_.push_back(NameLock::NameOf(transport::DomainId({}).value(), "", name));
    }
    child_ = std::make_unique<Child>(OnOtherHost({"/bin/sh", "-c", script + "wait"}),
                                     Child::Environment{{"MUSHER_CONFIG", fleet.config_file()}});
  }
  // Waits until the names of all are free. (A process that is exiting has no command line any more,
  // and may still hold its name.)
  ~Host() {
    child_ = nullptr;
    while (std::any_of(locks_.begin(), locks_.end(), NameLock::IsHeld)) {
      std::this_thread::sleep_for(Milliseconds(5));
    }
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

 private:
  std::vector<std::string> locks_;
  std::unique_ptr<Child> child_;
};

struct Verdicts {
  std::vector<double> times;  // milliseconds
  double wrong = 0;
};

// Kills the victims one after the other; they are known as crashed when others of their host live.
void KillAll(ObservedController& controller, const Fleet& fleet, Health expected,
             Verdicts& verdicts) {
  const std::map<std::string, pid_t> pids = FindModules();
  for (ActuatorIndex i = 0; i < kVictims; ++i) {
    auto known = controller.Next([i](const action::Record& record, const Machine& machine) {
      return record.actuator == i && machine.actuators[i].presence == Presence::kLost;
    });
    const Time killed = std::chrono::steady_clock::now();
    kill(pids.at(fleet.BoardFile(fleet.names()[i.value()])), SIGKILL);
    verdicts.times.push_back(ToSeconds(MomentOf(known, "a remote crash") - killed) * 1000);
    if (controller.Snapshot().actuators[i].health != expected) ++verdicts.wrong;
  }
}

void Print(const Table& table, const std::string& what, const Verdicts& verdicts) {
  table.Row(what, verdicts.times, "ms", 500);
  table.Row(what + ", p99", {Quantile(verdicts.times, 0.99)}, "ms", 1000);
  table.Row(what + ": other verdicts", {verdicts.wrong}, "");
}

}  // namespace

void Remote(int rounds) {
  if (Child(OnOtherHost({"/bin/true"}), {}, Child::Output::kNowhere).Wait() != 0) {
    std::printf("\nremote: skipped, this user may not make a pid namespace (unshare)\n");
    return;
  }
  // The last one survives.
  const Fleet fleet([](const Fleet&, const std::string&) { return kUnlimitedRestartKeys; },
                    kVictims + 1, "[transport]\nprofile = \"lan\"\n");
  std::vector<ActuatorIndex> all;
  for (ActuatorIndex i = 0; i <= kVictims; ++i) all.push_back(i);
  ObservedController controller(fleet.config_file());
  Verdicts crashed;
  Verdicts partitioned;
  for (int round = 0; round < rounds; ++round) {
    {
      const Host host(fleet, all);
      controller.AwaitAllThere();
      KillAll(controller, fleet, Health::kCrashed, crashed);
    }
    std::vector<std::unique_ptr<Host>> hosts;
    for (const ActuatorIndex actuator : all) {
      hosts.push_back(std::make_unique<Host>(fleet, std::vector<ActuatorIndex>{actuator}));
    }
    controller.AwaitAllThere();
    KillAll(controller, fleet, Health::kPartitioned, partitioned);
  }
  const Table table("kill -9 → on record, on another host");
  Print(table, "with others on its host (crashed)", crashed);
  Print(table, "alone on its host (partitioned)", partitioned);
}

}  // namespace musher::benchmark
