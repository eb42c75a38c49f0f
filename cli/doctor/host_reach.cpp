#include "musher/cli/doctor/host_reach.hpp"

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <sstream>

#include "musher/base/program.hpp"
#include "musher/base/version.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/config/config_places.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/cli/machine/host_query.hpp"
#include "musher/controller/process/host_processes.hpp"
#include "musher/controller/process/own_systemd.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/transport/ros_environment.hpp"

namespace musher::cli {
namespace {

// Bytes 18 and 19 of a program say for which processor it is: as those of this one, or another.
constexpr const char* kFacts = R"sh(
echo "arch $(uname -m)"
echo "init $(cat /proc/1/comm)"
echo "systemd $(systemctl --version 2>/dev/null | sed -n '1s/^systemd \([0-9]*\).*/\1/p')"
set -- $(df -Pk / | tail -n 1)
echo "free $4"
set -- $(df -Pk /run | tail -n 1)
echo "run $4"
echo "user $(id -u)"
# What a container may forbid. A login that is not root cannot know.
namespaces=mounts
[ "$(id -u)" != 0 ] || unshare -m true 2>/dev/null || namespaces=
cd /sys/fs/cgroup
if [ -e cgroup.controllers ]; then
  keeps=$(cat cgroup.controllers)
  case " $keeps " in *' cpu '*) keeps="$keeps quota";; esac
  # A kernel may have the weight alone; it shows in a group that has the controller.
  for weight in */cpu.weight; do
    [ -e "$weight" ] && ! [ -e "${weight%weight}max" ] && keeps="${keeps%quota}"
  done
  ! [ -r /proc/kallsyms ] || grep -qw __cgroup_bpf_check_dev_permission /proc/kallsyms &&
    keeps="$keeps devices"
  echo "cgroups 2 $keeps $namespaces"
elif [ -d . ]; then
  keeps=
  # In a container they may be there and read-only.
  mounted=$(sed -n 's/^[^ ]* [^ ]* cgroup rw,\([^ ]*\).*/,\1,/p' /proc/mounts)
  case $mounted in *,memory,*) keeps=memory;; esac
  case $mounted in *,devices,*) keeps="$keeps devices";; esac
  case $mounted in *,cpu,*)
    keeps="$keeps cpu"
    [ -e cpu/cpu.cfs_quota_us ] && keeps="$keeps quota";;
  esac
  echo "cgroups 1 $keeps $namespaces"
fi
cd /
echo "autogroups $(cat /proc/sys/kernel/sched_autogroup_enabled 2>/dev/null)"
command -v musher >/dev/null && echo "version $(musher --version)"
kind() { od -An -tx1 -j18 -N2 "$1" 2>/dev/null; }
is_elf() { [ "$(od -An -tx1 -N4 "$1" 2>/dev/null)" = ' 7f 45 4c 46' ]; }
program() {
  path=$(command -v "$2") || { echo "missing $1: program not found there: $2"; return; }
  is_elf "$path" && [ "$(kind "$path")" != "$(kind /proc/self/exe)" ] &&
    echo "missing $1: $path is built for another processor than this host's $(uname -m)"
}
# A login that is not root may see less than the process does.
is_seen() { [ "$(id -u)" != 0 ] || [ "$1" "$2" ]; }
folder() { is_seen -d "$2" || echo "nofolder $1: $2"; }
config() { is_seen -e "$2" || echo "noconfig $1: $2"; }
device() { [ -e "$2" ] || echo "nodevice $1: $2"; }
unit() {
  state=$(systemctl show -p ActiveState --value "$1" 2>/dev/null)
  [ "$state" = inactive ] || echo "unit $1 $(systemctl show -p Environment --value "$1")"
}
)sh";

std::int64_t NumberIn(const std::string& text, std::int64_t otherwise) {
  std::int64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  return read.ec == std::errc() ? number : otherwise;
}

// Of a number of KiB; -1: it is none.
std::int64_t BytesOf(const std::string& text) {
  const std::int64_t kib = NumberIn(text, -1);
  return kib < 0 ? -1 : kib << 10;
}

// Whether the unit has the id of another machine in its environment, or of none.
bool IsForeign(const std::string& environment, const std::string& machine_id) {
  if (machine_id.empty()) return false;
  return environment.find("MUSHER_MACHINE_ID=" + machine_id) == std::string::npos;
}

// As the controller passes it.
std::string ConfigThere(const MachineConfig& config, const ActuatorConfig& actuator) {
  const auto named = actuator.env.find("MUSHER_CONFIG");
  return named != actuator.env.end() ? named->second
                                     : std::filesystem::absolute(config.file).string();
}

}  // namespace

std::string HostFactsScript(const MachineConfig& config, const std::string& host) {
  std::string script = kFacts;
  for (const ActuatorConfig& actuator : config.actuators) {
    if (actuator.host != host || actuator.command.empty()) continue;
    script += "program " + actuator.name + " " + ShellWord(actuator.command.front()) + "\n";
    script += "unit " + UnitNameOf(config.name, actuator.name) + "\n";
    const auto look_for = [&](const char* what, const std::string& path) {
      script += what + (" " + actuator.name) + " " + ShellWord(path) + "\n";
    };
    if (!actuator.cwd.empty()) look_for("folder", actuator.cwd);
    look_for("config", ConfigThere(config, actuator));
    for (const std::string& device : actuator.limits.devices.value_or(std::vector<std::string>())) {
      look_for("device", device);
    }
    const std::string& user = actuator.limits.user;
    if (user.empty()) continue;
    script += "id -u " + ShellWord(user) + " >/dev/null 2>&1 || echo nouser " + user + "\n";
  }
  return script;
}

