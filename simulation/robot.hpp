#pragma once
// A whole robot in virtual time: the real shells and decision code of controllers and actuators, on
// the simulated network, with simulated hosts and processes. An operator's requests go directly to
// the leading controller.
//
// Threads: one.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/simulation/client.hpp"
#include "musher/simulation/permit_console.hpp"
#include "musher/simulation/simulated_controller.hpp"
#include "musher/simulation/simulated_processes.hpp"
#include "musher/simulation/simulated_systemds.hpp"
#include "musher/simulation/stop_client.hpp"
#include "musher/simulation/world_clock.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// Decides what the callback of an actuator's state does; called each time a callback begins.
using Script = std::function<Act(const std::string& actuator, const State& state)>;

class SimRobot {
 public:
  // The endpoints of the first controller and of the one that competes with it.
  static constexpr const char* kControllerEndpoints[] = {"controller", "rival"};

  SimRobot(std::uint64_t seed, MachineConfig config, Script script = {}, const Layout& layout = {});
  // Another machine in the network of `beside`, which must outlive it. Its layout counts the hosts
  // of both; its prefix and the names of its hosts must be others.
  SimRobot(SimRobot& beside, MachineConfig config, Script script, Layout layout);
  ~SimRobot();
  SimRobot(const SimRobot&) = delete;
  SimRobot& operator=(const SimRobot&) = delete;

  transport::sim::Network& network() { return network_; }
  Hosts& hosts() { return hosts_; }
  const Hosts& hosts() const { return hosts_; }
  const Layout& layout() const { return layout_; }
  SimulatedProcesses& processes() { return processes_; }
  const SimulatedProcesses& processes() const { return processes_; }
  // Null where no actuator of the config has a `host`.
  SimulatedSystemds* systemds() { return systemds_.get(); }
  const MachineConfig& config() const { return config_; }
  Duration age() const { return network_.now() - switched_on_; }
  MachineIdentity identity() const { return {config_.name, layout_.machine_id}; }
  // Whether the participant is, or was, a controller of this machine.
  bool IsController(transport::ParticipantId participant) const {
    return controllers_ever_.contains(participant);
  }

  void UseProgram(const std::string& name, SimulatedProcesses::Program program) {
    processes_.UseProgram(name, std::move(program));
  }

  // Each of these may be empty.
  // Before every step of a controller's decision code.
  std::function<void()> on_input;
  // Before a controller sends a command.
  std::function<void(const Machine&, const action::SendSwitch&)> on_send;
  // A controller has made a record.
  std::function<void(const action::Record&)> on_record;
  // The same, for the checker; before on_record.
  std::function<void(const SimulatedController&, const action::Record&)> on_record_of;
  // Before a controller starts a process.
  std::function<void(const SimulatedController&, const std::string& name)> on_start;
  // A controller begins to lead; an operator has started it, or a supervisor.
  std::function<void(const SimulatedController&, Starter)> on_begin;
  // A controller runs the power command.
  std::function<void()> on_power;
  // A release of the emergency stops was answered.
  std::function<void(const SimulatedController&, const Result<>&)> on_release_answered;
  // A controller writes a sample.
  std::function<void(const SimulatedController&, const std::string& topic, const msg::Bytes&)>
      on_write;
  // The battery, or another program in its place, publishes a sample.
  std::function<void(int percent, bool charging)> on_battery;
  // A console has given a permit to move with that stamp.
  std::function<void(Time stamp)> on_permit;
  // A sample of /clock.
  std::function<void(Time)> on_clock;
  // The body publishes a sample.
  std::function<void(std::int32_t motion)> on_motion;
  // Before a controller sends a signal.
  std::function<void(const SimulatedController&, std::int32_t pid)> on_signal;
  // Before a controller is killed.
  std::function<void(const SimulatedController&)> on_killed;

