#pragma once
// A whole robot in virtual time: the real shells and decision code of controllers and actuators, on
// the simulated network, with simulated hosts and processes. People who ask for something are at
// the controller that leads.
//
// Threads: one.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/protocol/device.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/simulation/client.hpp"
#include "musher/simulation/controller_process.hpp"
#include "musher/simulation/processes.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::simulation {

// What the callback of an actuator's state does, asked each time it begins.
using Script = std::function<Act(const std::string& actuator, const State& state)>;

class SimRobot {
 public:
  // The endpoint of the first controller, and of one that competes with it.
  static constexpr const char* kControllerEndpoints[] = {"controller", "rival"};

  SimRobot(std::uint64_t seed, MachineConfig config, Script script = {}, Layout layout = {});
  ~SimRobot();
  SimRobot(const SimRobot&) = delete;
  SimRobot& operator=(const SimRobot&) = delete;

  transport::sim::Network& network() { return network_; }
  Hosts& hosts() { return hosts_; }
  const Hosts& hosts() const { return hosts_; }
  const Layout& layout() const { return layout_; }
  Processes& processes() { return processes_; }
  const Processes& processes() const { return processes_; }
  const MachineConfig& config() const { return config_; }
  Duration age() const { return network_.now() - switched_on_; }

  void UseProgram(const std::string& name, Processes::Program program) {
    processes_.UseProgram(name, std::move(program));
  }

  // Told of every step of a controller's decision code, before it; may be empty.
  std::function<void()> on_input;
  // Told of every command of a controller, before it is sent; may be empty.
  std::function<void(const Machine&, const action::SendSwitch&)> on_send;
  // Told of every record of any controller; may be empty.
  std::function<void(const action::Record&)> on_record;
  // Told of every process that a controller starts, before it does; may be empty.
  std::function<void(const ControllerProcess&, const std::string& name)> on_start;
  // A controller that a person has started begins to lead; may be empty.
  std::function<void()> on_person_starts;
  // Told of every power command; may be empty.
  std::function<void()> on_power;
  // Told of every sample that a controller writes; may be empty.
  std::function<void(const ControllerProcess&, const std::string& topic, const msg::Bytes&)>
      on_write;
  // Told of every signal that a controller sends, before it does; may be empty.
  std::function<void(const ControllerProcess&, std::int32_t pid)> on_signal;
  // Told of every controller that is killed, before it is; may be empty.
  std::function<void(const ControllerProcess&)> on_killed;

  // `listens`: so long it only listens, as one that may have rivals on other hosts does; this call
  // waits for the end of that.
  void StartController(Duration listens = {});
  // The same without waiting.
  // `restarted`: by a supervisor.
  void LaunchController(std::size_t which, bool takeover, Duration listens, bool restarted = false);
  bool OneHost() const { return layout_.controllers[0] == layout_.controllers[1]; }
  Duration ListenTime() const;  // how long one has to by the config
  // Another one. On another host it listens for a second; then it takes the machine over, or
  // refuses to if it has heard the first. On the same host it finds the folder of the first locked:
  // it ends the first, or refuses.
  void StartRival(bool takeover);
  void CrashController();  // those that there are
  // All processes there end, and its clock begins again.
  void RebootHost(std::size_t host);
  void FreezeController();
  void ThawController();
  void StartActuator(const std::string& name) { processes_.Launch(name); }  // as a person would
  void CrashActuator(const std::string& name);
  void FreezeActuator(const std::string& name) { processes_.Freeze(name); }
  void ThawActuator(const std::string& name) { processes_.Thaw(name); }
  bool IsAlive(const std::string& name) const { return processes_.IsAlive(name); }
  // The actuator says that it is in that state, once; it is not.
  void Lie(const std::string& name, const State& state) { processes_.Lie(name, state); }
  // The disks of the controllers take nothing more, or do again.
  void FillDisk(bool full);
  // What is written to the disks of the controllers does not end, or ends now.
  void StallDisk(bool stalled);
  // The wall clocks of the controllers jump.
  void JumpWallClock(Duration by);

  // A panel engages an emergency stop. It lives on, and so does what it has said last.
  void EngageEmergencyStop(std::uint64_t id, std::size_t panel = 0);
  // The client of that host.
  Client& ClientOn(std::size_t host);
  std::vector<const Client::Request*> OpenRequests() const;
  // The battery and the body say so from now on, once a second.
  void SetBattery(int percent, bool charging);
  void SetMotion(std::int32_t motion);
  void ReleaseEmergencyStop();  // by the controller, for a person
  // A person restarts an actuator and does not wait for it.
  void Restart(const std::string& name);
  // Asks for a switch; nothing when there is no controller or it does not answer in time.
  std::optional<SwitchResult> Set(const State& target,
                                  const std::optional<std::string>& actuator = std::nullopt,
                                  Duration limit = std::chrono::minutes(10));

  bool RunUntil(const std::function<bool()>& done, Duration limit = std::chrono::minutes(10));
  void RunFor(Duration duration) { network_.RunFor(duration); }

  // The controller that leads, of two the one with the higher epoch; else one that has stopped the
  // machine; null when there is none.
  ControllerProcess* leader();
  const ControllerProcess* leader() const { return const_cast<SimRobot*>(this)->leader(); }
  bool has_controller() const { return leader() != nullptr; }
  std::size_t leaders() const;  // without those that have stopped it
  // On that host; null when it does not live.
  const ControllerProcess* controller(std::size_t host) const { return controllers_[host].get(); }
  const Machine& machine() const { return leader()->shell().machine(); }
  // What the actuator itself says; nothing when its process does not live.
  std::optional<ActuatorReport> ReportOf(const std::string& name) const;
  // The same of the process that gave that report; where it does not live, of any.
  const ActuatorReport* ReportOf(std::size_t actuator, const ActuatorReport& followed) const;
  std::vector<std::string> journal() const;  // the messages of its entries
  const std::vector<JournalRow>& recording() const { return disks_[0].recording; }
  const Disk& disk(std::size_t controller) const { return disks_[controller]; }
  Disk& disk(std::size_t controller) { return disks_[controller]; }

 private:
  void Open(std::size_t which);
  void EndController(std::size_t which);
  void KillController(std::size_t which);
  void TakeOverHere();
  Disk& DiskOf(std::size_t which) { return disks_[OneHost() ? 0 : which]; }
  void SayOfBody();

  MachineConfig config_;
  const Layout layout_;
  transport::sim::Network network_;
  Hosts hosts_;
  Time switched_on_;
  std::unique_ptr<transport::Node> keeper_;  // whose loop runs what belongs to no process
  struct Panel {
    std::unique_ptr<transport::Node> node;
    std::unique_ptr<transport::Publisher<msg::EmergencyStop>> button;
  };
  std::array<Panel, 2> panels_;
  Processes processes_;
  std::array<Disk, 2> disks_;
  std::array<std::unique_ptr<ControllerProcess>, 2> controllers_;
  std::map<std::size_t, std::unique_ptr<Client>> clients_;  // by host
  std::array<transport::LoopHandlePtr, 2> begins_;
  transport::LoopHandlePtr takes_over_;
  std::optional<msg::BmsStatus> battery_;
  std::optional<msg::MotionStatus> motion_;
  std::unique_ptr<transport::Publisher<msg::BmsStatus>> batteries_;
  std::unique_ptr<transport::Publisher<msg::MotionStatus>> motions_;
  transport::LoopHandlePtr says_;
};

}  // namespace musher::simulation
