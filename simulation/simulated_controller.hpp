#pragma once
// The process of a simulated controller: the real shell and decision code on one of the robot's
// hosts, with a disk that outlives it. It starts, watches and signals processes of its own host,
// and those of other hosts by the systemd there.
//
// Threads: the one of the network.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/journal/journal_reader.hpp"
#include "musher/controller/process/host_units.hpp"
#include "musher/controller/shell/controller_services.hpp"
#include "musher/controller/shell/controller_shell.hpp"
#include "musher/controller/standby.hpp"
#include "musher/cyberdog/extension.hpp"
#include "musher/simulation/simulated_processes.hpp"

namespace musher::simulation {

// How a controller that starts finds its state folder.
enum class FolderOpens {
  kYes,
  kForReading,  // it is read at the start, and no write succeeds
  kNo,          // nothing of it is known
};

// What a controller stores, and reads when it is started again.
struct Disk {
  Epoch epoch = 0;
  StoredStops stops;
  std::vector<UnreadFolder> unread;  // other state folders, which it may not read
  bool stop_intent = false;
  std::vector<RemoteActuator> remote;
  std::vector<StoredActuator> actuators;
  StoredPolicy policy;
  std::vector<JournalRow> recording;
  // Processes by actuator; also those that could not be saved, which are found by their mark.
  std::map<std::string, ChildProcess> children;
  std::string children_host;                 // on which they run, of that boot
  std::map<std::string, std::string> files;  // small text files, by name
  UserRules rules;                           // of the user
  FolderOpens opens = FolderOpens::kYes;     // at the next start
  // The state folder of another user, who has started the machine before or does so next; the
  // journal and the other values are shared.
  struct OtherFolder {
    StoredStops stops;
    BatteryLevel level = BatteryLevel::kFree;
    std::optional<BatteryFallback> lowering;
  };
  OtherFolder other;
  bool level_taken = false;  // `policy` has the level of `other`
  bool full = false;         // every write fails
  bool stalled = false;      // no write ends
  struct Write {
    std::uint64_t controller = 0;  // its serial
    std::function<void()> end;
  };
  std::vector<Write> writes;  // that wait for the end of the stall
  // The last save of each value. A controller whose files are lost saves them again.
  std::map<const void*, Write> last_saves;
  std::size_t durable = 0;      // rows of the recording when the stall began
  bool gap = false;             // a row was lost
  bool wants_snapshot = false;  // a row was lost since the last snapshot
};

// What a controller that starts finds: those that were answered before are known by their mark, and
// its own folder, where that cannot be read.
std::vector<UnreadFolder> UnreadFoldersOf(const Disk& disk);

// A person or a program starts a controller. As under systemd, the controller distinguishes two
// starts by the supervisor: after a crash it completes a TearDown, at a boot it begins the machine.
enum class Starter : std::uint8_t { kPerson, kSupervisor, kBoot };

class SimulatedController : private ProcessRunner, private ProcessProbe, private JournalSink {
 public:
  struct Hooks {
    std::function<void()> on_input;  // before each step of the decision code
    std::function<void(const action::Record&)> on_record;
    std::function<void(const Machine&, const action::SendSwitch&)> on_send;
    std::function<void(const std::string& name)> on_start;  // of a process
    std::function<void(Starter starter)> on_begin;          // before it takes control
    std::function<void()> on_power;                         // the power command
    std::function<void(pid_t pid)> on_signal;               // before a process is signalled
    std::function<void()> on_over;  // it is stopped, fenced or refused: its process may exit
    // Connections to the systemds of other hosts, for the loop of its process; empty: none.
    std::function<ConnectSystemd(transport::EventLoop&)> connect = nullptr;
  };

  // All must outlive it.
  SimulatedController(transport::sim::Network& network, const std::string& endpoint,
                      std::size_t host, Hosts& hosts, const MachineConfig& config,
                      const std::string& machine_id, SimulatedProcesses& processes, Disk& disk,
                      Hooks hooks);
  ~SimulatedController() override;

