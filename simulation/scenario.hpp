#pragma once
// One run of a simulated robot: it is switched on, events are injected, the faults end, it reaches
// a stable state, an operator repairs what is still degraded, and it is switched off. The same
// config, seed and injected events give the same run, to the byte.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/simulation/bridge.hpp"
#include "musher/simulation/checker.hpp"
#include "musher/simulation/coverage.hpp"
#include "musher/simulation/injection.hpp"
#include "musher/simulation/invariant.hpp"
#include "musher/simulation/other_machine.hpp"
#include "musher/simulation/robot.hpp"
#include "musher/transport/sim/random.hpp"

namespace musher::simulation {

struct ScenarioOptions {
  Duration bound{};               // within which the machine must be stable after the last fault
  State home;                     // the state to which the operator recovers the machine
  bool provided = true;           // the config's on_lost must cover every lost actuator
  bool shared_processes = false;  // some actuators run in the process of another
  bool bridges = false;           // some networks have a bridge that repeats old samples
  UserRules rules = {};           // of the user
};

// The default options for a config. The bound is a minute plus the longest chain of `after`, with
// each callback at its time limit, as often as any actuator may be restarted. Home is Active, or
// the most active state.
ScenarioOptions UsualOptions(const MachineConfig& config);

// The outcome of a scenario.
struct ScenarioEnd {
  std::optional<Violation> violation;
  Coverage coverage;
  std::array<std::uint64_t, 5> switches{};  // by SwitchOutcome
  std::array<std::uint64_t, 3>
      client_ends{};  // of switches that clients requested, by SwitchEnd::Kind
  std::array<std::uint64_t, 2> client_calls{};   // of clients: without a reply, with one
  std::array<std::uint64_t, 2> stop_programs{};  // with another exit code, with exit code 0
  std::uint64_t checks = 0;
  std::uint64_t steps = 0;         // events of the network
  Duration simulated{};            // how long the run was, in virtual time
  std::optional<Duration> rested;  // how long after the last fault the machine was stable
  std::uint64_t fingerprint = 0;   // of all records and replies
  UserRulesCoverage rule_coverage;
};

class Scenario {
 public:
  // `config` must outlive it.
  Scenario(const MachineConfig& config, std::uint64_t seed, Injections injections,
           const ScenarioOptions& options);
  ~Scenario();

  // Puts a module of the caller behind an actuator; each process makes one. `sample_act` samples
  // how a callback that begins will end. To be called before Run().
  using ActSampler = std::function<Act(const State&)>;
  void UseModule(const std::string& actuator,
                 std::function<std::unique_ptr<Module>(const ActSampler& sample_act)> make);
  // Ends the scenario after the current event.
  void EndNow() { end_now_ = true; }

  // Call once.
  ScenarioEnd Run();

  // Observes the run. Set before Run().
  struct Listener {
    std::function<void(Time, const Injection&)> on_injection;
    std::function<void(Time, const std::string&)> on_repair;  // an action of the operator
    std::function<void(Time, const action::Record&)> on_record;
    std::function<void(Time, const SimRobot&)> on_change;  // a state may have changed
  };
  Listener listener;

  const SimRobot& robot() const { return robot_; }

 private:
  struct FaultWindow {  // the ends of the faults of an actuator's callbacks
    Time hangs{};
    Time slow{};
    Time fails{};
  };
  struct TimedAction {
    Time at{};
    std::function<void()> what;
  };

  Act SampleAct(const std::string& name, const State& state);
  void SwitchOn();
  void Inject();
  void EndFaults();
  void AwaitStableState();
  void Repair();
  void RestartBeforeTheEnd();
  void SwitchOff();

  void Apply(const Injection& injection);
  void NoteCrash(ActuatorIndex process);
  void Misconfigure(const std::string& name, Duration lasts);
  void ApplyToNetwork(const Injection& injection);
  void ApplyToController(const Injection& injection);
  void RequestSwitch(const State& target,
                     const std::optional<std::string>& actuator = std::nullopt);
  void ApplyToPolicy(const Injection& injection);
  void ApplyToBattery(const Injection& injection);
  void WalkBattery(transport::sim::Random random, Time until);
  void RequestPolicy(const event::PolicyRequested& requested);
  void ApplyNetworkFaults();
  void ApplyToHosts(const Injection& injection);
  void Reboot(std::size_t host, Duration lasts);
  void StartController(Starter starter = Starter::kPerson);
  void ApplyToStops(const Injection& injection);
  void ApplyAround(const Injection& injection);
  void MeetOtherMachine(const Injection& injection);
  void EngageByProgram(const Injection& injection);
  void NoteForOther(std::size_t number);
  void EngageMany(transport::sim::Random random);
  void EngageNext(std::size_t panel, StopId id, bool one_source, int left);
  void ReleaseLater(const Injection& injection);
  void AwaitOtherMachine();
  void ApplyByClient(const Injection& injection);
  void ChangeUser(const Injection& injection);
  void ApplyToPermits(const Injection& injection);
  void ApplyToClock(const Injection& injection);
  // The console gives permits again, and /clock runs.
  void StartPermits();
  void RestoreWorld();
  void Engage(std::size_t panel, StopId id, const std::string& by = "a person");
  void StartByHand(ActuatorIndex actuator);
  // Whether it is started by hand, in a process of its own.
  bool IsByHand(ActuatorIndex actuator) const;
  MachinePhase Now() const;
  void Later(Duration delay, std::function<void()> what);
  // Runs in virtual time; stops early at a violation.
  bool RunUntil(const std::function<bool()>& done, Duration limit);
  void RunFor(Duration duration);
  bool Over() const { return end_now_ || violation().has_value(); }
  const std::optional<Violation>& violation() const;

  bool ReachStableState(const std::string& when);
  void EndTornDown();
  void RepairActuators();
  bool EndFrozen();
  bool EndSurplus();
  void EndElsewhere(const ActuatorConfig& actuator);
  bool RecoverHome();
  void CheckAllAvailable();
  void Note(const std::string& action);
  void Mix(const std::string& text);

  const MachineConfig& config_;
  const std::uint64_t seed_;
  const Injections injections_;
  const ScenarioOptions options_;
  const bool supervised_;     // a supervisor restarts the controller
  Duration phase_timeout_{};  // how long an injected event waits for its phase
  ScenarioEnd ending_;
  bool end_now_ = false;
  std::size_t console_host_ = 0;  // of the console that gives permits
  PerActuator<FaultWindow> fault_windows_;
  PerActuator<std::uint64_t> callback_runs_;  // by actuator
  std::array<int, 4> network_faults_{};       // active: loss, delay, duplication, reordering
  std::vector<TimedAction> later_;
  SimRobot robot_;
  Checker checker_;
  struct ProgramStop {
    StopId id = 0;
    MachineIdentity meant;  // as far as the program knows it
  };
  std::vector<ProgramStop> program_stops_;  // so far
  std::unique_ptr<OtherMachine> other_;     // null until it comes into range
  std::unique_ptr<Bridge> bridge_;
};

// Runs a scenario with everything sampled from the seed.
ScenarioEnd RunScenario(const MachineConfig& config, std::uint64_t seed,
                        const Injections& injections, const ScenarioOptions& options);

}  // namespace musher::simulation
