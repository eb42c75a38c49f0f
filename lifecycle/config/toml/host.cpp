// [host.<name>], and `host` and the limits of one [actuator.<name>].

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/suggest.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/lifecycle/config/toml/draft.hpp"

namespace musher {

bool SupportsHosts() {
  return MUSHER_HOSTS;
}

}  // namespace musher

namespace musher::config_toml {
namespace {

constexpr std::size_t kLongestLogin = 255;
constexpr std::int64_t kMostMemoryMb = 16 << 20;
constexpr double kFewestCpus = 0.01;
constexpr double kMostCpus = 1024;
constexpr int kMostNice = 19;
constexpr int kHighestRealtimePriority = 99;  // of Linux

// What ssh takes for one word that is no option.
bool IsWordForSsh(std::string_view text) {
  return !text.empty() && text.size() <= kLongestLogin && text.front() != '-' &&
         text.find_first_not_of(
             "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
             "._:%-") == std::string_view::npos;
}

HostConfig ReadHost(const Member& member, const Table& table, Draft& draft) {
  TableReader reader(table, member.value.at, "host." + member.key, draft.findings);
  HostConfig host;
  host.name = member.key;
  if (!IsName(member.key)) {
    draft.findings.Error(
        member.at, "host: expected " + std::string(kNameRule) + ", found " + Quote(member.key));
  }
  reader.Require("address", "a string (of ssh: a name, an address or an alias)");
  if (const auto address = reader.String("address")) {
    host.address = address->text;
    if (!IsWordForSsh(address->text)) {
      const bool has_user = address->text.find('@') != std::string::npos;
      reader.Fault(address->at, "address",
                   "expected a name or an address, such as \"192.168.44.2\", found " +
                       Quote(address->text) + (has_user ? "; write the user as `user`" : ""));
    }
  }
  if (const auto user = reader.String("user")) {
    host.user = user->text;
    if (!IsWordForSsh(user->text)) {
      reader.Fault(user->at, "user",
                   "expected the name of a user of the host, found " + Quote(user->text));
    }
  }
  const auto path = [&](std::string_view key) -> std::string {
    const auto word = reader.String(key);
    if (!word) return {};
    if (!word->text.empty()) return Absolute(draft.folder, word->text);
    reader.Fault(word->at, key, "expected a path, found an empty string");
    return {};
  };
  host.key = path("key");
  host.known_hosts = path("known_hosts");
  reader.RefuseOthers();
  return host;
}

// What no process in a strict sandbox sees.
bool IsHidden(std::string_view path) {
  constexpr std::array<std::string_view, 5> kHidden = {"/home/", "/root/", "/run/user/", "/tmp/",
                                                       "/var/tmp/"};
  return std::ranges::any_of(kHidden, [&](std::string_view one) { return path.starts_with(one); });
}

void ReadDevices(TableReader& reader, ProcessLimits& limits) {
  constexpr std::string_view kKey = "devices";
  const auto words = reader.Strings(kKey, {.may_be_empty = true});
  if (!words) return;
  limits.devices.emplace();
  for (const Word& word : *words) {
    const std::string path = std::filesystem::path(word.text).lexically_normal().string();
    if (!path.starts_with("/dev/") || path != word.text) {
      reader.Fault(
          word.at, kKey,
          "expected the path of a device, such as \"/dev/video0\", found " + Quote(word.text));
    }
    limits.devices->push_back(word.text);
  }
}

// What nothing would keep there.
void FaultOnOwnHost(TableReader& reader, std::string_view key, bool has_standby) {
  std::string instead = "has no such limit";
  if (key == "user") instead = "runs as the user of the controller";
  if (key == "sandbox") instead = "has none";
  if (key == "devices") instead = "opens what the controller may";
  reader.Fault(reader.At(key), key,
               "needs systemd, which keeps it: a child of the controller " + instead +
                   "; set units = \"always\" in [controller]" +
                   (has_standby ? ", since with failover_ms each host may be the controller's own"
                                : ", or give the actuator a [host.<name>]"));
}

// What the process needs, and does not see in its sandbox.
void CheckSandbox(TableReader& reader, const ActuatorConfig& config, const Draft& draft) {
  const bool is_unit = !config.host.empty() || draft.config.own_units;
  if (config.limits.sandbox != Sandbox::kStrict || !is_unit) return;
  const auto own = config.env.find("MUSHER_CONFIG");
  const std::filesystem::path name = std::filesystem::path(draft.config.file).filename();
  const std::string file = own != config.env.end() ? own->second : (draft.folder / name).string();
  const std::string program = config.command.empty() ? "" : config.command.front();
  for (const auto& [what, path] :
       {std::pair("its program ", program), std::pair("its working directory ", config.cwd),
        std::pair("its config ", file)}) {
    if (!IsHidden(path + "/")) continue;
    reader.Fault(reader.At("sandbox"), "sandbox",
                 "\"strict\" hides the home folders and /tmp, and " + std::string(what) + path +
                     " is in one; put it elsewhere, such as /opt, or take \"read-only\"");
  }
}

}  // namespace

void ReadHosts(TableReader& root, Draft& draft) {
  const Table* tables = root.SubTable("host");
  if (tables == nullptr) return;
  if (!SupportsHosts()) {
    draft.findings.Error(root.At("host"),
                         "host: not supported by this build, which was made without "
                         "libsystemd-dev: no process can be started on another host");
  }
  TableReader all(*tables, root.At("host"), "host", draft.findings);
  for (const Member& member : *tables) {
    draft.known_hosts.insert(member.key);
    if (const auto* table = member.value.As<Table>()) {
      draft.config.hosts.push_back(ReadHost(member, *table, draft));
    } else {
      all.Fault(member.value.at, member.key,
                "expected a table, found " + std::string(TypeName(member.value)));
    }
  }
}

void WarnOfUnusedHosts(TableReader& root, Draft& draft) {
  const Table* tables = root.SubTable("host");
  if (tables == nullptr || draft.findings.HasErrors()) return;
  for (const Member& member : *tables) {
    if (draft.used_hosts.contains(member.key)) continue;
    draft.findings.Warning(member.value.at, "host." + member.key + ": no actuator runs on it");
  }
}

void ReadHostOf(TableReader& reader, ActuatorConfig& config, Draft& draft) {
  constexpr std::string_view kKey = "host";
  const auto host = reader.String(kKey);
  if (!host) {
    if (draft.config.failover && reader.Has("command")) {
      reader.Warn(reader.At("command"), "command",
                  "without a host the standby starts it on its own one, also beside a process that "
                  "runs on beyond a cut link");
    }
    return;
  }
  if (!draft.known_hosts.contains(host->text)) {
    const std::vector<std::string_view> known(draft.known_hosts.begin(), draft.known_hosts.end());
    std::string guess = draft.findings.Guess(host->text, known);
    if (guess.empty()) guess = "; expected a host with a table [host.<name>]";
    reader.Fault(host->at, kKey, "unknown host " + Quote(host->text) + guess);
    return;
  }
  config.host = host->text;
  draft.used_hosts.insert(host->text);
  if (!reader.Has("command")) {
    reader.Fault(host->at, kKey, "needs a command, which is started there");
  }
  if (config.protocol != Protocol::kMusher) {
    reader.Fault(host->at, kKey,
                 "needs protocol = \"musher\": a process of another protocol is started on the "
                 "controller's host only");
  }
  if (draft.config.transport == TransportProfile::kLocal) {
    reader.Fault(host->at, kKey,
                 "needs profile = \"lan\" in [transport]: with \"local\" no other host is reached");
  }
}

void ReadLimits(TableReader& reader, ActuatorConfig& config, const Draft& draft) {
  ProcessLimits& limits = config.limits;
  if (const auto mb = reader.Integer("memory_max_mb", 1, kMostMemoryMb)) {
    limits.memory_max_bytes = *mb << 20;
  }
  limits.cpus = reader.Number("cpus", kFewestCpus, kMostCpus);
  const auto number = [&](std::string_view key, int least, int most) -> std::optional<int> {
    const auto value = reader.Integer(key, least, most);
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
  };
  limits.nice = number("nice", -kMostNice - 1, kMostNice);
  limits.realtime_priority = number("realtime_priority", 1, kHighestRealtimePriority);
  if (const auto user = reader.String("user")) {
    limits.user = user->text;
    if (!IsWordForSsh(user->text)) {
      reader.Fault(user->at, "user",
                   "expected the name of a user of the host, found " + Quote(user->text));
    }
  }
  limits.sandbox =
      reader.Choice<Sandbox>("sandbox", {std::begin(kSandboxNames), std::end(kSandboxNames)})
          .value_or(Sandbox::kNone);
  ReadDevices(reader, limits);
  CheckSandbox(reader, config, draft);
  if (limits.cpus && limits.realtime_priority) {
    reader.Fault(reader.At("cpus"), "cpus",
                 "does not limit a process with realtime_priority: leave one of them out");
  }
  if (limits.nice && limits.realtime_priority) {
    reader.Warn(reader.At("nice"), "nice", "has no effect with realtime_priority");
  }
  for (const std::string_view key :
       {"memory_max_mb", "cpus", "nice", "realtime_priority", "user", "sandbox", "devices"}) {
    if (!reader.Has(key)) continue;
    if (!reader.Has("command")) {
      reader.Warn(reader.At(key), key, "has no effect without a command");
    } else if ((!reader.Has("host") || draft.config.failover) && !draft.config.own_units &&
               key != "nice" && key != "realtime_priority") {
      FaultOnOwnHost(reader, key, draft.config.failover.has_value());
    }
  }
}

}  // namespace musher::config_toml
