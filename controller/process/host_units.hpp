#pragma once
// Runs the processes of other hosts as transient units of the systemd there, one for each actuator,
// and with `units = "always"` also those of this host:
//
//   musher-<machine>-<actuator>.service
//
// systemd starts it, knows how it has exited, and ends what it leaves behind; the signals of
// systemd tell it to the controller (systemd.hpp). The unit has the machine's id in its
// environment: a unit of that name that runs already is this machine's, and is found again, or
// another machine's, and is neither touched nor replaced. systemd never runs two units of one name.
//
// While a host is out of reach, its units keep running, and nothing is reported about them. Once
// the host is reached again, each unit is examined: it still runs, or has ended meanwhile; after a
// reboot of the host all units have ended. A unit that ends while its host shuts down has ended
// with the host, whatever its exit code (unit_end.hpp), and its next start waits until the host is
// back. Another host may answer at the address: it has been running for longer than the known host
// was out of reach, and is not used.
//
// A signal, and the end of a start that was given up, name one start of the unit: carried out late,
// they end no newer process. A start is never carried out late.
//
// This host is reached by a socket, not by ssh (Options::own). What differs there:
//
//   start  does not wait for a D-Bus that is silent: it fails after `start_within`, and is repeated
//          by the actuator's `restart`. A child is never started in its place
//   end    is reported once the process itself has exited: what it has left behind systemd may
//          still be ending, and the next start waits for that
//
// Threads: loop thread only, callbacks too.

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/process/systemd.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher {

class HostUnits : public HostProcesses {
 public:
  struct Options {
    // How long a start takes at most, without the time that its host is waited for.
    Duration start_within = Milliseconds(10'000);
    // How long a start waits for its host until that is reported as out of reach, at most.
    Duration reach_within = Milliseconds(10'000);
    // For how long the controller's host has run, also while it was suspended.
    std::function<Duration()> since_boot = SinceBoot;
    // The systemd of this host, for the actuators without a `host`; empty: they are no units.
    ConnectSystemd own = nullptr;
    // The unit of the controller: at a shutdown of this host it tears the machine down, and what it
    // leads must not end before. Empty: it is in none.
    std::string own_unit = {};
  };

  // All must outlive this object. `machine`: returns the present name and id of the controller's
  // machine.
  HostUnits(transport::EventLoop& loop, const MachineConfig& config,
            std::function<MachineIdentity()> machine, const ConnectSystemd& connect,
            Options options);
  ~HostUnits() override;

  void Open(Hooks hooks) override;
  void Start(const ProcessSpec& spec) override;
  void Signal(const std::string& actuator, pid_t pid, int signal) override;
  void Find(std::function<void(const std::vector<Found>&)> done) override;
  void Close() override;

 private:
  struct Host;
  struct Unit;
  struct Search;

  void Add(const HostConfig& host, const ConnectSystemd& connect);
  Systemd::Hooks HooksOf(Host& host);
  static Unit* UnitOf(Host& host, const std::string& name);
  void OnUp(Host& host);
  void OnDown(Host& host, bool was_up, bool for_good);
  std::string WhyRefused(const Host& host, const std::string& id, Duration running) const;
  Duration LostAt();
  void NotePause();
  void Examine(Unit& unit);
  void Examined(Unit& unit);
  void OnChange(Unit& unit);
  void StartUnit(Unit& unit);
  void OnStartAnswered(Unit& unit, const std::optional<SystemdError>& error,
                       const std::string& job);
  void OnJobRemoved(Unit& unit, const std::string& job, const std::string& result);
  void Started(Unit& unit, pid_t pid, bool found);
  void NotStarted(Unit& unit, const std::string& why);
  void Await(Unit& unit, const std::string& why);
  void ArmDeadline(Unit& unit);
  void Ended(Unit& unit);
  void AskSystemState(Unit& unit);
  void ReportEnd(Unit& unit, const ProcessExit& exit);
  void Reset(Unit& unit);
  void EndStart(Unit& unit);
  void Kill(Unit& unit, int signal);
  void Conclude(Unit& unit);
  void AnswerSearches();
  bool IsOurs(const Unit& unit) const;
  bool IsChanging(const Unit& unit) const;
  std::string Unreached(const Host& host) const;

  transport::EventLoop& loop_;
  const MachineConfig& config_;
  const std::function<MachineIdentity()> machine_;
  const Options options_;
  const HostConfig here_{};  // without a name
  Hooks hooks_;
  bool open_ = false;
  // By since_boot(). After a pause of this process, or of its computer, a loss may be as old.
  Duration noted_at_{};     // once a second
  Duration paused_from_{};  // the last pause
  Duration doubt_until_{};
  transport::LoopHandlePtr note_;
  std::map<std::string, std::unique_ptr<Unit>> units_;  // by actuator
  std::vector<std::unique_ptr<Search>> searches_;
  std::map<std::string, std::unique_ptr<Host>> hosts_;  // last: their connections call the others
};

}  // namespace musher
