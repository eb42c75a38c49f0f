#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "musher/base/joined.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/cli/machine/host_clocks.hpp"

namespace musher::cli {
namespace {

constexpr int kOldestSystemd = 248;
constexpr std::int64_t kLittle = 100 << 20;        // bytes
constexpr std::int64_t kLittleForUnits = 1 << 20;  // bytes
constexpr Duration kAhead = Milliseconds(1000);

// Before a command that is to run there.
std::string OnIt(const OtherHostFacts& host) {
  return host.name.empty() ? "" : "ssh " + host.login + " ";
}

// The actuators of the host with such a limit.
template <typename Has>
std::vector<std::string> Limited(const DoctorFacts& facts, const OtherHostFacts& host, Has has) {
  std::vector<std::string> names;
  if (!facts.config) return names;
  for (const ActuatorConfig& actuator : facts.config->actuators) {
    if (actuator.host == host.name && has(actuator.limits)) names.push_back(actuator.name);
  }
  return names;
}

// What the config needs of the host, and it does not have.
struct Unkept {
  CheckStatus health = CheckStatus::kOk;
  std::string reason;
  std::string fix;
};

// A limit of the config that the kernel of the host does not keep.
std::optional<Unkept> UnkeptLimit(const DoctorFacts& facts, const OtherHostFacts& host) {
  if (host.cgroups == 0) return std::nullopt;
  const auto keeps = [&](std::string_view what) {
    return std::find(host.keeps.begin(), host.keeps.end(), what) != host.keeps.end();
  };
  const auto of = [](const char* key, const std::vector<std::string>& names) {
    return fmt::format("its kernel does not keep `{}` of {}: ", key, Joined(names));
  };
  const auto memory =
      Limited(facts, host, [](const ProcessLimits& limits) { return limits.memory_max_bytes; });
  if (!memory.empty() && !keeps("memory")) {
    return Unkept{CheckStatus::kError,
                  of("memory_max_mb", memory) + "its cgroups have no memory controller",
                  "boot it with cgroup_enable=memory, or remove the key"};
  }
  const auto cpus = Limited(facts, host, [](const ProcessLimits& limits) { return limits.cpus; });
  if (!cpus.empty() && !keeps("quota")) {
    return Unkept{CheckStatus::kError,
                  of("cpus", cpus) + (keeps("cpu") ? "it was built without CONFIG_CFS_BANDWIDTH"
                                                   : "its cgroups have no cpu controller"),
                  "boot a kernel that has it, or remove the key"};
  }
  const auto sandboxed = Limited(
      facts, host, [](const ProcessLimits& limits) { return limits.sandbox != Sandbox::kNone; });
  if (!sandboxed.empty() && !keeps("mounts")) {
    return Unkept{CheckStatus::kError, of("sandbox", sandboxed) + "it permits no mount namespaces",
                  "permit them, as where it is a container, or remove the key"};
  }
  const auto closed =
      Limited(facts, host, [](const ProcessLimits& limits) { return limits.LimitsDevices(); });
  if (!closed.empty() && !keeps("devices")) {
    return Unkept{CheckStatus::kError,
                  fmt::format("its kernel does not keep the devices from {}: its cgroups have no "
                              "devices controller",
                              Joined(closed)),
                  "boot a kernel with CONFIG_CGROUP_BPF, or take away `devices` and "
                  "`sandbox = \"strict\"`"};
  }
  if (!memory.empty() && host.cgroups == 1) {
    return Unkept{CheckStatus::kWarning,
                  "it has cgroups of version 1: " + Joined(memory) +
                      " is ended above its `memory_max_mb`, but the fault is shown as a kill",
                  "boot it with systemd.unified_cgroup_hierarchy=1"};
  }
  const auto nice = Limited(facts, host, [](const ProcessLimits& limits) { return limits.nice; });
  if (!nice.empty() && !keeps("cpu") && host.autogroups) {
    return Unkept{CheckStatus::kWarning,
                  of("nice", nice) + "it has autogroups, and its cgroups have no cpu controller",
                  OnIt(host) + "sysctl kernel.sched_autogroup_enabled=0"};
  }
  return std::nullopt;
}

std::optional<Unkept> NoUser(const OtherHostFacts& host) {
  if (host.no_users.empty()) return std::nullopt;
  return Unkept{CheckStatus::kError, fmt::format("it has no user {}", Joined(host.no_users)),
                OnIt(host) + "useradd --system " + host.no_users.front()};
}

// What no actuator is started without.
std::optional<Unkept> MissingThere(const OtherHostFacts& host) {
  if (!host.missing.empty()) {
    return Unkept{CheckStatus::kError, Joined(host.missing),
                  "copy the programs for its processor to the same path there"};
  }
  if (!host.no_folders.empty()) {
    return Unkept{CheckStatus::kError,
                  "the working directory is not there for " + Joined(host.no_folders),
                  "make it there, correct `cwd`, or let `musher deploy` copy the files"};
  }
  return NoUser(host);
}

// A file that an actuator may do without.
std::optional<Unkept> MissingFile(const OtherHostFacts& host) {
  if (!host.no_configs.empty()) {
    return Unkept{CheckStatus::kWarning, "the config is not there for " + Joined(host.no_configs),
                  "copy it to the same path there, name another one by env.MUSHER_CONFIG, or let "
                  "`musher deploy` copy it"};
  }
  if (!host.no_devices.empty()) {
    return Unkept{CheckStatus::kWarning,
                  "it has no such device for " + Joined(host.no_devices) +
                      ", which stays closed to a process that is started before",
                  "correct `devices`, or plug it in before the start"};
  }
  return std::nullopt;
}

// What the systemd of a user keeps for no process.
std::optional<Unkept> OfRootOnly(const DoctorFacts& facts, const OtherHostFacts& host) {
  const auto fault = [&](const char* key, auto has) -> std::optional<Unkept> {
    const auto names = Limited(facts, host, has);
    if (names.empty()) return std::nullopt;
    return Unkept{CheckStatus::kError,
                  fmt::format("the systemd of a user does not keep `{}` of {}", key, Joined(names)),
                  "start the machine as root, or remove the key"};
  };
  if (auto found = fault("user", [](const ProcessLimits& one) { return !one.user.empty(); })) {
    return found;
  }
  if (auto found = fault("sandbox",
                         [](const ProcessLimits& one) { return one.sandbox != Sandbox::kNone; })) {
    return found;
  }
  return fault("devices", [](const ProcessLimits& one) { return one.devices.has_value(); });
}

// Of this host, whose programs and folders other checks look at.
DoctorCheck CheckOwn(const DoctorFacts& facts, const OtherHostFacts& host) {
  DoctorCheck check{kOwnUnitsCheck};
  const auto fault = [&](CheckStatus health, std::string reason, std::string fix) {
    check.health = health;
    check.reason = "controller.units: " + std::move(reason);
    check.fix = std::move(fix);
    return check;
  };
  if (!host.trouble.empty()) return fault(CheckStatus::kError, host.trouble, "");
  if (host.systemd < kOldestSystemd) {
    return fault(
        CheckStatus::kError,
        fmt::format("systemd {} is too old: actuators need {}", host.systemd, kOldestSystemd),
        "upgrade this system, or remove `units`");
  }
  const auto root_only = host.root ? std::nullopt : OfRootOnly(facts, host);
  for (const auto& found : {root_only, NoUser(host), UnkeptLimit(facts, host)}) {
    if (found) return fault(found->health, "this host: " + found->reason, found->fix);
  }
  if (host.root && !host.foreign.empty()) {
    return fault(CheckStatus::kError,
                 fmt::format("this host runs {} already, for another machine of this name",
                             Joined(host.foreign)),
                 "give one of the machines another name, or run `systemctl stop " +
                     host.foreign.front() + "`");
  }
  check.reason = fmt::format("processes of this host are units of systemd {}{}", host.systemd,
                             host.root ? "" : ", that of this user");
  return check;
}

std::optional<Unkept> LittleSpace(const OtherHostFacts& host) {
  if (host.free_bytes >= 0 && host.free_bytes < kLittle) {
    return Unkept{CheckStatus::kError,
                  fmt::format("its disk has {} MiB left", host.free_bytes >> 20),
                  fmt::format("ssh {} journalctl --vacuum-size=100M", host.login)};
  }
  if (host.run_bytes >= 0 && host.run_bytes < kLittleForUnits) {
    return Unkept{
        CheckStatus::kError,
        fmt::format("its /run, where systemd keeps units, has {} KiB left", host.run_bytes >> 10),
        fmt::format("ssh {} 'du -xak /run | sort -n | tail' shows what fills it", host.login)};
  }
  return std::nullopt;
}

DoctorCheck CheckOne(const DoctorFacts& facts, const OtherHostFacts& host) {
  if (host.name.empty()) return CheckOwn(facts, host);
  DoctorCheck check{"host " + host.name};
  const auto fault = [&](CheckStatus health, std::string reason, std::string fix) {
    check.health = health;
    check.reason = std::move(reason);
    check.fix = std::move(fix);
    return check;
  };
  const std::string ssh = "ssh " + host.login;
  const std::string on = fmt::format("host {} ({}): ", host.name, host.login);
  if (!host.trouble.empty()) return fault(CheckStatus::kError, host.trouble, "");
  if (host.init != "systemd" || host.systemd == 0) {
    return fault(CheckStatus::kError,
                 on + fmt::format("its first process is {}: without systemd it runs no actuator",
                                  host.init.empty() ? "not known" : host.init),
                 "boot it with systemd, as Debian and Ubuntu do");
  }
  if (host.systemd < kOldestSystemd) {
    return fault(
        CheckStatus::kError,
        on + fmt::format("systemd {} is too old: actuators need {}", host.systemd, kOldestSystemd),
        "upgrade its system");
  }
  if (const auto missing = MissingThere(host)) {
    return fault(missing->health, on + missing->reason, missing->fix);
  }
  const auto unkept = UnkeptLimit(facts, host);
  if (unkept && unkept->health == CheckStatus::kError) {
    return fault(unkept->health, on + unkept->reason, unkept->fix);
  }
  if (!host.foreign.empty()) {
    return fault(CheckStatus::kError,
                 on + fmt::format("it runs {} already, for another machine of this name",
                                  Joined(host.foreign)),
                 fmt::format("give one of the machines another name, or run `{} systemctl stop "
                             "{}`",
                             ssh, host.foreign.front()));
  }
  if (const auto full = LittleSpace(host)) {
    return fault(full->health, on + full->reason, full->fix);
  }
  if (const auto found = unkept ? unkept : MissingFile(host)) {
    return fault(found->health, on + found->reason, found->fix);
  }
  if (!host.musher.empty() && !facts.version.empty() && host.musher != facts.version) {
    return fault(
        CheckStatus::kWarning,
        on + fmt::format("it has musher {}, this program is {}", host.musher, facts.version),
        "install the same version on all hosts");
  }
  if (host.clock_ahead && (*host.clock_ahead > kAhead || *host.clock_ahead < -kAhead)) {
    return fault(CheckStatus::kWarning,
                 on + "its clock is " + ClockText(*host.clock_ahead) +
                     ": Musher depends on no clock, but the stamps of topics such as /tf differ",
                 fmt::format("{} timedatectl set-ntp true", ssh));
  }
  check.reason =
      fmt::format("{}, {}, systemd {}{}{}", host.login, host.architecture, host.systemd,
                  host.clock_ahead ? ", its clock is " + ClockText(*host.clock_ahead) : "",
                  host.root ? "" : "; not root: polkit must permit it to start units");
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckHosts(const DoctorFacts& facts) {
  std::vector<DoctorCheck> checks;
  for (const OtherHostFacts& host : facts.hosts) checks.push_back(CheckOne(facts, host));
  return checks;
}

}  // namespace musher::cli
