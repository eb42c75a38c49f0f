#include "musher/controller/process/bus_systemd.hpp"

#include <sched.h>
#include <systemd/sd-bus.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <map>
#include <utility>

#include "musher/controller/process/host_bus.hpp"
#include "musher/controller/process/host_uptime.hpp"
#include "musher/controller/process/ssh.hpp"

namespace musher {
namespace {

constexpr const char* kManagerPath = "/org/freedesktop/systemd1";
constexpr const char* kUnitPath = "/org/freedesktop/systemd1/unit";
constexpr const char* kManager = "org.freedesktop.systemd1.Manager";
constexpr const char* kService = "org.freedesktop.systemd1.Service";
constexpr const char* kUnitInterface = "org.freedesktop.systemd1.Unit";
constexpr const char* kProperties = "org.freedesktop.DBus.Properties";
constexpr const char* kJob = "org.freedesktop.systemd1.Job";

// What a process leaves behind gets SIGTERM, and SIGKILL after this time.
constexpr std::uint64_t kRestEndsWithinUs = 2'000'000;

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

// Reads an id of 16 bytes as hexadecimal digits.
void ReadId(sd_bus_message* message, std::string& id) {
  if (sd_bus_message_enter_container(message, 'v', "ay") < 0) return;
  const void* bytes = nullptr;
  std::size_t size = 0;
  if (sd_bus_message_read_array(message, 'y', &bytes, &size) >= 0) {
    id.clear();
    for (std::size_t i = 0; i < size; ++i) {
      constexpr const char* kDigits = "0123456789abcdef";
      const unsigned byte = static_cast<const unsigned char*>(bytes)[i];
      id += {kDigits[byte >> 4], kDigits[byte & 15]};
    }
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
    } else if (property == "InvocationID") {
      ReadId(message, state.invocation);
    } else if (property == "Environment") {
      ReadTexts(message, state.environment);
    } else {
      sd_bus_message_skip(message, "v");
    }
    if (sd_bus_message_exit_container(message) < 0) break;
  }
  sd_bus_message_exit_container(message);
}

struct ErrorName {
  const char* name;
  SystemdError::Kind kind;
};
constexpr ErrorName kErrorNames[] = {
    {SD_BUS_ERROR_ACCESS_DENIED, SystemdError::Kind::kDenied},
    {SD_BUS_ERROR_INTERACTIVE_AUTHORIZATION_REQUIRED, SystemdError::Kind::kDenied},
    {SD_BUS_ERROR_NO_REPLY, SystemdError::Kind::kNoReply},
    {SD_BUS_ERROR_TIMEOUT, SystemdError::Kind::kNoReply},
    {SD_BUS_ERROR_UNKNOWN_OBJECT, SystemdError::Kind::kGone},
    {"org.freedesktop.systemd1.NoUnitForInvocationID", SystemdError::Kind::kGone},
    {"org.freedesktop.systemd1.NoSuchUnit", SystemdError::Kind::kGone},
    {"org.freedesktop.systemd1.UnitExists", SystemdError::Kind::kUnitExists},
    {"org.freedesktop.systemd1.TransactionIsDestructive", SystemdError::Kind::kShuttingDown},
};

// nullopt: it is no error.
std::optional<SystemdError> ErrorIn(const BusMessage& reply) {
  if (sd_bus_message_is_method_error(reply.get(), nullptr) <= 0) return std::nullopt;
  SystemdError error;
  const sd_bus_error* said = sd_bus_message_get_error(reply.get());
  if (said != nullptr) error.text = said->message != nullptr ? said->message : said->name;
  for (const ErrorName& known : kErrorNames) {
    if (sd_bus_message_is_method_error(reply.get(), known.name) > 0) error.kind = known.kind;
  }
  return error;
}

// The object path of a unit, by the name of the unit or by the id of one start.
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

// Appends a command, as "ExecStartEx" has it. Without the flag "no-env-expand" systemd replaces
// $NAME in the arguments.
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

// The CPU weight of a unit. The kernel weighs a process the same way: a step of nice is a quarter
// more or less.
std::uint64_t CpuWeight(int nice) {
  constexpr double kOfNiceZero = 100;
  const double weight = std::round(kOfNiceZero * std::pow(1.25, -nice));
  return static_cast<std::uint64_t>(std::clamp(weight, 1.0, 10'000.0));
}

void AppendSandbox(sd_bus_message* message, const ProcessLimits& limits) {
  const auto set = [message](std::initializer_list<const char*> names) {
    for (const char* name : names) sd_bus_message_append(message, "(sv)", name, "b", 1);
  };
  if (limits.sandbox != Sandbox::kNone) {
    AppendText(message, "ProtectSystem", "strict");  // all of it is read-only
    set({"NoNewPrivileges"});
    OpenProperty(message, "ReadWritePaths", "as");
    AppendTexts(message, {"/tmp", "/var/tmp"});
    CloseProperty(message);
  }
  if (limits.sandbox == Sandbox::kStrict) {
    AppendText(message, "ProtectHome", "yes");
    set({"PrivateTmp", "ProtectKernelTunables", "ProtectKernelModules", "ProtectKernelLogs",
         "ProtectControlGroups", "RestrictSUIDSGID", "LockPersonality"});
  }
  if (!limits.LimitsDevices()) return;
  AppendText(message, "DevicePolicy", "closed");
  OpenProperty(message, "DeviceAllow", "a(ss)");
  sd_bus_message_open_container(message, 'a', "(ss)");
  for (const std::string& device : limits.devices.value_or(std::vector<std::string>())) {
    sd_bus_message_append(message, "(ss)", device.c_str(), "rw");
  }
  sd_bus_message_close_container(message);
  CloseProperty(message);
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
    // If the kernel weighs sessions or units, nice only counts among the processes of one of them.
    sd_bus_message_append(message, "(sv)", "CPUWeight", "t", CpuWeight(*limits.nice));
  }
  if (limits.realtime_priority) {
    sd_bus_message_append(message, "(sv)", "CPUSchedulingPolicy", "i", SCHED_FIFO);
    sd_bus_message_append(message, "(sv)", "CPUSchedulingPriority", "i", *limits.realtime_priority);
  }
  if (!limits.user.empty()) AppendText(message, "User", limits.user);
}

void AppendStart(sd_bus_message* m, const UnitStart& start) {
  const ProcessSpec& spec = start.process;
  sd_bus_message_append(m, "ss", start.unit.c_str(), "fail");
  sd_bus_message_open_container(m, 'a', "(sv)");
  AppendText(m, "Description", start.description);
  AppendText(m, "Type", "exec");  // its start fails if the program cannot be executed
  AppendText(m, "SyslogIdentifier", spec.name);
  if (!spec.cwd.empty()) AppendText(m, "WorkingDirectory", spec.cwd);
  sd_bus_message_append(m, "(sv)", "TimeoutStopUSec", "t", kRestEndsWithinUs);
  if (!start.stops_after.empty()) {
    OpenProperty(m, "Before", "as");  // stops are in the reverse order
    AppendTexts(m, {start.stops_after});
    CloseProperty(m);
  }
  if (spec.output >= 0) {  // else the journal
    for (const char* name : {"StandardOutputFileDescriptor", "StandardErrorFileDescriptor"}) {
      sd_bus_message_append(m, "(sv)", name, "h", spec.output);
    }
  }
  AppendLimits(m, spec.limits);
  AppendSandbox(m, spec.limits);
  OpenProperty(m, "Environment", "as");
  std::vector<std::string> environment;
  environment.reserve(spec.env.size());
  for (const auto& [name, value] : spec.env) environment.push_back(name + "=" + value);
  AppendTexts(m, environment);
  CloseProperty(m);
  AppendCommand(m, "ExecConditionEx", UntilHostHasRun(start.until),
                {"no-env-expand", "privileged"});
  AppendCommand(m, "ExecStartEx", spec.argv, {"no-env-expand"});
  sd_bus_message_close_container(m);
  sd_bus_message_append(m, "a(sa(sv))", 0);
}

class BusSystemd : public Systemd {
 public:
  BusSystemd(transport::EventLoop& loop, HostBus::Options options,
             const std::vector<std::string>& units, Hooks hooks)
      : hooks_(std::move(hooks)) {
    const std::string from = "type='signal',sender='org.freedesktop.systemd1',";
    options.matches.push_back(from + "interface='" + kManager + "',member='JobRemoved'");
    for (const std::string& unit : units) {
      const std::string path = PathOf(unit);
      options.matches.push_back(from + "interface='" + kProperties +
                                "',member='PropertiesChanged',path='" + path + "'");
      units_.emplace(path, unit);
    }
    bus_ = std::make_unique<HostBus>(
        loop, std::move(options),
        HostBus::Hooks{hooks_.on_up, hooks_.on_down,
                       [this](const BusMessage& message) { OnSignal(message.get()); },
                       hooks_.refuse});
  }

  void Open() override { bus_->Open(); }
  void Close() override { bus_->Close(); }
  bool is_up() const override { return bus_->is_up(); }
  const std::string& host_id() const override { return bus_->host_id(); }
  Duration running() const override { return bus_->running(); }
  const std::string& trouble() const override { return bus_->trouble(); }

  void Read(const std::string& unit, UnitState& state, OnDone done) override {
    const auto failed = std::make_shared<std::optional<SystemdError>>();
    const auto get_all = [&](const char* interface, HostBus::OnReply on_reply) {
      const BusMessage call = bus_->NewCall(PathOf(unit), kProperties, "GetAll");
      if (call) sd_bus_message_append(call.get(), "s", interface);
      bus_->Send(call, std::move(on_reply));
    };
    get_all(kService, [&state, failed](const BusMessage& reply) {
      *failed = ErrorIn(reply);
      if (*failed) return;
      state = {.active = state.active};
      ReadProperties(reply.get(), state);
    });
    get_all(kUnitInterface, [&state, failed, done = std::move(done)](const BusMessage& reply) {
      if (auto error = ErrorIn(reply)) *failed = std::move(error);
      if (!*failed) ReadProperties(reply.get(), state);
      done(*failed);
    });
  }

  void Start(const UnitStart& start,
             std::function<void(const std::optional<SystemdError>&, const std::string& job)> done)
      override {
    const BusMessage call = bus_->NewCall(kManagerPath, kManager, "StartTransientUnit");
    if (!call) return;
    AppendStart(call.get(), start);
    bus_->Send(call, [done = std::move(done)](const BusMessage& reply) {
      auto error = ErrorIn(reply);
      const char* job = nullptr;
      if (!error && sd_bus_message_read(reply.get(), "o", &job) < 0) {
        error = SystemdError{SystemdError::Kind::kOther, "it names no job"};
      }
      done(error, error ? "" : job);
    });
  }

  void Cancel(const std::string& job) override {
    bus_->Send(bus_->NewCall(job, kJob, "Cancel"), nullptr);
  }

  void Kill(const std::string& invocation, int signal, OnDone done) override {
    const BusMessage call = bus_->NewCall(PathOf(invocation), kUnitInterface, "Kill");
    if (!call) return;
    sd_bus_message_append(call.get(), "si", "all", signal);
    bus_->Send(call, [done = std::move(done)](const BusMessage& reply) { done(ErrorIn(reply)); });
  }

  void Stop(const std::string& invocation) override {
    const BusMessage call = bus_->NewCall(PathOf(invocation), kUnitInterface, "Stop");
    if (!call) return;
    sd_bus_message_append(call.get(), "s", "replace");
    bus_->Send(call, nullptr);
  }

  void Reset(const std::string& unit) override {
    const BusMessage call = bus_->NewCall(kManagerPath, kManager, "ResetFailedUnit");
    if (!call) return;
    sd_bus_message_append(call.get(), "s", unit.c_str());
    bus_->Send(call, nullptr);
  }

  void ReadSystemState(
      std::function<void(const std::optional<SystemdError>&, const std::string& state)> done)
      override {
    const BusMessage call = bus_->NewCall(kManagerPath, kProperties, "Get");
    if (!call) return;
    sd_bus_message_append(call.get(), "ss", kManager, "SystemState");
    bus_->Send(call, [done = std::move(done)](const BusMessage& reply) {
      const auto error = ErrorIn(reply);
      std::string state;
      if (!error) ReadText(reply.get(), state);
      done(error, state);
    });
  }

 private:
  void OnSignal(sd_bus_message* signal) {
    if (sd_bus_message_is_signal(signal, kManager, "JobRemoved") > 0) {
      std::uint32_t id = 0;
      const char* job = nullptr;
      const char* unit = nullptr;
      const char* result = nullptr;
      if (sd_bus_message_read(signal, "uoss", &id, &job, &unit, &result) < 0) return;
      return hooks_.on_job_removed(unit, job, result);
    }
    const char* interface = nullptr;
    if (sd_bus_message_is_signal(signal, kProperties, "PropertiesChanged") <= 0 ||
        sd_bus_message_read(signal, "s", &interface) < 0) {
      return;
    }
    const auto unit = units_.find(sd_bus_message_get_path(signal));
    if (unit == units_.end()) return;
    // systemd sends the properties of the service first, then the properties of the unit.
    hooks_.on_change(
        unit->second, [signal](UnitState& state) { ReadProperties(signal, state); },
        std::string_view(interface) == kUnitInterface);
  }

  const Hooks hooks_;
  std::map<std::string, std::string> units_;  // their names, by path
  std::unique_ptr<HostBus> bus_;              // last: it calls the others
};

}  // namespace

ConnectSystemd BySsh(transport::EventLoop& loop) {
  return [&loop](const HostConfig& host, const std::vector<std::string>& units,
                 Systemd::Hooks hooks) -> std::unique_ptr<Systemd> {
    HostBus::Options options;
    options.ssh = SshArguments(host);
    options.login = host.Login();
    return std::make_unique<BusSystemd>(loop, std::move(options), units, std::move(hooks));
  };
}

ConnectSystemd BySocket(transport::EventLoop& loop, std::string socket) {
  return
      [&loop, socket = std::move(socket)](const HostConfig&, const std::vector<std::string>& units,
                                          Systemd::Hooks hooks) -> std::unique_ptr<Systemd> {
        HostBus::Options options;
        options.socket = socket;
        return std::make_unique<BusSystemd>(loop, std::move(options), units, std::move(hooks));
      };
}

}  // namespace musher