  // `listens`: how long it only listens for other controllers before it begins; this call waits for
  // that.
  void StartController(Duration listens = {});
  // The same without waiting.
  void LaunchController(std::size_t which, bool takeover, Duration listens,
                        Starter starter = Starter::kPerson);
  // Whether the first controller can be started: no controller leads, and none that still listens
  // holds the lock on its folder.
  bool MayStartFirst() const {
    return !has_controller() && !controllers_[0] && !(OneHost() && controllers_[1]);
  }
  bool OneHost() const { return layout_.controllers[0] == layout_.controllers[1]; }
  Duration ListenTime() const;  // how long the config makes it listen
  // Starts a second controller. On another host it listens for a second; then it takes over, or
  // refuses if it has received heartbeats of the first. On the same host the folder of the first is
  // locked: the second ends the first, or refuses.
  void StartRival(bool takeover);
  // A standby on the host of the second controller. Does nothing where a controller runs there, or
  // where the config has none.
  void StartStandby();
  // An operator starts the first controller with --takeover, on a host of its own.
  void TakeBack();
  void CrashController();  // kills all controllers
  void CrashLeader();      // kills the one that leads
  // Ends all processes of the host and resets its clock. Its systemd answers from BootHost() on.
  void RebootHost(std::size_t host);
  void BootHost(std::size_t host);
  void FreezeController();
  void ThawController();
  void StartActuator(const std::string& name) { processes_.Launch(name); }  // as an operator would
  void CrashActuator(const std::string& name);
  void FreezeActuator(const std::string& name) { processes_.Freeze(name); }
  void ThawActuator(const std::string& name) { processes_.Thaw(name); }
  bool IsAlive(const std::string& name) const { return processes_.IsAlive(name); }
  // The actuator publishes that state once, although it is not in it.
  void Lie(const std::string& name, const State& state) { processes_.Lie(name, state); }
  // Every write to the disks of the controllers fails, or works again.
  void FillDisk(bool full);
  // Writes to the disks of the controllers do not end, or all end now.
  void StallDisk(bool stalled);
  // The files of the controllers are removed, also those that a controller has open.
  void LoseFiles();
  // The controllers that run have noticed that, and save what they have again.
  void SaveAgain();
  // From its next start on, each controller finds another state folder of the machine that it may
  // not read.
  void AddUnreadFolder(std::uint64_t mark);
  // Whether a controller that starts now finds one that no request has answered.
  bool FindsUnreadFolder(const SimulatedController& controller) const;
  // From its next start on, each controller finds its state folder so.
  void SetFolderOpens(FolderOpens opens);
  // Another user starts the next controllers, with a state folder of their own; the first one
  // again, if this was done before. Kills the controllers that run.
  void ChangeUser();
  // The state folder of a controller that runs: that of its host and user.
  std::size_t FolderOf(const SimulatedController& controller) const {
    return 2 * controller.host() + (by_other_user_ ? 1 : 0);
  }
  // Changes the wall clocks of the controllers.
  void JumpWallClock(Duration by);

  // A panel engages an emergency stop; returns its id, which is one of the network where `id` is 0.
  // The panel stays available, and its last sample latched. `by`: the person there.
  StopId EngageEmergencyStop(StopId id, std::size_t panel = 0, const std::string& by = "a person");
  // A program on that host engages a stop, as `musher estop` does, over links with that delay and
  // loss, with that time for discovery at most. `named`: it names the machine, also where no
  // controller of this host does. Returns the machine that is meant, as far as it is known.
  struct StopLinks {
    Duration delay_most{};
    double loss = 0;
    Duration discovery_most{};
  };
  MachineIdentity EngageByProgram(StopId id, std::size_t host, const StopLinks& links, bool named);
  // They are all closed.
  void EndStopPrograms();
  // Such a program ends, with exit code 0 if `confirmed`. May be empty.
  std::function<void(StopId id, bool confirmed)> on_stop_program;
  // It has ended, and another one publishes the stop for a minute.
  bool StopStaysPublished(StopId id) const;
  // It publishes the stop no more. May be empty.
  std::function<void(StopId id)> on_stop_withdrawn;
  // The client on that host.
  Client& ClientOn(std::size_t host);
  std::vector<const Client::Request*> OpenRequests() const;
  // Publishes the battery's and the body's status from now on, once a second.
  void SetBattery(int percent, bool charging);
  // Publishes one sample, and goes on with the level of SetBattery().
  void GlitchBattery(int percent, bool charging);
  // The level that a second program publishes; nullopt: it ends.
  void SetOtherBattery(std::optional<int> percent);
  // Nothing publishes the battery, or what publishes it is back.
  void SetBatterySilent(bool silent) { battery_silent_ = silent; }
  std::optional<int> battery() const;  // %, as set
  void SetMotion(std::int32_t motion);
  // A console on that host gives permits to move, instead of the one before.
  void StartPermits(std::size_t host);
  void EndPermits();  // its program is killed
  const PermitConsole* permits() const { return permits_.get(); }
  // Something publishes /clock from now on.
  void StartClock();
  WorldClock* clock() { return clock_.get(); }  // null: nothing publishes it
  void ReleaseEmergencyStop();                  // by the controller, for an operator
  // An operator restarts an actuator; does not wait for it.
  void Restart(const std::string& name);
  // Requests a switch and waits; nothing when there is no controller, or no reply in time.
  std::optional<SwitchResult> Set(const State& target,
                                  const std::optional<std::string>& actuator = std::nullopt,
                                  Duration limit = std::chrono::minutes(10));