  // Takes control of the machine. Refuses when it has received heartbeats of another controller,
  // unless `takeover` is set.
  void Begin(bool takeover, Starter starter = Starter::kPerson);
  // Begins once the controller of the other host is gone, as a standby does: its supervisor has
  // started it.
  void StandBy();
  bool stands_by() const { return standby_ != nullptr; }
  // A process has ended.
  void OnEnd(std::size_t host, std::int32_t pid, const ProcessExit& exit);

  ControllerShell& shell() { return *shell_; }
  const ControllerShell& shell() const { return *shell_; }
  transport::Node& node() { return *node_; }
  Time Now() const { return node_->loop().Now(); }
  bool begun() const { return begun_; }
  // Whether it leads the machine according to its own state.
  bool leads() const {
    return begun_ && shell_->machine().phase != Phase::kFenced &&
           shell_->machine().phase != Phase::kIdle;
  }
  std::int32_t pid() const { return pid_; }
  std::size_t host() const { return host_; }
  // Unique among all processes of the simulation.
  std::uint64_t serial() const { return serial_; }
  const std::string& endpoint() const { return endpoint_; }
  transport::ParticipantId participant() const { return network_.ParticipantOf(*node_); }
  bool frozen = false;
  std::optional<Time> thawed;  // when it was last frozen until
  Duration wall_offset{};      // how far its wall clock is ahead

 private:
  // The functions by which the shell saves to the disk.
  void SetSaves(ControllerShell::Dependencies& dependencies);
  ControllerShell::Hooks ShellHooks();

  Result<pid_t> Start(const ProcessSpec& spec, OnExit on_exit) override;
  Result<> Watch(pid_t pid, OnExit on_exit) override;
  Result<> Signal(pid_t pid, int signal) override {
    if (hooks_.on_signal) hooks_.on_signal(pid);
    return processes_.Signal(host_, pid, signal);
  }
  Result<> Prove(const std::string& actuator, pid_t pid, pid_t child) override;
  std::vector<pid_t> Find(const std::vector<std::string>& actuators) override;
  std::uint64_t StartTimeOf(pid_t pid) override { return processes_.SerialOf(host_, pid); }
  void Mark(ActuatorIndex, pid_t, Time) override {}
  Examination Examine(ActuatorIndex, pid_t pid, Time) override {
    return processes_.Examine(host_, pid);
  }
  void TakeBacktrace(pid_t pid, Duration timeout,
                     std::function<void(Result<std::string>)> done) override;
  void Append(JournalItem item) noexcept override;
  void LeadWhatIsLost();
  void WatchMajority();
  StoredStops LoadStops() const;
  StoredPolicy LoadPolicy();
  bool WritesFail() const { return disk_.full || opened_ != FolderOpens::kYes; }
  // Writes a value now, or when the disk's stall ends.
  template <class T>
  void Save(T& stored, const T& value, const ControllerShell::Dependencies::OnSaved& done);
  bool WantsSnapshot() noexcept override;
  pid_t FindOne(const std::string& actuator);
  Result<> OpenServices();
  void ReadDisk(std::int64_t since_wall_ns, std::size_t limit, OnHistory done);

  transport::sim::Network& network_;
  const MachineConfig& config_;
  SimulatedProcesses& processes_;
  Disk& disk_;
  Hooks hooks_;
  const std::string endpoint_;
  const std::size_t host_;
  const std::string host_id_;  // of this boot
  const std::int32_t pid_;
  const std::uint64_t serial_;
  bool begun_ = false;
  FolderOpens opened_ = FolderOpens::kYes;
  std::size_t inputs_ = 0;
  std::map<std::int32_t, std::vector<OnExit>> watchers_;
  std::unique_ptr<transport::Node> node_;
  std::unique_ptr<HostUnits> units_;  // null: no other host runs processes of the machine
  std::unique_ptr<ControllerShell> shell_;
  std::unique_ptr<Standby> standby_;              // null unless it stands by
  std::optional<msg::MachineStatus> led_before_;  // by the controller that this standby replaces
  transport::LoopHandlePtr standby_timer_;
  MajorityReach majority_;
  transport::LoopHandlePtr majority_timer_;
  std::unique_ptr<ControllerServices> services_;  // null unless it leads
  const ControllerExtension cyberdog_ = cyberdog::Extension("SIMULATED-1");
  std::unique_ptr<ExtensionServices> manager_;  // the same; also null where the config has none
};

}  // namespace musher::simulation
