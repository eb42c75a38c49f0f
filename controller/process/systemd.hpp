#pragma once
// Interface of the systemd of another host, or of this one, with the calls and signals that
// HostUnits needs. No call waits. BusSystemd implements it by D-Bus (bus_systemd.hpp); the
// simulation has its own, in virtual time.
//
// A connection that is lost may hold calls that it has not delivered, and the kernel may still
// deliver them when the host is reached again: what must not happen late is bound to one start of a
// unit (its invocation), or to a time.
//
// Threads: loop thread only, callbacks too. No callback runs inside a call of this class.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "musher/base/time.hpp"
#include "musher/controller/process/process_runner.hpp"
#include "musher/lifecycle/config/config.hpp"

namespace musher {

// Results of the job that starts a unit, and of a unit. After UnitStart::until systemd executes
// nothing: the job is done from version 248 on, and skipped before.
inline constexpr std::string_view kJobDone = "done";
inline constexpr std::string_view kJobSkipped = "skipped";
inline constexpr std::string_view kResultOutOfMemory = "oom-kill";

// What systemd knows of a unit. The values of a unit that is not loaded are these.
struct UnitState {
  std::string active = "inactive";
  std::uint32_t main_pid = 0;
  std::uint32_t exec_pid = 0;  // of the last process, also after its exit
  std::int32_t exec_code = 0;  // CLD_EXITED, CLD_KILLED, CLD_DUMPED
  std::int32_t exec_status = 0;
  std::string result = {};
  std::set<std::string> environment = {};
  // The id of the last start: 32 hexadecimal digits, which no other start of any unit has.
  std::string invocation = {};

  bool runs() const { return active == "active" || active == "reloading"; }
  bool ended() const { return active == "inactive" || active == "failed"; }
};

struct SystemdError {
  enum class Kind : std::uint8_t {
    kOther,
    kDenied,        // this user has no permission
    kNoReply,       // systemd has not replied in time
    kGone,          // the unit, or that start of it, is not loaded any more
    kUnitExists,    // a unit of that name is loaded
    kShuttingDown,  // the host shuts down
  };
  Kind kind = Kind::kOther;
  std::string text;
};

// A transient unit that is to be started.
struct UnitStart {
  std::string unit;
  std::string description;
  ProcessSpec process;           // without its mark; its output only on this host
  Duration until{};              // it is not started once its host has run for longer than this
  std::string stops_after = {};  // a unit: at a shutdown this one ends after it; empty: at once
};

class Systemd {
 public:
  using Merge = std::function<void(UnitState&)>;
  struct Hooks {
    std::function<void()> on_up;
    // `for_good`: another attempt does not help, for example after a refused key. `was_up`: an open
    // connection was lost.
    std::function<void(bool was_up, bool for_good)> on_down;
    // Values of a unit have changed, which `merge` sets. `whole`: no others follow of this change.
    std::function<void(const std::string& unit, const Merge& merge, bool whole)> on_change;
    // The job has ended. The changes of its unit were reported before.
    std::function<void(const std::string& unit, const std::string& job, const std::string& result)>
        on_job_removed;
    // Returns why the host that answers is not used; empty: it is used. `running`: the time since
    // its kernel was booted.
    std::function<std::string(const std::string& host_id, Duration running)> refuse;
  };
  // The error; none: the call was carried out. It is not called if the connection is lost before
  // the reply.
  using OnDone = std::function<void(const std::optional<SystemdError>&)>;

  // Ends the connection.
  virtual ~Systemd() = default;

  // Connects now, and again whenever the connection is lost, until Close(); nothing happens if it
  // is up, or connecting.
  virtual void Open() = 0;
  // Ends the connection for good; nothing is called any more.
  virtual void Close() = 0;

  virtual bool is_up() const = 0;
  virtual const std::string& host_id() const = 0;  // HostId() there, of the last connection
  // For how long its host has run: read when the connection was made, and counted on by the clock
  // here. Too short by the delay of the link.
  virtual Duration running() const = 0;
  // Why the connection is not up, with what to do; empty: no failure since it was up last.
  virtual const std::string& trouble() const = 0;

  // The calls do nothing while it is not up.

  // Sets `state`, which must outlive the connection, in parts, between which changes may come.
  virtual void Read(const std::string& unit, UnitState& state, OnDone done) = 0;
  virtual void Start(
      const UnitStart& start,
      std::function<void(const std::optional<SystemdError>&, const std::string& job)> done) = 0;
  // Cancels a job that has not begun to run.
  virtual void Cancel(const std::string& job) = 0;
  // Sends a signal to all processes of that start of a unit; to no later one.
  virtual void Kill(const std::string& invocation, int signal, OnDone done) = 0;
  // Ends that start of a unit, and no later one.
  virtual void Stop(const std::string& invocation) = 0;
  // A unit that has failed is kept by systemd, with its name, until it is reset.
  virtual void Reset(const std::string& unit) = 0;
  // "running", "stopping" …; empty: it does not say.
  virtual void ReadSystemState(
      std::function<void(const std::optional<SystemdError>&, const std::string& state)> done) = 0;
};

// Makes the connection to the systemd of a host, for these units.
using ConnectSystemd = std::function<std::unique_ptr<Systemd>(
    const HostConfig& host, const std::vector<std::string>& units, Systemd::Hooks hooks)>;

}  // namespace musher
