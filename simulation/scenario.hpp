#pragma once
// One life of a simulated robot: it is switched on, injected events befall it, they cease, it comes
// to rest, people repair what is left, and at last it is switched off. The same config, seed and
// injected events make the same life, to the byte.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/checker.hpp"
#include "musher/simulation/coverage.hpp"
#include "musher/simulation/injection.hpp"
#include "musher/simulation/invariant.hpp"
#include "musher/simulation/robot.hpp"

namespace musher::simulation {

struct ScenarioOptions {
  Duration bound{};      // in which the machine has to come to rest when faults have ceased
  State home;            // where people bring it back to
  bool provided = true;  // every loss has to be provided for
  bool shared_processes = false;  // some actuators run in the process of another
};

// What may be asked of a config: the longest chain of `after`, each link as slow as it may be, as
// often as anything may be restarted, and a minute; home is Active, or the most active state.
ScenarioOptions UsualOptions(const MachineConfig& config);

// How it went.
struct Ending {
  std::optional<Violation> violation;
  Coverage coverage;
  std::array<std::uint64_t, 5> switches{};  // by SwitchOutcome
  std::array<std::uint64_t, 3>
      client_ends{};  // of switches that clients asked for, by SwitchEnd::Kind
  std::array<std::uint64_t, 2> client_calls{};  // of clients: without an answer, with one
  std::uint64_t checks = 0;
  std::uint64_t steps = 0;         // events of the network
  Duration simulated{};            // how long the life was
  std::optional<Duration> rested;  // so long after the last fault had ceased
  std::uint64_t fingerprint = 0;   // of all that was told and done
};

class Scenario {
 public:
  // `config` must outlive it.
  Scenario(const MachineConfig& config, std::uint64_t seed, Injections injections,
           const ScenarioOptions& options);
  ~Scenario();

  // Something of the caller's stands behind an actuator, made anew with each process. `draw` says
  // what befalls its callback that begins. Before Tell().
  using Draw = std::function<Act(const State&)>;
  void UseModule(const std::string& actuator,
                 std::function<std::unique_ptr<Module>(const Draw& draw)> make);
  // Ends the scenario after the present event: the caller has seen enough.
  void EndNow() { seen_enough_ = true; }

  // Lives it. Once.
  Ending Tell();

  // What a listener may want to draw. Set before Tell().
  struct Listener {
    std::function<void(Time, const Injection&)> on_injection;
    std::function<void(Time, const std::string&)> on_repair;  // of the people who repair it
    std::function<void(Time, const action::Record&)> on_record;
    std::function<void(Time, const SimRobot&)> on_change;  // of anybody's state, maybe
  };
  Listener listener;

  const SimRobot& robot() const { return robot_; }

 private:
  struct FaultWindow {  // of an actuator's callbacks, until then
    Time hangs{};
    Time slow{};
    Time fails{};
  };
  // Something to be done at its time.
  struct TimedAction {
    Time at{};
    std::function<void()> what;
  };

  Act DrawAct(const std::string& name, const State& state);
  void SwitchOn();
  void Inject();
  void Cease();
  void Rest();
  void Repair();
  void SwitchOff();

  void Do(const Injection& injection);
  void Misconfigure(const std::string& name, Duration lasts);
  void DoToNetwork(const Injection& injection);
  void DoToController(const Injection& injection);
  void Ask(const State& target, const std::optional<std::string>& actuator = std::nullopt);
  void DoToPolicy(const Injection& injection);
  void AskPolicy(const event::PolicyRequested& asked);
  void ApplyNetworkFaults();
  void DoToHosts(const Injection& injection);
  void Reboot(std::size_t host, Duration lasts);
  void StartController(bool restarted = false);
  void DoToStops(const Injection& injection);
  void DoByClient(const Injection& injection);
  void Engage(std::size_t panel, std::uint64_t id);
  void StartByHand(std::size_t actuator);
  // Started by hand, in a process of its own.
  bool IsByHand(std::size_t actuator) const;
  MachinePhase Now() const;
  void Later(Duration delay, std::function<void()> what);
  // Lets time pass; stops early at a violation.
  bool RunUntil(const std::function<bool()>& done, Duration limit);
  void RunFor(Duration duration);
  bool Over() const { return seen_enough_ || checker_.violation().has_value(); }

  bool ComeToRest(const std::string& when);
  void RepairActuators();
  bool EndSurplus();
  void EndElsewhere(const ActuatorConfig& actuator);
  bool BringHome();
  void CheckWhole();
  void Note(const std::string& action);
  void Mix(const std::string& text);

  const MachineConfig& config_;
  const std::uint64_t seed_;
  const Injections injections_;
  const ScenarioOptions options_;
  const bool supervised_;  // a supervisor restarts the controller
  Duration patience_{};    // how long an injected event waits for its moment
  Ending ending_;
  bool seen_enough_ = false;
  std::vector<FaultWindow> fault_windows_;
  std::vector<std::uint64_t> runs_;        // of callbacks, by actuator
  std::array<int, 4> network_troubles_{};  // under way: loss, delay, duplication, reordering
  std::vector<TimedAction> later_;
  SimRobot robot_;
  Checker checker_;
};

// All drawn from the seed.
Ending RunScenario(const MachineConfig& config, std::uint64_t seed, const Injections& injections,
                   const ScenarioOptions& options);

}  // namespace musher::simulation