  bool RunUntil(const std::function<bool()>& done, Duration limit = std::chrono::minutes(10));
  void RunFor(Duration duration) { network_.RunFor(duration); }

  // The leading controller, of two the one with the higher epoch; else one that has stopped the
  // machine; null when there is none.
  SimulatedController* leader();
  const SimulatedController* leader() const { return const_cast<SimRobot*>(this)->leader(); }
  bool has_controller() const { return leader() != nullptr; }
  std::size_t leaders() const;  // without those that have stopped the machine
  // The first controller or the second one; null when it does not run.
  const SimulatedController* controller(std::size_t which) const {
    return controllers_[which].get();
  }
  const Machine& machine() const { return leader()->shell().machine(); }
  // The actuator's own report; nothing when its process does not run.
  std::optional<ActuatorReport> ReportOf(const std::string& name) const;
  // The same of the process that `followed` is from; when it does not run, of any.
  const ActuatorReport* ReportOf(ActuatorIndex actuator, const ActuatorReport& followed) const;
  std::vector<std::string> journal() const;  // the messages of its entries
  const std::vector<JournalRow>& recording() const { return disks_[0].recording; }
  const Disk& disk(std::size_t controller) const { return disks_[controller]; }
  Disk& disk(std::size_t controller) { return disks_[controller]; }

 private:
  // What runs on the host now.
  StopView ViewOf(std::size_t host) const;
  struct World {  // the network and the hosts of a machine that has its own
    World(std::uint64_t seed, const std::vector<std::string>& hosts)
        : network(seed), hosts(network, hosts) {}
    transport::sim::Network network;
    Hosts hosts;
  };
  // In `world`; without one, in the world of `beside`.
  SimRobot(std::unique_ptr<World> world, SimRobot* beside, MachineConfig config, Script script,
           Layout layout);
  void Open(std::size_t which);
  void EndController(std::size_t which);
  void KillController(std::size_t which);
  void TakeOverOnSameHost();
  Disk& DiskOf(std::size_t which) { return disks_[OneHost() ? 0 : which]; }
  void OpenBody();
  void PublishBody();
  void PublishBattery(transport::Publisher<msg::BmsStatus>& publisher,
                      const msg::BmsStatus& status);

  MachineConfig config_;
  const Layout layout_;
  std::array<MachineConfig, 2> configs_;  // as each controller reads it on its host
  const std::unique_ptr<World> world_;    // null: it is in the world of another machine
  transport::sim::Network& network_;
  Hosts& hosts_;
  Time switched_on_;
  std::unique_ptr<transport::Node> environment_;  // its loop runs what belongs to no process
  struct Panel {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button;
  };
  std::array<Panel, 2> panels_;
  SimulatedProcesses processes_;
  std::unique_ptr<SimulatedSystemds> systemds_;
  std::array<Disk, 2> disks_;
  bool by_other_user_ = false;
  std::array<std::unique_ptr<SimulatedController>, 2> controllers_;
  std::set<transport::ParticipantId> controllers_ever_;
  std::map<std::size_t, std::unique_ptr<Client>> clients_;  // by host
  std::map<StopId, std::unique_ptr<StopClient>> stop_programs_;
  std::array<transport::LoopHandlePtr, 2> begins_;
  transport::LoopHandlePtr takes_over_;
  std::optional<msg::BmsStatus> battery_;
  std::optional<msg::MotionStatus> motion_;
  std::optional<msg::BmsStatus> other_battery_;
  bool battery_silent_ = false;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> battery_publisher_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> other_battery_publisher_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> motion_publisher_;
  transport::LoopHandlePtr body_timer_;
  int consoles_ = 0;  // so far
  std::unique_ptr<PermitConsole> permits_;
  std::unique_ptr<WorldClock> clock_;
};

}  // namespace musher::simulation
