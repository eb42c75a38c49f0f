#include "musher/controller/process/host_units.hpp"

#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <systemd/sd-bus.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string_view>
#include <utility>

#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/process/ssh.hpp"
#include "musher/controller/process/unit_end.hpp"

namespace musher {
namespace {

constexpr const char* kManagerPath = "/org/freedesktop/systemd1";
constexpr const char* kUnitPath = "/org/freedesktop/systemd1/unit";
constexpr const char* kManager = "org.freedesktop.systemd1.Manager";
constexpr const char* kService = "org.freedesktop.systemd1.Service";
constexpr const char* kUnitInterface = "org.freedesktop.systemd1.Unit";
constexpr const char* kProperties = "org.freedesktop.DBus.Properties";

// A search is a part of a TearDown, which has to know before its budget is used up which hosts have
// not answered. A connection that is just being made needs some time.
constexpr Duration kFindWithin = Milliseconds(1'000);
constexpr Duration kExamineAgain = Milliseconds(500);
// How long a host may carry out a start after it was sent: a greeting that was late by all of the
// time for it (8 s), a start within its time (10 s), and a margin.
constexpr Duration kStartValid = Milliseconds(20'000);
// How long a host may have been off before its connection is found to be lost (ssh: 6 s).
constexpr Duration kLossSeenWithin = Milliseconds(10'000);
// What a process leaves behind gets SIGTERM, and SIGKILL after this time.
constexpr std::uint64_t kRestEndsWithinUs = 2'000'000;
constexpr const char* kDeniedCure =
    "; its systemd lets this user start and end no unit: set `user` to root, or permit it by "
    "polkit "
    "(org.freedesktop.systemd1.manage-units)";
// Exit codes of systemd itself: the program was not executed (systemd.exec(5)).
constexpr int kFirstOfSystemd = 200;
constexpr int kLastOfSystemd = 243;
constexpr int kNoSuchUser = 217;

// What systemd knows of a unit. The values of a unit that is not loaded are these.
struct UnitState {
  std::string active = "inactive";
  std::uint32_t main_pid = 0;
  std::uint32_t exec_pid = 0;  // of the last process, also after its exit
  std::int32_t exec_code = 0;  // CLD_EXITED, CLD_KILLED, CLD_DUMPED
  std::int32_t exec_status = 0;
  std::string result = {};
  std::set<std::string> environment = {};

  bool runs() const { return active == "active" || active == "reloading"; }
  bool ended() const { return active == "inactive" || active == "failed"; }
};

void ReadText(sd_bus_message* message, std::string& text) {
  const char* value = nullptr;
  if (sd_bus_message_read(message, "v", "s", &value) >= 0) text = value;
}

template <typename Number>
void ReadNumber(sd_bus_message* message, const char* type, Number& number) {
  Number value = 0;
  if (sd_bus_message_read(message, "v", type, &value) >= 0) number = value;
}

void ReadTexts(sd_bus_message* message, std::set<std::string>& texts) {
  if (sd_bus_message_enter_container(message, 'v', "as") < 0) return;
  if (sd_bus_message_enter_container(message, 'a', "s") >= 0) {
    texts.clear();
    const char* text = nullptr;
    while (sd_bus_message_read(message, "s", &text) > 0) texts.emplace(text);
    sd_bus_message_exit_container(message);
  }
  sd_bus_message_exit_container(message);
}

// Reads "a{sv}" with properties of any interface of a unit.
void ReadProperties(sd_bus_message* message, UnitState& state) {
  if (sd_bus_message_enter_container(message, 'a', "{sv}") < 0) return;
  while (sd_bus_message_enter_container(message, 'e', "sv") > 0) {
    const char* name = nullptr;
    if (sd_bus_message_read(message, "s", &name) < 0) break;
    const std::string_view property = name;
    if (property == "ActiveState") {
      ReadText(message, state.active);
    } else if (property == "MainPID") {
      ReadNumber(message, "u", state.main_pid);
    } else if (property == "ExecMainPID") {
      ReadNumber(message, "u", state.exec_pid);
    } else if (property == "ExecMainCode") {
      ReadNumber(message, "i", state.exec_code);
    } else if (property == "ExecMainStatus") {
      ReadNumber(message, "i", state.exec_status);
    } else if (property == "Result") {
      ReadText(message, state.result);
    } else if (property == "Environment") {
      ReadTexts(message, state.environment);
    } else {
      sd_bus_message_skip(message, "v");
    }
    if (sd_bus_message_exit_container(message) < 0) break;
  }
  sd_bus_message_exit_container(message);
}

ProcessExit ExitOf(const UnitState& state, pid_t pid, const ProcessLimits& limits) {
  ProcessExit exit;
  if (state.ended() && state.result == "oom-kill") {
    const auto& most = limits.memory_max_bytes;
    exit.out_of_memory =
        most ? "memory_max_mb = " + std::to_string(*most >> 20) : "the memory of its host";
  }
  if (static_cast<pid_t>(state.exec_pid) != pid || !state.ended()) return exit;
  exit.number = state.exec_status;
  if (state.exec_code == CLD_EXITED) exit.kind = ProcessExit::Kind::kExited;
  if (state.exec_code == CLD_KILLED || state.exec_code == CLD_DUMPED) {
    exit.kind = ProcessExit::Kind::kKilled;
  }
  return exit;
}

// Why nothing is known of the host.
std::string TroubleOf(const HostBus& bus) {
  if (!bus.trouble().empty()) return bus.trouble();
  return bus.is_up() ? "it does not answer" : "it has not answered yet";
}

std::string ErrorText(const BusMessage& reply) {
  const sd_bus_error* error = sd_bus_message_get_error(reply.get());
  if (error == nullptr) return "unknown";
  return error->message != nullptr ? error->message : error->name;
}

bool IsError(const BusMessage& reply, const char* name = nullptr) {
  return sd_bus_message_is_method_error(reply.get(), name) > 0;
}

bool IsDenied(const BusMessage& reply) {
  return IsError(reply, SD_BUS_ERROR_ACCESS_DENIED) ||
         IsError(reply, SD_BUS_ERROR_INTERACTIVE_AUTHORIZATION_REQUIRED);
}

// Also while this host is suspended.
Duration SinceBoot() {
  timespec now{};
  clock_gettime(CLOCK_BOOTTIME, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec);
}

std::string_view BootOf(std::string_view host_id) {
  return host_id.substr(0, host_id.find('/'));
}

std::string PathOf(const std::string& unit) {
  char* path = nullptr;
  if (sd_bus_path_encode(kUnitPath, unit.c_str(), &path) < 0) return {};
  std::string text = path;
  free(path);  // NOLINT(cppcoreguidelines-no-malloc): sd-bus's
  return text;
}

void AppendText(sd_bus_message* message, const char* name, const std::string& value) {
  sd_bus_message_append(message, "(sv)", name, "s", value.c_str());
}

void AppendTexts(sd_bus_message* message, const std::vector<std::string>& texts) {
  sd_bus_message_open_container(message, 'a', "s");
  for (const std::string& text : texts) sd_bus_message_append(message, "s", text.c_str());
  sd_bus_message_close_container(message);
}

// Opens the property's struct and variant; the caller appends the value and closes both.
void OpenProperty(sd_bus_message* message, const char* name, const char* type) {
  sd_bus_message_open_container(message, 'r', "sv");
  sd_bus_message_append(message, "s", name);
  sd_bus_message_open_container(message, 'v', type);
}
void CloseProperty(sd_bus_message* message) {
  sd_bus_message_close_container(message);
  sd_bus_message_close_container(message);
}

// Of "ExecStartEx" and its kind. Without the flag "no-env-expand" systemd replaces $NAME in the
// arguments.
void AppendCommand(sd_bus_message* message, const char* property,
                   const std::vector<std::string>& argv, const std::vector<std::string>& flags) {
  OpenProperty(message, property, "a(sasas)");
  sd_bus_message_open_container(message, 'a', "(sasas)");
  sd_bus_message_open_container(message, 'r', "sasas");
  sd_bus_message_append(message, "s", argv.front().c_str());
  AppendTexts(message, argv);
  AppendTexts(message, flags);
  sd_bus_message_close_container(message);
  sd_bus_message_close_container(message);
  CloseProperty(message);
}

// Of a unit, as the kernel weighs a process: a step of nice is a quarter more or less.
std::uint64_t CpuWeight(int nice) {
  constexpr double kOfNiceZero = 100;
  const double weight = std::round(kOfNiceZero * std::pow(1.25, -nice));
  return static_cast<std::uint64_t>(std::clamp(weight, 1.0, 10'000.0));
}

void AppendLimits(sd_bus_message* message, const ProcessLimits& limits) {
  constexpr std::uint64_t kSecondUs = 1'000'000;
  if (limits.memory_max_bytes) {
    const auto most = static_cast<std::uint64_t>(*limits.memory_max_bytes);
    sd_bus_message_append(message, "(sv)", "MemoryMax", "t", most);
    // Else it would grow on into the swap, and slow down the whole host.
    sd_bus_message_append(message, "(sv)", "MemorySwapMax", "t", std::uint64_t{0});
  }
  AppendText(message, "OOMPolicy", "kill");  // of all its processes, or none
  if (limits.cpus) {
    const auto quota = static_cast<std::uint64_t>(*limits.cpus * static_cast<double>(kSecondUs));
    sd_bus_message_append(message, "(sv)", "CPUQuotaPerSecUSec", "t", quota);
  }
  if (limits.nice) {
    sd_bus_message_append(message, "(sv)", "Nice", "i", *limits.nice);
    // Nice counts among the processes of one session or unit only, where the kernel weighs those.
    sd_bus_message_append(message, "(sv)", "CPUWeight", "t", CpuWeight(*limits.nice));
  }
  if (limits.realtime_priority) {
    sd_bus_message_append(message, "(sv)", "CPUSchedulingPolicy", "i", SCHED_FIFO);
    sd_bus_message_append(message, "(sv)", "CPUSchedulingPriority", "i", *limits.realtime_priority);
  }
  if (!limits.user.empty()) AppendText(message, "User", limits.user);
}

}  // namespace

struct HostUnits::Host {
  const HostConfig& config;
  std::unique_ptr<HostBus> bus;
  std::vector<Unit*> units = {};
  std::string seen = {};                 // its HostId() when its units were looked at last
  bool reported = false;                 // that it is out of reach
  std::optional<Duration> lost_at = {};  // SinceBoot() when its connection was lost last
};

struct HostUnits::Unit {
  Host& host;
  std::string actuator;
  std::string name;
  std::string path;
  UnitState state = {};
  pid_t pid = 0;                           // of the process that was reported as started
  std::optional<ProcessSpec> wanted = {};  // to be started
  bool waits = false;                      // for its host, with that start, which was reported
  bool asked = false;                      // StartTransientUnit was sent
  std::string job = {};                    // its job
  int signal = 0;                          // to be sent, or sent and not confirmed
  bool refused = false;                    // a signal was, which was reported
  bool signalled = false;                  // the machine ends its process
  std::optional<ProcessExit> exit = {};    // of the process, which is not reported yet
  bool asks_system = false;                // whether its host shuts down
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
                     std::function<MachineIdentity()> machine, Duration start_within)
    : loop_(loop), config_(config), machine_(std::move(machine)), start_within_(start_within) {
  for (const HostConfig& host : config.hosts) {
    HostBus::Options options;
    options.ssh = SshArguments(host);
    options.login = host.Login();
    const std::string from = "type='signal',sender='org.freedesktop.systemd1',";
    options.matches.push_back(from + "interface='" + kManager + "',member='JobRemoved'");
    auto made = std::make_unique<Host>(Host{host, nullptr});
    for (const ActuatorConfig& actuator : config.actuators) {
      if (actuator.host != host.name) continue;
      const std::string name = UnitNameOf(config.name, actuator.name);
      auto unit = std::make_unique<Unit>(Unit{*made, actuator.name, name, PathOf(name)});
      options.matches.push_back(from + "interface='" + kProperties +
                                "',member='PropertiesChanged',path='" + unit->path + "'");
      made->units.push_back(unit.get());
      units_.emplace(actuator.name, std::move(unit));
    }
    if (made->units.empty()) continue;
    HostBus::Hooks hooks;
    hooks.on_up = [this, &one = *made] { OnUp(one); };
    hooks.on_down = [this, &one = *made](bool was_up, bool for_good) {
      OnDown(one, was_up, for_good);
    };
    hooks.on_signal = [this, &one = *made](const BusMessage& message) { OnSignal(one, message); };
    hooks.refuse = [this, &one = *made](const std::string& id, Duration running) {
      return WhyRefused(one, id, running);
    };
    made->bus = std::make_unique<HostBus>(loop, std::move(options), std::move(hooks));
    hosts_.emplace(host.name, std::move(made));
  }
}

HostUnits::~HostUnits() {
  HostUnits::Close();
}

void HostUnits::Open(Hooks hooks) {
  hooks_ = std::move(hooks);
  open_ = true;
  for (auto& [name, host] : hosts_) host->bus->Open();
}

void HostUnits::Close() {
  open_ = false;
  for (auto& [name, host] : hosts_) host->bus->Close();
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
  return "host " + host.config.name + " (" + host.config.Login() + "): " + TroubleOf(*host.bus);
}

// Its address may be that of another board now, with the same key if one image was copied to both.
// That board was not booted since this one was reached last.
std::string HostUnits::WhyRefused(const Host& host, const std::string& id, Duration running) const {
  if (host.seen.empty() || !host.lost_at || BootOf(host.seen) == BootOf(id)) return {};
  const Duration lost_for = SinceBoot() - *host.lost_at;
  if (running <= lost_for + kLossSeenWithin) return {};
  return "another host answers at " + host.config.address + ", which was not booted since " +
         host.config.name + " was reached last";
}

void HostUnits::OnUp(Host& host) {
  const std::string& id = host.bus->host_id();
  const bool rebooted = !host.seen.empty() && host.seen != id;
  if (std::exchange(host.reported, false)) {
    hooks_.on_reach(true, "host " + host.config.name + " is reached" +
                              (rebooted ? ", and has been booted again" : ""));
  }
  for (Unit* unit : host.units) {
    unit->state = {};
    unit->examining = false;
    unit->unread.clear();
    unit->asked = false;
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
  if (was_up) host.lost_at = SinceBoot();
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

void HostUnits::OnSignal(Host& host, const BusMessage& message) {
  sd_bus_message* const signal = message.get();
  if (sd_bus_message_is_signal(signal, kManager, "JobRemoved") > 0) {
    std::uint32_t id = 0;
    const char* job = nullptr;
    const char* name = nullptr;
    const char* result = nullptr;
    if (sd_bus_message_read(signal, "uoss", &id, &job, &name, &result) < 0) return;
    for (Unit* unit : host.units) {
      if (unit->name != name) continue;
      OnJobRemoved(*unit, job, result);
      return AnswerSearches();
    }
    return;
  }
  const char* interface = nullptr;
  if (sd_bus_message_is_signal(signal, kProperties, "PropertiesChanged") <= 0 ||
      sd_bus_message_read(signal, "s", &interface) < 0) {
    return;
  }
  const std::string path = sd_bus_message_get_path(signal);
  for (Unit* unit : host.units) {
    if (unit->path != path) continue;
    ReadProperties(signal, unit->state);
    // systemd sends the properties of the service first, then those of the unit.
    if (std::string_view(interface) == kUnitInterface) OnChange(*unit);
    return;
  }
}

// --- the state of a unit ---

// Reads what systemd knows of it. A unit that is not loaded is inactive.
void HostUnits::Examine(Unit& unit) {
  HostBus& bus = *unit.host.bus;
  if (!bus.is_up() || std::exchange(unit.examining, true)) return;
  const auto get_all = [&](const char* interface, HostBus::OnReply done) {
    const BusMessage call = bus.NewCall(unit.path, kProperties, "GetAll");
    if (!call) return;
    sd_bus_message_append(call.get(), "s", interface);
    bus.Send(call, std::move(done));
  };
  get_all(kService, [&unit](const BusMessage& reply) {
    unit.unread = IsError(reply) ? ErrorText(reply) : "";
    if (!unit.unread.empty()) return;
    unit.state = {.active = unit.state.active};
    ReadProperties(reply.get(), unit.state);
  });
  get_all(kUnitInterface, [this, &unit](const BusMessage& reply) {
    unit.examining = false;
    if (IsError(reply)) unit.unread = ErrorText(reply);
    // An error says nothing of the process.
    if (!unit.unread.empty()) {
      unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
      return;
    }
    ReadProperties(reply.get(), unit.state);
    Examined(unit);
  });
}

void HostUnits::Examined(Unit& unit) {
  ++unit.examined;
  Conclude(unit);
  if (unit.pid != 0 && unit.signal != 0) {
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
    const bool same = main_pid == unit.pid || static_cast<pid_t>(state.exec_pid) == unit.pid;
    if (state.ended() || (state.runs() && !same)) return Ended(unit);
    if (unit.wanted && state.runs()) Started(unit, unit.pid, true);
    return;
  }
  if (unit.asked) return;  // its job decides
  if (state.runs() && main_pid != 0) {
    if (IsOurs(unit)) return Started(unit, main_pid, true);
    if (unit.wanted) {
      NotStarted(unit, "host " + unit.host.config.name + " runs " + unit.name +
                           " already, for another machine of this name; give one of the machines "
                           "another name, or run `systemctl stop " +
                           unit.name + "` there");
    }
    return;
  }
  if (!unit.wanted || !state.ended()) return;
  // Its host was reached too late.
  if (!hooks_.still_starts(unit.actuator)) return NotStarted(unit, "the machine is torn down");
  StartUnit(unit);
}

void HostUnits::Started(Unit& unit, pid_t pid, bool found) {
  if (unit.pid != pid) unit.signalled = false;
  unit.pid = pid;
  unit.refused = false;
  unit.wanted.reset();
  unit.waits = false;
  unit.deadline = nullptr;
  unit.again = nullptr;
  hooks_.on_started(unit.actuator, pid, unit.host.bus->host_id(), found);
}

void HostUnits::NotStarted(Unit& unit, const std::string& why) {
  unit.wanted.reset();
  unit.waits = false;
  unit.deadline = nullptr;
  unit.again = nullptr;
  hooks_.on_not_started(unit.actuator, why, false);
}

// The start stays wanted.
void HostUnits::Await(Unit& unit, const std::string& why) {
  unit.waits = true;
  unit.deadline = nullptr;
  hooks_.on_not_started(unit.actuator, why + "; it is started once its host is reached", true);
}

void HostUnits::Ended(Unit& unit) {
  if (unit.asks_system) return;
  const ActuatorIndex i = *config_.IndexOf(unit.actuator);
  if (!unit.exit) unit.exit = ExitOf(unit.state, unit.pid, config_.actuators[i].limits);
  const bool wanted = unit.signalled || !hooks_.still_starts(unit.actuator);
  if (NeedsSystemState(*unit.exit, wanted)) return AskSystemState(unit);
  ReportEnd(unit, *unit.exit);
}

// If the connection is lost before the reply, the unit is looked at again once the host is reached.
void HostUnits::AskSystemState(Unit& unit) {
  const BusMessage call = unit.host.bus->NewCall(kManagerPath, kProperties, "Get");
  if (!call) return;
  unit.asks_system = true;
  sd_bus_message_append(call.get(), "ss", kManager, "SystemState");
  unit.host.bus->Send(call, [this, &unit](const BusMessage& reply) {
    if (!std::exchange(unit.asks_system, false) || unit.pid == 0) return;
    // A host that is short of everything is asked once more, with the unit.
    if (IsError(reply, SD_BUS_ERROR_NO_REPLY) || IsError(reply, SD_BUS_ERROR_TIMEOUT)) {
      unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
      return;
    }
    std::string system_state;
    if (!IsError(reply)) ReadText(reply.get(), system_state);
    ReportEnd(unit, EndOfUnit(*unit.exit, system_state, false));
    AnswerSearches();
  });
}

void HostUnits::ReportEnd(Unit& unit, const ProcessExit& exit) {
  const pid_t pid = std::exchange(unit.pid, 0);
  const ProcessExit reported = exit;  // may be the unit's
  unit.exit.reset();
  unit.signal = 0;
  if (unit.state.active == "failed") Reset(unit);
  if (unit.wanted) unit.again = loop_.At(loop_.Now(), [this, &unit] { Examine(unit); });
  hooks_.on_ended(unit.actuator, pid, reported);
}

// A unit that has failed is kept by systemd, with its name, until it is reset.
void HostUnits::Reset(Unit& unit) {
  const BusMessage call = unit.host.bus->NewCall(kManagerPath, kManager, "ResetFailedUnit");
  if (!call) return;
  sd_bus_message_append(call.get(), "s", unit.name.c_str());
  unit.host.bus->Send(call, nullptr);
}

void HostUnits::Kill(Unit& unit, int signal) {
  const BusMessage call = unit.host.bus->NewCall(kManagerPath, kManager, "KillUnit");
  if (!call) return;
  sd_bus_message_append(call.get(), "ssi", unit.name.c_str(), "all", signal);
  // Without a reply it may be lost with the connection: then it is sent again.
  unit.host.bus->Send(call, [this, &unit, signal](const BusMessage& reply) {
    if (unit.signal == signal) unit.signal = 0;
    const bool refused = IsError(reply) && !IsError(reply, "org.freedesktop.systemd1.NoSuchUnit");
    if (!refused || std::exchange(unit.refused, true)) return;
    hooks_.on_reach(false, "host " + unit.host.config.name + " (" + unit.host.config.Login() +
                               "): the signal to " + unit.name + " was refused: " +
                               ErrorText(reply) + (IsDenied(reply) ? kDeniedCure : ""));
  });
}

void HostUnits::Stop(Unit& unit) {
  const BusMessage call = unit.host.bus->NewCall(kManagerPath, kManager, "StopUnit");
  if (!call) return;
  sd_bus_message_append(call.get(), "ss", unit.name.c_str(), "replace");
  unit.host.bus->Send(call, nullptr);
}

// --- starts ---

void HostUnits::Start(const ProcessSpec& spec) {
  Unit& unit = *units_.at(spec.name);
  unit.wanted = spec;
  unit.waits = false;
  ArmDeadline(unit);
  // Not inside this call.
  unit.again = loop_.At(loop_.Now(), [this, &unit] {
    unit.host.bus->Open();
    Examine(unit);
  });
}

// A start waits so long for the unit before it to end, or until its host is said to be out of
// reach.
void HostUnits::ArmDeadline(Unit& unit) {
  unit.deadline = loop_.At(loop_.Now() + start_within_, [this, &unit] {
    if (!unit.wanted) return;
    if (!unit.host.bus->is_up()) return Await(unit, Unreached(unit.host));
    if (unit.asked) Stop(unit);  // it would start after it was given up
    const std::string how = unit.unread.empty()
                                ? " is " + unit.state.active + " for " +
                                      std::to_string(ToMilliseconds(start_within_) / 1000) + " s"
                                : "'s state cannot be read: " + unit.unread;
    NotStarted(unit, "host " + unit.host.config.name + ": " + unit.name + how +
                         "; see `systemctl status " + unit.name + "` there");
  });
}

void HostUnits::StartUnit(Unit& unit) {
  if (unit.state.active == "failed") Reset(unit);
  const BusMessage call = unit.host.bus->NewCall(kManagerPath, kManager, "StartTransientUnit");
  if (!call) return;
  const ProcessSpec& spec = *unit.wanted;
  sd_bus_message* const m = call.get();
  sd_bus_message_append(m, "ss", unit.name.c_str(), "fail");
  sd_bus_message_open_container(m, 'a', "(sv)");
  AppendText(m, "Description", unit.actuator + " of the machine " + config_.name);
  AppendText(m, "Type", "exec");  // its start fails if the program cannot be executed
  AppendText(m, "SyslogIdentifier", unit.actuator);
  if (!spec.cwd.empty()) AppendText(m, "WorkingDirectory", spec.cwd);
  sd_bus_message_append(m, "(sv)", "TimeoutStopUSec", "t", kRestEndsWithinUs);
  AppendLimits(m, spec.limits);
  OpenProperty(m, "Environment", "as");
  std::vector<std::string> environment;
  environment.reserve(spec.env.size());
  for (const auto& [name, value] : spec.env) environment.push_back(name + "=" + value);
  AppendTexts(m, environment);
  CloseProperty(m);
  // What waits in a connection that is lost starts nothing later, when no one may want it any more.
  const Duration until = unit.host.bus->running() + kStartValid;
  AppendCommand(m, "ExecConditionEx", UntilHostHasRun(until), {"no-env-expand", "privileged"});
  AppendCommand(m, "ExecStartEx", spec.argv, {"no-env-expand"});
  sd_bus_message_close_container(m);
  sd_bus_message_append(m, "a(sa(sv))", 0);
  unit.asked = true;
  unit.job.clear();
  unit.state = {};
  if (unit.waits) ArmDeadline(unit);
  unit.host.bus->Send(call,
                      [this, &unit](const BusMessage& reply) { OnStartAnswered(unit, reply); });
}

void HostUnits::OnStartAnswered(Unit& unit, const BusMessage& reply) {
  const char* job = nullptr;
  if (!IsError(reply) && sd_bus_message_read(reply.get(), "o", &job) >= 0) {
    unit.job = job;
    return;
  }
  unit.asked = false;
  if (!unit.wanted) return;
  // Another controller was faster, or the unit before it has not been dropped yet.
  if (IsError(reply, "org.freedesktop.systemd1.UnitExists")) {
    unit.again = loop_.At(loop_.Now() + Milliseconds(50), [this, &unit] { Examine(unit); });
    return;
  }
  const std::string host = "host " + unit.host.config.name + " (" + unit.host.config.Login() + ")";
  // Nothing starts beside the job of its shutdown, until that has ended.
  if (IsError(reply, "org.freedesktop.systemd1.TransactionIsDestructive")) {
    unit.again = loop_.At(loop_.Now() + kExamineAgain, [this, &unit] { Examine(unit); });
    if (!unit.waits) Await(unit, host + " is shutting down");
    return;
  }
  NotStarted(unit, host + ": " + ErrorText(reply) + (IsDenied(reply) ? kDeniedCure : ""));
}

// The job of the start has ended. The signals about the unit have arrived before.
void HostUnits::OnJobRemoved(Unit& unit, const std::string& job, const std::string& result) {
  if (!unit.asked || unit.job != job) return;
  unit.asked = false;
  const auto pid = static_cast<pid_t>(unit.state.exec_pid);
  const bool done = result == "done";
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
  const ProcessSpec& spec = *unit.wanted;
  if (not_executed && unit.state.exec_status == kNoSuchUser) {
    return NotStarted(unit, "host " + unit.host.config.name + " (" + unit.host.config.Login() +
                                ") has no user " + spec.limits.user +
                                "; make it there, or correct `user`");
  }
  const std::string program = spec.argv.front();
  NotStarted(unit, "host " + unit.host.config.name + ": " +
                       (not_executed
                            ? program + " could not be executed there (systemd's exit code " +
                                  std::to_string(unit.state.exec_status) + "); see"
                            : "the start of " + unit.name + " has ended as '" + result + "'; see") +
                       " `journalctl -u " + unit.name + "` there");
}

// --- signals and searches ---

void HostUnits::Signal(const std::string& actuator, pid_t pid, int signal) {
  Unit& unit = *units_.at(actuator);
  if (unit.pid != pid || pid == 0) return;
  unit.signalled = true;
  if (unit.signal != SIGKILL) unit.signal = signal;
  // Else once it is reached, which the connection sees to, less and less often.
  if (unit.host.bus->is_up()) Kill(unit, signal);
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
  for (auto& [name, host] : hosts_) host->bus->Open();
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
      Found& one = found.emplace_back(Found{unit->actuator, unit->pid, unit->host.seen, ""});
      const bool examined = unit->examined != before;
      if (examined && !IsChanging(*unit)) continue;
      one.pid = 0;
      const bool up = unit->host.bus->is_up();
      if (up && examined) {
        one.unreached = unit->name + " is " + (unit->asked ? "about to start" : unit->state.active);
      } else if (up && !unit->unread.empty()) {
        one.unreached = unit->name + "'s state cannot be read: " + unit->unread;
      } else {
        one.unreached = TroubleOf(*unit->host.bus);
      }
    }
    search->done(found);
  }
}

}  // namespace musher