void TakeHostLines(const std::vector<std::string>& lines, const std::string& machine_id,
                   OtherHostFacts& facts) {
  for (const std::string& line : lines) {
    const std::size_t space = line.find(' ');
    if (space == std::string::npos) continue;
    const std::string key = line.substr(0, space);
    const std::string value = line.substr(space + 1);
    if (key == "arch") facts.architecture = value;
    if (key == "init") facts.init = value;
    if (key == "systemd") facts.systemd = static_cast<int>(NumberIn(value, 0));
    if (key == "free") facts.free_bytes = BytesOf(value);
    if (key == "run") facts.run_bytes = BytesOf(value);
    if (key == "user") facts.root = value == "0";
    if (key == "version") facts.musher = value.substr(value.rfind(' ') + 1);
    if (key == "cgroups") {
      facts.cgroups = static_cast<int>(NumberIn(value, 0));
      std::istringstream words(value);
      std::string word;
      words >> word;
      while (words >> word) facts.keeps.push_back(word);
    }
    if (key == "autogroups") facts.autogroups = value == "1";
    if (key == "missing") facts.missing.push_back(value);
    if (key == "nofolder") facts.no_folders.push_back(value);
    if (key == "noconfig") facts.no_configs.push_back(value);
    if (key == "nodevice") facts.no_devices.push_back(value);
    if (key == "nouser") facts.no_users.push_back(value);
    if (key == "unit" && IsForeign(value, machine_id)) {
      facts.foreign.push_back(value.substr(0, value.find(' ')));
    }
  }
}

std::vector<OtherHostFacts> ReadOtherHosts(const MachineConfig& config) {
  constexpr Duration kWithin = Milliseconds(8000);  // ssh gives up after 5 s
  const auto origin = LoadOrigin(config.state_dir);
  const std::string machine_id = origin && origin->name == config.name ? origin->id : "";
  std::vector<OtherHostFacts> hosts;
  std::vector<HostQuery> queries;
  for (const HostConfig& host : config.hosts) {
    bool runs = false;
    for (const ActuatorConfig& actuator : config.actuators) runs |= actuator.host == host.name;
    if (!runs) continue;
    hosts.push_back({host.name, host.Login()});
    queries.push_back({&host, HostFactsScript(config, host.name)});
  }
  const std::vector<HostAnswer> answers = QueryHosts(queries, kWithin);
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    hosts[i].trouble = answers[i].trouble;
    if (const auto& ahead = answers[i].clock_offset_ns) hosts[i].clock_ahead = Duration(*ahead);
    TakeHostLines(answers[i].lines, machine_id, hosts[i]);
  }
  return hosts;
}

std::vector<OtherHostFacts> ReadOwnHost(const MachineConfig& config) {
  constexpr Duration kScriptWithin = Milliseconds(8000);
  if (!config.own_units) return {};
  OtherHostFacts here;
  const OwnSystemd systemd = FindOwnSystemd(transport::OwnEnvironment(), geteuid());
  here.trouble = systemd.trouble;
  if (!here.trouble.empty()) return {here};
  ProgramSpec script;
  script.argv = {"sh", "-c", HostFactsScript(config, "")};
  const auto end = RunProgram(script, "", kScriptWithin);
  if (!end || end.value().timed_out) {
    here.trouble =
        "this host could not be examined within 8 s; try again when it is less busy, or see "
        "`systemctl status`";
    return {here};
  }
  std::vector<std::string> lines;
  std::istringstream text(end.value().output);
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  const auto origin = LoadOrigin(config.state_dir);
  TakeHostLines(lines, origin && origin->name == config.name ? origin->id : "", here);
  return {here};
}

std::vector<Diagnostic> CheckOtherHosts(const MachineConfig& config,
                                        const std::vector<OtherHostFacts>& hosts) {
  const ConfigPlaces places(config.file);
  DoctorFacts facts;
  facts.config = config;
  facts.hosts = hosts;
  facts.version = Version();
  std::vector<Diagnostic> found;
  for (const DoctorCheck& check : CheckHosts(facts)) {
    if (check.health != CheckStatus::kWarning && check.health != CheckStatus::kError) continue;
    const int line =
        check.name == kOwnUnitsCheck
            ? places.LineOf("controller", "units")
            : places.LineOf("host." + check.name.substr(check.name.find(' ') + 1), "address");
    const bool is_error = check.health == CheckStatus::kError;
    found.push_back({config.file, line, line == 0 ? 0 : 1,
                     is_error ? Severity::kError : Severity::kWarning,
                     check.reason + (check.fix.empty() ? "" : "; " + check.fix)});
  }
  return found;
}

}  // namespace musher::cli
