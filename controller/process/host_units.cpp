#include "musher/controller/process/host_units.hpp"

#include <signal.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string_view>
#include <utility>

#include "musher/controller/process/unit_end.hpp"

namespace musher {
namespace {

// A search is a part of a TearDown, which has to know before its budget is used up which hosts have
// not answered. A connection that is just being made needs some time.
constexpr Duration kFindWithin = Milliseconds(1'000);
constexpr Duration kExamineAgain = Milliseconds(500);
// How long after it was sent a host may carry out a start: the longest delay of a greeting (8 s),
// the longest start (10 s), and a margin.
constexpr Duration kStartValid = Milliseconds(20'000);
// A host whose clock seems to have gained more than this skips its starts for another reason.
constexpr Duration kMostGained = std::chrono::hours(1);
// How long a host may have been off before its connection is found to be lost (ssh: 6 s).
constexpr Duration kLossSeenWithin = Milliseconds(10'000);
// This process notes each second that it runs.
constexpr Duration kNotePeriod = Milliseconds(1'000);
constexpr Duration kLongestTurn = Milliseconds(3'000);
constexpr const char* kDeniedCure =
    "; its systemd lets this user start and end no unit: set `user` to root, or permit it by "
    "polkit "
    "(org.freedesktop.systemd1.manage-units)";
// Exit codes of systemd itself: the program was not executed (systemd.exec(5)).
constexpr int kFirstOfSystemd = 200;
constexpr int kLastOfSystemd = 243;
constexpr int kNoFolder = 200;
constexpr int kNotExecutable = 203;
constexpr int kNoSuchUser = 217;
constexpr int kNoNamespace = 226;

// Whether the process of the unit has exited; systemd may still be ending what it has left behind.
bool HasExited(const UnitState& state, pid_t pid) {
  return !state.runs() && state.main_pid == 0 && static_cast<pid_t>(state.exec_pid) == pid &&
         state.exec_code != 0;
}

// systemd keeps a unit that has failed, and drops a unit that has ended with code 0. It also drops
// a unit that SIGTERM, SIGHUP, SIGINT or SIGPIPE has ended, maybe in its TearDown.
bool IsDropped(const UnitState& state) {
  return state.active == "inactive" && state.exec_pid == 0;
}

std::string WhyUnknown(const UnitState& state, const std::string& unit) {
  return IsDropped(state) ? "systemd knows nothing of " + unit + " any more"
                          : "systemd knows another start of " + unit + " only";
}

// For people.
std::string NameOf(const HostConfig& host) {
  return host.name.empty() ? "this host" : "host " + host.name;
}
std::string PlaceOf(const HostConfig& host) {
  return host.name.empty() ? "systemd of this host" : NameOf(host) + " (" + host.Login() + ")";
}

// systemd does not say which of the two is used up.
std::string WhatIsUsedUp(const ProcessLimits& limits, const HostConfig& host) {
  const std::string memory = "the memory of " + NameOf(host) + " is used up; ";
  if (!limits.memory_max_bytes) return memory + "limit what uses it by `memory_max_mb`";
  return "its limit (memory_max_mb = " + std::to_string(*limits.memory_max_bytes >> 20) + ") or " +
         memory + "raise the limit if it needs more";
}

ProcessExit ExitOf(const UnitState& state, pid_t pid, const std::string& unit,
                   const ProcessLimits& limits, const HostConfig& host) {
  ProcessExit exit;
  const bool over = state.ended() || HasExited(state, pid);
  if (over && state.result == kResultOutOfMemory) exit.out_of_memory = WhatIsUsedUp(limits, host);
  if (static_cast<pid_t>(state.exec_pid) != pid || !over) {
    exit.last_output = WhyUnknown(state, unit);
    return exit;
  }
  exit.number = state.exec_status;
  if (state.exec_code == CLD_EXITED) exit.kind = ProcessExit::Kind::kExited;
  if (state.exec_code == CLD_KILLED || state.exec_code == CLD_DUMPED) {
    exit.kind = ProcessExit::Kind::kKilled;
  }
  return exit;
}

// Why nothing is known of the host.
std::string TroubleOf(const Systemd& systemd) {
  if (!systemd.trouble().empty()) return systemd.trouble();
  return systemd.is_up() ? "it does not answer" : "it has not answered yet";
}

std::string TextOf(const SystemdError& error) {
  return error.text + (error.kind == SystemdError::Kind::kDenied ? kDeniedCure : "");
}

// Why systemd has not executed the program, by its exit code.
std::string WhyNotExecuted(int status, const std::string& program, const ProcessSpec& spec) {
  const std::string what = program + " could not be executed there";
  if (status == kNoFolder) {
    const std::string& user = spec.limits.user;
    return what + ": its " + (user.empty() ? "sandbox hides" : "user " + user + " may not enter") +
           " its folder " + spec.cwd + " (`cwd`)";
  }
  if (status == kNotExecutable) {
    return what + ": it is missing, not executable, or built for another processor";
  }
  if (status == kNoNamespace) {
    return what + ": its kernel or container permits no mount namespaces, which `sandbox` needs";
  }
  return what + " (systemd's exit code " + std::to_string(status) + ")";
}

// Why systemd may execute nothing of a unit, however late its start is carried out: it cannot set
// up the process that looks at the time.
std::string WhySkipped(const std::string& unit, const ProcessSpec& spec) {
  std::string causes;
  const auto add = [&causes](const std::string& cause) {
    causes += (causes.empty() ? ": " : ", or ") + cause;
  };
  const std::string& user = spec.limits.user;
  if (!user.empty()) add("its user " + user + " (`user`) may be missing there");
  if (spec.cwd.starts_with('/')) add("its folder " + spec.cwd + " (`cwd`) may be missing there");
  if (spec.limits.realtime_priority) add("its systemd may refuse `realtime_priority`");
  if (spec.limits.nice) add("its systemd may refuse `nice`");
  return "systemd executes nothing of " + unit + causes;
}

// Whether the process is the unit's, also after its exit.
bool IsOf(const UnitState& state, pid_t pid) {
  return static_cast<pid_t>(state.main_pid) == pid || static_cast<pid_t>(state.exec_pid) == pid;
}

std::string_view BootOf(std::string_view host_id) {
  return host_id.substr(0, host_id.find('/'));
}

}  // namespace

struct HostUnits::Host {
  const HostConfig& config;
  std::unique_ptr<Systemd> systemd;
  std::vector<Unit*> units = {};
  std::string seen = {};                 // its HostId() when its units were last examined
  bool reported = false;                 // its loss was reported
  std::optional<Duration> lost_at = {};  // since_boot() when its connection was lost
  Duration gained = {};                  // by its clock, since that was read, as a start has shown

  bool is_own() const { return config.name.empty(); }
  // As the hooks name it.
  std::string IdOf(const std::string& id) const { return is_own() ? "" : id; }
};

struct HostUnits::Unit {
  Host& host;
  std::string actuator;
  std::string name;
  UnitState state = {};
  pid_t pid = 0;                           // of the process that was reported as started
  std::string invocation = {};             // the start that made the process; empty: not read
  std::optional<ProcessSpec> wanted = {};  // to be started
  bool waits = false;                      // the start waits for the host, which was reported
  bool asked = false;                      // StartTransientUnit was sent
  std::string job = {};                    // its job
  Duration gained = {};                    // by the host's clock, if that is why it was skipped
  bool given_up = false;                   // the start was given up and is to be ended
  int signal = 0;                          // to be sent, or sent and not confirmed
  bool refused = false;                    // a signal was refused, which was reported
  bool signalled = false;                  // the machine ends its process
  std::optional<UnitState> end = {};       // how the process has exited, by a signal of systemd
  std::optional<ProcessExit> exit = {};    // the end of the process, not reported yet
  bool asks_system = false;                // whether the host shuts down: not answered yet
  bool ends_rest = false;                  // its end was reported, and not all of it has ended
  bool examining = false;
  std::string unread = {};                      // why its state could not be read
  std::uint64_t examined = 0;                   // how often
  transport::LoopHandlePtr deadline = nullptr;  // of the start
  transport::LoopHandlePtr again = nullptr;
};

struct HostUnits::Search {
  std::function<void(const std::vector<Found>&)> done;
  std::map<const Unit*, std::uint64_t> until;  // units that have not been examined since
  std::set<const Host*> failed;
  bool over = false;
  transport::LoopHandlePtr deadline;
};

HostUnits::HostUnits(transport::EventLoop& loop, const MachineConfig& config,
                     std::function<MachineIdentity()> machine, const ConnectSystemd& connect,
                     Options options)
    : loop_(loop), config_(config), machine_(std::move(machine)), options_(std::move(options)) {
  for (const HostConfig& host : config.hosts) Add(host, connect);
  if (options_.own) Add(here_, options_.own);
}

// With the actuators that run there.
void HostUnits::Add(const HostConfig& host, const ConnectSystemd& connect) {
  auto made = std::make_unique<Host>(Host{host, nullptr});
  std::vector<std::string> names;
  for (const ActuatorConfig& actuator : config_.actuators) {
    const bool waits_for_person = host.name.empty() && actuator.command.empty();
    if (actuator.host != host.name || waits_for_person) continue;
    const std::string& name = names.emplace_back(UnitNameOf(config_.name, actuator.name));
    auto unit = std::make_unique<Unit>(Unit{*made, actuator.name, name});
    made->units.push_back(unit.get());
    units_.emplace(actuator.name, std::move(unit));
  }
  if (made->units.empty()) return;
  made->systemd = connect(host, names, HooksOf(*made));
  hosts_.emplace(host.name, std::move(made));
}

Systemd::Hooks HostUnits::HooksOf(Host& host) {
  Systemd::Hooks hooks;
  hooks.on_up = [this, &host] { OnUp(host); };
  hooks.on_down = [this, &host](bool was_up, bool for_good) { OnDown(host, was_up, for_good); };
  hooks.on_change = [this, &host](const std::string& name, const Systemd::Merge& merge,
                                  bool whole) {
    Unit* unit = UnitOf(host, name);
    if (unit == nullptr) return;
    merge(unit->state);
    if (whole && HasExited(unit->state, unit->pid)) unit->end = unit->state;
    if (whole) OnChange(*unit);
  };
  hooks.on_job_removed = [this, &host](const std::string& name, const std::string& job,
                                       const std::string& result) {
    Unit* unit = UnitOf(host, name);
    if (unit == nullptr) return;
    OnJobRemoved(*unit, job, result);
    AnswerSearches();
  };
  hooks.refuse = [this, &host](const std::string& id, Duration running) {
    return WhyRefused(host, id, running);
  };
  return hooks;
}

HostUnits::Unit* HostUnits::UnitOf(Host& host, const std::string& name) {
  const auto found = std::ranges::find(host.units, name, &Unit::name);
  return found == host.units.end() ? nullptr : *found;
}

HostUnits::~HostUnits() {
  HostUnits::Close();
}

void HostUnits::Open(Hooks hooks) {
  hooks_ = std::move(hooks);
  open_ = true;
  noted_at_ = options_.since_boot();
  note_ = loop_.Every(kNotePeriod, [this] { NotePause(); });
  for (auto& [name, host] : hosts_) host->systemd->Open();
}

void HostUnits::Close() {
  open_ = false;
  note_ = nullptr;
  for (auto& [name, host] : hosts_) host->systemd->Close();
  searches_.clear();
  for (auto& [name, unit] : units_) {
    unit->wanted.reset();
    unit->waits = false;
    unit->deadline = nullptr;
    unit->again = nullptr;
  }
}

// --- the hosts ---

std::string HostUnits::Unreached(const Host& host) const {
  return PlaceOf(host.config) + ": " + TroubleOf(*host.systemd);
}

// The address may belong to another board now, with the same key if both were made from one image.
// That board has been running since before the known host was reached last.
std::string HostUnits::WhyRefused(const Host& host, const std::string& id, Duration running) const {
  if (host.seen.empty() || !host.lost_at || BootOf(host.seen) == BootOf(id)) return {};
  const Duration lost_for = options_.since_boot() - *host.lost_at;
  if (running <= lost_for + kLossSeenWithin) return {};
  return "another host answers at " + host.config.address + ", which was not booted since " +
         host.config.name + " was reached last";
}

// Since when a host whose loss is noticed now may have been out of reach.
Duration HostUnits::LostAt() {
  NotePause();
  return noted_at_ < doubt_until_ ? paused_from_ : noted_at_;
}

void HostUnits::NotePause() {
  const Duration now = options_.since_boot();
  const Duration before = std::exchange(noted_at_, now);
  if (now - before < kLongestTurn) return;
  if (now >= doubt_until_) paused_from_ = before;
  doubt_until_ = now + kLossSeenWithin;
}

void HostUnits::OnUp(Host& host) {
  const std::string& id = host.systemd->host_id();
  const bool rebooted = !host.seen.empty() && host.seen != id;
  if (std::exchange(host.reported, false)) {
    hooks_.on_reach(true, NameOf(host.config) + " is reached" +
                              (rebooted ? ", and has been booted again" : ""));
  }
  for (Unit* unit : host.units) {
    unit->state = {};
    unit->examining = false;
    unit->unread.clear();
    unit->asked = false;
    unit->given_up = false;
    unit->gained = {};
    unit->job.clear();
    unit->asks_system = false;
    unit->again = nullptr;
  }
  const std::vector<Unit*> units = host.units;
  for (Unit* unit : units) {
    if (!rebooted || unit->pid == 0) continue;
    unit->signal = 0;
    unit->exit.reset();
    hooks_.on_ended(unit->actuator, std::exchange(unit->pid, 0), EndOfUnit({}, "", rebooted));
  }
  host.seen = id;
  host.gained = {};
  for (Unit* unit : units) {
    if (std::exchange(unit->waits, false) && !hooks_.still_starts(unit->actuator)) {
      unit->wanted.reset();
    }
    if (unit->wanted) ArmDeadline(*unit);
    Examine(*unit);
  }
}

void HostUnits::OnDown(Host& host, bool was_up, bool for_good) {
  const std::string why = Unreached(host);
  if (was_up) host.lost_at = LostAt();
  for (auto& search : searches_) search->failed.insert(&host);
  for (Unit* unit : host.units) {
    unit->examining = false;
    unit->again = nullptr;
    if (unit->wanted && for_good && !unit->waits) Await(*unit, Unreached(host));
  }
  if (!std::exchange(host.reported, true)) {
    hooks_.on_reach(false, why + (was_up ? ". What runs there runs on, and is found again" : ""));
  }
  AnswerSearches();
}

// --- the state of a unit ---

// Reads what systemd knows of it. A unit that is not loaded is inactive.
void HostUnits::Examine(Unit& unit) {
  Systemd& systemd = *unit.host.systemd;
  if (!systemd.is_up() || std::exchange(unit.examining, true)) return;
  systemd.Read(unit.name, unit.state, [this, &unit](const std::optional<SystemdError>& error) {
    unit.examining = false;
    unit.unread = error ? error->text : "";
    // An error says nothing of the process.
    if (error) {
      unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
      return;
    }
    Examined(unit);
  });
}

void HostUnits::Examined(Unit& unit) {
  ++unit.examined;
  Conclude(unit);
  if (unit.pid != 0 && unit.invocation.empty() && IsOf(unit.state, unit.pid)) {
    unit.invocation = unit.state.invocation;
  }
  if (unit.given_up) EndStart(unit);
  if (unit.pid != 0 && unit.signal != 0 && !unit.invocation.empty()) {
    // The actuator may have recovered while its host was out of reach.
    unit.signalled = hooks_.still_ends(unit.actuator, unit.pid);
    unit.signalled ? Kill(unit, unit.signal) : static_cast<void>(unit.signal = 0);
  }
  AnswerSearches();
}

void HostUnits::OnChange(Unit& unit) {
  if (unit.examining) return;
  // A unit that this controller did not start: its environment was not read yet.
  if (unit.pid == 0 && !unit.asked && unit.state.runs()) return Examine(unit);
  Conclude(unit);
  AnswerSearches();
}

// Whether the unit of this name is this machine's.
bool HostUnits::IsOurs(const Unit& unit) const {
  const std::string entry = "MUSHER_MACHINE_ID=";
  const std::string id = machine_().id;
  const std::set<std::string>& environment = unit.state.environment;
  if (!id.empty()) return environment.contains(entry + id);
  return std::ranges::none_of(environment,
                              [&](const std::string& one) { return one.starts_with(entry); });
}

// Whether a process of this machine is about to run there, or may not have ended yet.
bool HostUnits::IsChanging(const Unit& unit) const {
  return unit.pid == 0 && (unit.asked || (!unit.state.ended() && IsOurs(unit)));
}

// What follows from the state of the unit.
void HostUnits::Conclude(Unit& unit) {
  if (!open_) return;
  const UnitState& state = unit.state;
  const auto main_pid = static_cast<pid_t>(state.main_pid);
  if (unit.pid != 0) {
    const bool same =
        IsOf(state, unit.pid) && (unit.invocation.empty() || unit.invocation == state.invocation);
    const bool exited = unit.host.is_own() && HasExited(state, unit.pid);
    if (state.ended() || exited || (state.runs() && !same)) return Ended(unit);
    if (!unit.wanted || !state.runs()) return;
    // systemd is about to notice its exit, and to report that.
    const bool lingers = hooks_.has_exited && hooks_.has_exited(unit.actuator, unit.pid);
    if (!lingers) Started(unit, unit.pid, true);
    return;
  }
  if (unit.asked) return;  // its job decides
  if (state.runs() && main_pid != 0) {
    if (IsOurs(unit)) return Started(unit, main_pid, true);
    if (unit.wanted) {
      NotStarted(unit, NameOf(unit.host.config) + " runs " + unit.name +
                           " already, for another machine of this name; give one of the machines "
                           "another name, or run `systemctl stop " +
                           unit.name + "` there");
    }
    return;
  }
  if (state.active == "failed" && std::exchange(unit.ends_rest, false)) Reset(unit);
  if (!unit.wanted || !state.ended()) return;
  // Its host was reached too late.
  if (!hooks_.still_starts(unit.actuator)) return NotStarted(unit, "the machine is torn down");
  if (hooks_.is_present && hooks_.is_present(unit.actuator)) {
    return NotStarted(unit, "another process of it runs");
  }
  StartUnit(unit);
}

void HostUnits::Started(Unit& unit, pid_t pid, bool found) {
  if (unit.pid != pid) {
    unit.signalled = false;
    unit.end.reset();
  }
  unit.pid = pid;
  unit.invocation = unit.state.invocation;
  unit.refused = false;
  unit.wanted.reset();
  unit.waits = false;
  unit.deadline = nullptr;
  unit.again = nullptr;
  hooks_.on_started(unit.actuator, pid, unit.host.IdOf(unit.host.systemd->host_id()), found);
}

void HostUnits::NotStarted(Unit& unit, const std::string& why) {
  unit.wanted.reset();
  unit.waits = false;
  unit.deadline = nullptr;
  unit.again = nullptr;
  hooks_.on_not_started(unit.actuator, why, false);
}

// The start stays wanted; on this host it fails, and is repeated by the actuator's `restart`.
void HostUnits::Await(Unit& unit, const std::string& why) {
  if (unit.host.is_own()) return NotStarted(unit, why);
  unit.waits = true;
  unit.deadline = nullptr;
  hooks_.on_not_started(unit.actuator, why + "; it is started once its host is reached", true);
}

void HostUnits::Ended(Unit& unit) {
  if (unit.asks_system) return;
  const ActuatorIndex i = *config_.IndexOf(unit.actuator);
  // It may have been dropped while it was examined.
  const UnitState& state = unit.end && IsDropped(unit.state) ? *unit.end : unit.state;
  if (!unit.exit) {
    unit.exit = ExitOf(state, unit.pid, unit.name, config_.actuators[i].limits, unit.host.config);
  }
  if (NeedsSystemState(*unit.exit, unit.signalled)) return AskSystemState(unit);
  const ProcessExit exit = *std::exchange(unit.exit, std::nullopt);
  ReportEnd(unit, exit);
}

// If the connection is lost before the reply, the unit is looked at again once the host is reached.
void HostUnits::AskSystemState(Unit& unit) {
  unit.asks_system = true;
  unit.host.systemd->ReadSystemState(
      [this, &unit](const std::optional<SystemdError>& error, const std::string& system_state) {
        if (!std::exchange(unit.asks_system, false) || unit.pid == 0) return;
        // A host that is short of everything is asked once more, with the unit.
        if (error && error->kind == SystemdError::Kind::kNoReply) {
          unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
          return;
        }
        ReportEnd(unit, EndOfUnit(*unit.exit, system_state, false));
        AnswerSearches();
      });
}

void HostUnits::ReportEnd(Unit& unit, const ProcessExit& exit) {
  const pid_t pid = std::exchange(unit.pid, 0);
  unit.exit.reset();
  unit.signal = 0;
  if (unit.state.active == "failed") Reset(unit);
  unit.ends_rest = !unit.state.ended();
  // Or another process runs there by now.
  if (unit.wanted || unit.state.runs()) {
    unit.again = loop_.At(loop_.Now(), [this, &unit] { Examine(unit); });
  }
  hooks_.on_ended(unit.actuator, pid, exit);
}

void HostUnits::Reset(Unit& unit) {
  unit.host.systemd->Reset(unit.name);
}

// Names the start of the unit, not the unit: a signal that waits in a lost connection may arrive
// when a newer process runs.
void HostUnits::Kill(Unit& unit, int signal) {
  if (unit.invocation.empty()) return Examine(unit);  // and then
  // Without a reply the signal may be lost with the connection: then it is sent again.
  unit.host.systemd->Kill(
      unit.invocation, signal, [this, &unit, signal](const std::optional<SystemdError>& error) {
        if (unit.signal == signal) unit.signal = 0;
        if (!error) return;
        // That start of the unit has ended, which may not have been reported.
        if (error->kind == SystemdError::Kind::kGone) return Examine(unit);
        if (std::exchange(unit.refused, true)) return;
        hooks_.on_reach(false, PlaceOf(unit.host.config) + ": the signal to " + unit.name +
                                   " was refused: " + TextOf(*error));
      });
}

// --- starts ---

void HostUnits::Start(const ProcessSpec& spec) {
  Unit& unit = *units_.at(spec.name);
  unit.wanted = spec;
  unit.waits = false;
  unit.gained = {};
  ArmDeadline(unit);
  // Not inside this call.
  unit.again = loop_.At(loop_.Now(), [this, &unit] {
    unit.host.systemd->Open();
    Examine(unit);
  });
}

// Limits how long a start waits for the previous unit to end, and how long for its host until the
// host is reported as out of reach.
void HostUnits::ArmDeadline(Unit& unit) {
  // Armed again once the host is reached.
  const bool is_up = unit.host.systemd->is_up();
  const Duration within =
      is_up ? options_.start_within : std::min(options_.start_within, options_.reach_within);
  unit.deadline = loop_.At(loop_.Now() + within, [this, &unit] {
    if (!unit.wanted) return;
    if (!unit.host.systemd->is_up()) return Await(unit, Unreached(unit.host));
    const bool silent = unit.examining && unit.unread.empty();
    if (unit.asked) {  // it would start after it was given up
      unit.given_up = true;
      Examine(unit);
    }
    std::string how = " is " + unit.state.active + " for " +
                      std::to_string(ToMilliseconds(options_.start_within) / 1000) + " s";
    if (!unit.unread.empty()) how = "'s state cannot be read: " + unit.unread;
    if (silent) how = "'s state cannot be read: systemd does not answer";
    std::string why = unit.name + how + "; see `systemctl status ";
    // It has skipped the start before, and the clock of its host may not be the reason.
    if (silent && unit.gained != Duration()) {
      why = WhySkipped(unit.name, *unit.wanted) + "; see `journalctl -u ";
    }
    NotStarted(unit, NameOf(unit.host.config) + ": " + why + unit.name + "` there");
  });
}

// Ends the start that was given up: cancels its job, or stops the unit that the job has started.
void HostUnits::EndStart(Unit& unit) {
  if (!unit.asked || (unit.state.ended() && unit.job.empty())) return;
  unit.given_up = false;
  if (unit.state.ended()) return unit.host.systemd->Cancel(unit.job);
  if (IsOurs(unit)) unit.host.systemd->Stop(unit.state.invocation);
}

void HostUnits::StartUnit(Unit& unit) {
  if (unit.state.active == "failed") Reset(unit);
  UnitStart start;
  start.unit = unit.name;
  start.description = unit.actuator + " of the machine " + config_.name;
  start.process = *unit.wanted;
  const auto output = unit.host.is_own() && hooks_.output ? hooks_.output(unit.actuator) : nullptr;
  if (output) start.process.output = output->get();
  if (unit.host.is_own()) start.stops_after = options_.own_unit;
  // A start that waits in a lost connection is not carried out later, when it may not be wanted any
  // more.
  start.until =
      unit.host.systemd->running() + std::max(unit.host.gained, unit.gained) + kStartValid;
  unit.asked = true;
  unit.given_up = false;
  unit.job.clear();
  unit.state = {};
  if (unit.waits) ArmDeadline(unit);
  unit.host.systemd->Start(
      start, [this, &unit](const std::optional<SystemdError>& error, const std::string& job) {
        OnStartAnswered(unit, error, job);
      });
}

void HostUnits::OnStartAnswered(Unit& unit, const std::optional<SystemdError>& error,
                                const std::string& job) {
  if (!error) {
    unit.job = job;
    if (unit.given_up) Examine(unit);
    return;
  }
  unit.asked = false;
  if (!unit.wanted) return;
  // Another controller was faster, or the unit before it has not been dropped yet.
  if (error->kind == SystemdError::Kind::kUnitExists) {
    unit.again = loop_.At(loop_.Now() + Milliseconds(50), [this, &unit] { Examine(unit); });
    return;
  }
  const std::string host = PlaceOf(unit.host.config);
  // systemd starts no unit beside the job of its shutdown, until that job has ended.
  if (error->kind == SystemdError::Kind::kShuttingDown) {
    unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
    if (!unit.waits) Await(unit, host + " is shutting down");
    return;
  }
  // There it keeps the file of such a unit, which it could not write.
  const bool unwritten = error->kind == SystemdError::Kind::kGone;
  NotStarted(unit, host + ": " + TextOf(*error) +
                       (unwritten ? "; its /run may be full: see `df /run` there" : ""));
}

// The job of the start has ended. The signals about the unit have arrived before.
void HostUnits::OnJobRemoved(Unit& unit, const std::string& job, const std::string& result) {
  if (!unit.asked || unit.job != job) return;
  unit.asked = false;
  unit.given_up = false;
  const auto pid = static_cast<pid_t>(unit.state.exec_pid);
  const bool done = result == kJobDone;
  const Duration gained = std::max(unit.host.gained, std::exchange(unit.gained, {}));
  if (done && pid != 0) unit.host.gained = gained;
  const bool not_executed = !done && unit.state.exec_code == CLD_EXITED &&
                            unit.state.exec_status >= kFirstOfSystemd &&
                            unit.state.exec_status <= kLastOfSystemd;
  // Also a process that has exited before systemd has counted it as started.
  if (pid != 0 && !not_executed && (done || unit.state.ended())) {
    Started(unit, pid, !unit.wanted);
    if (unit.state.ended() && unit.pid == pid) Ended(unit);
    return;
  }
  if (unit.state.active == "failed") Reset(unit);
  if (!unit.wanted) return;
  // Nothing was executed. Either the start came too late, because the clock of that host has gained
  // on the clock of this one, or the unit cannot be set up. Starts of other units may work.
  const bool skipped = result == kJobSkipped || (done && pid == 0);
  if (skipped && gained < kMostGained) {
    unit.gained = std::max(kStartValid, gained * 2);
    return Examine(unit);
  }
  const ProcessSpec& spec = *unit.wanted;
  if (not_executed && unit.state.exec_status == kNoSuchUser) {
    return NotStarted(unit, PlaceOf(unit.host.config) + " has no user " + spec.limits.user +
                                "; make it there, or correct `user`");
  }
  const ProcessExit exit = ExitOf(unit.state, pid, unit.name, spec.limits, unit.host.config);
  std::string why = "the start of " + unit.name + " has ended as '" + result + "'";
  if (!exit.out_of_memory.empty()) why = "the start of " + unit.name + " has ended " + exit.Text();
  if (skipped) why = WhySkipped(unit.name, spec);
  if (not_executed) {
    // By its name, which /usr/bin/env may have looked up.
    const auto& command = config_.actuators[*config_.IndexOf(unit.actuator)].command;
    why = WhyNotExecuted(unit.state.exec_status, command.front(), spec);
  }
  NotStarted(unit, NameOf(unit.host.config) + ": " + why + "; see `journalctl -u " + unit.name +
                       "` there");
}

// --- signals and searches ---

void HostUnits::Signal(const std::string& actuator, pid_t pid, int signal) {
  Unit& unit = *units_.at(actuator);
  if (unit.pid != pid || pid == 0) return;
  unit.signalled = true;
  if (unit.signal != SIGKILL) unit.signal = signal;
  // Else once it is reached, which the connection sees to, less and less often.
  if (unit.host.systemd->is_up()) Kill(unit, signal);
}

void HostUnits::Find(std::function<void(const std::vector<Found>&)> done) {
  auto search = std::make_unique<Search>();
  search->done = std::move(done);
  for (const auto& [actuator, unit] : units_) search->until[unit.get()] = unit->examined;
  const Duration within = std::max(kFindWithin, config_.shutdown_budget * 3 / 10);
  search->deadline = loop_.At(loop_.Now() + within, [this, one = search.get()] {
    one->over = true;
    AnswerSearches();
  });
  searches_.push_back(std::move(search));
  for (auto& [name, host] : hosts_) host->systemd->Open();
  for (auto& [actuator, unit] : units_) Examine(*unit);
}

void HostUnits::AnswerSearches() {
  const auto waits = [this](const Search& search) {
    return !search.over && std::any_of(search.until.begin(), search.until.end(), [&](auto& one) {
      const Unit& unit = *one.first;
      if (search.failed.contains(&unit.host)) return false;
      return unit.examined == one.second || IsChanging(unit);
    });
  };
  for (std::size_t i = 0; i < searches_.size();) {
    if (waits(*searches_[i])) {
      ++i;
      continue;
    }
    const std::unique_ptr<Search> search = std::move(searches_[i]);
    searches_.erase(searches_.begin() + static_cast<std::ptrdiff_t>(i));
    std::vector<Found> found;
    for (const auto& [unit, before] : search->until) {
      Found& one = found.emplace_back(
          Found{unit->actuator, unit->pid, unit->host.IdOf(unit->host.seen), ""});
      const bool examined = unit->examined != before;
      if (examined && !IsChanging(*unit)) continue;
      one.pid = 0;
      if (unit->host.is_own()) {  // the kernel says which processes run here
        if (!unit->asked) continue;
        one.unreached = PlaceOf(unit->host.config) + ": " + unit->name + " is about to start";
        continue;
      }
      const bool up = unit->host.systemd->is_up();
      if (up && examined) {
        one.unreached = unit->name + " is " + (unit->asked ? "about to start" : unit->state.active);
      } else if (up && !unit->unread.empty()) {
        one.unreached = unit->name + "'s state cannot be read: " + unit->unread;
      } else {
        one.unreached = TroubleOf(*unit->host.systemd);
      }
    }
    search->done(found);
  }
}

}  // namespace musher
