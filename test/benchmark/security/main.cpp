// What locking out unauthorized processes costs: the same machine of eight actuators without keys,
// with signed and with encrypted data. In turns, so that all three see the same machine.
//
//   benchmark_security [trials [switches [actuators]]]

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "musher/controller/machine_controller.hpp"
#include "musher/cyberdog/interfaces.hpp"
#include "musher/test/benchmark/common/child.hpp"
#include "musher/test/benchmark/common/fleet.hpp"
#include "musher/test/benchmark/common/statistics.hpp"
#include "musher/wire/security/authority.hpp"

namespace musher::benchmark {
namespace {

using Clock = std::chrono::steady_clock;
using transport::keys::Protection;
using transport::keys::Role;

double Milliseconds(Clock::time_point since) {
  return Microseconds(Clock::now() - since) / 1000;
}

struct Mode {
  std::string name;
  std::optional<Protection> protection;  // none: without keys

  // One value a trial.
  std::vector<double> up_ms = {};
  std::vector<double> switch_of_one_us = {};
  std::vector<double> switch_of_all_us = {};
  std::vector<double> first_ms = {};
};

void Must(const Result<>& result) {
  if (!result) Fail(result.error().message);
}

void MakeKeys(const Fleet& fleet, Protection protection) {
  const std::filesystem::path config = fleet.config_file();
  const transport::keys::KeyFolder folder(config.parent_path() / "keys");
  Must(CreateAuthority(folder, protection, false));
  const auto issue = [&folder](const std::string& name, Role role) {
    Must(Issue(folder, name, role, cyberdog::Interfaces(), {}));  // as `musher keys` does
  };
  issue("controller", Role::kController);
  for (const std::string& name : fleet.names()) issue(name, Role::kActuator);
}

// The median time of a switch to and fro, in µs.
double Switch(MachineController& controller, int switches) {
  std::vector<double> times;
  for (int i = -10; i < switches; ++i) {
    const auto begin = Clock::now();
    MustBeDone(controller.Switch((i & 1) == 0 ? kDeActive : kActive));
    if (i >= 0) times.push_back(Microseconds(Clock::now() - begin));
  }
  return Median(times);
}

// Starts a machine; gives the ms until all of it is Active.
double Up(const Fleet& fleet, MachineController& controller) {
  const auto begin = Clock::now();
  if (!controller.Init(fleet.config_file())) Fail("no controller");
  if (!controller.AwaitSetUp()) Fail("not all are set up");
  MustBeDone(controller.Switch("SelfCheck"));
  MustBeDone(controller.Switch("Active"));
  return Milliseconds(begin);
}

void Trial(Mode& mode, int number, int switches, int actuators) {
  for (const int count : {1, actuators}) {
    setenv("ROS_DOMAIN_ID", std::to_string(Domain(2 * number + (count == 1 ? 0 : 1))).c_str(), 1);
    const auto started = [](const Fleet&, const std::string& name) {
      return CommandKey({Program("benchmark_actuator"), name});
    };
    const Fleet fleet(started, count, mode.protection ? "[security]\nkeys = \"keys\"\n" : "");
    if (mode.protection) MakeKeys(fleet, *mode.protection);
    MachineController controller;
    const double up_ms = Up(fleet, controller);
    const double switch_us = Switch(controller, switches);
    if (count == 1) {
      mode.first_ms.push_back(up_ms);
      mode.switch_of_one_us.push_back(switch_us);
    } else {
      mode.up_ms.push_back(up_ms);
      mode.switch_of_all_us.push_back(switch_us);
    }
  }
}

void Main(int trials, int switches, int actuators) {
  std::array<Mode, 3> modes = {{{"without keys", std::nullopt},
                                {"signed", Protection::kSigned},
                                {"encrypted", Protection::kEncrypted}}};
  int number = 0;
  for (int i = 0; i < trials; ++i) {
    for (Mode& mode : modes) Trial(mode, number++, switches, actuators);
  }
  const std::string all = std::to_string(actuators);
  const Table table("What keys cost");
  const auto add_row = [&](const std::string& what, const std::string& unit,
                           std::vector<double> Mode::*values) {
    for (const Mode& mode : modes) table.Row(what + ", " + mode.name, mode.*values, unit);
    for (const Mode& mode : modes) {
      if (!mode.protection) continue;
      table.Row(what + ", " + mode.name + " / without keys", Ratios(mode.*values, modes[0].*values),
                "×");
    }
  };
  add_row("one warm switch of one actuator", "µs", &Mode::switch_of_one_us);
  add_row("one warm switch of " + all, "µs", &Mode::switch_of_all_us);
  add_row("from the start of one actuator until it is Active", "ms", &Mode::first_ms);
  add_row("from the start of " + all + " until all are Active", "ms", &Mode::up_ms);
}

}  // namespace
}  // namespace musher::benchmark

int main(int argc, char** argv) {
  const int trials = argc > 1 ? std::atoi(argv[1]) : 10;
  const int switches = argc > 2 ? std::atoi(argv[2]) : 200;
  const int actuators = argc > 3 ? std::atoi(argv[3]) : 8;
  musher::benchmark::Main(trials, switches, actuators);
}
