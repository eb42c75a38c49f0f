#include "musher/cli/machine/machine_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/process/network_namespace.hpp"
#include "musher/controller/storage/other_starts.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHowToRead =
    "run it with sudo, or let a group read them: log_group in [controller]";

fs::path UserPlace() {
  return fs::path(config_toml::DefaultStateDir("any", "")).parent_path();
}

// When a controller wrote there last.
fs::file_time_type LastUse(const fs::path& state_dir) {
  std::error_code error;
  const auto time = fs::last_write_time(state_dir / "journal.sqlite", error);
  return error ? fs::file_time_type::min() : time;
}

std::variant<MachineFiles, Failure> FromConfig(const std::string& file, int domain) {
  ConfigReading reading = ReadConfigFile(file);
  if (!reading.config) {
    const auto first = std::find_if(reading.diagnostics.begin(), reading.diagnostics.end(),
                                    [](const auto& d) { return d.severity == Severity::kError; });
    return Failure{
        ExitCode::kUsage,
        {kCodeParametersInvalid,
         first == reading.diagnostics.end() ? "can't read " + file : FormatDiagnostic(*first)}};
  }
  TakeStateDir(*reading.config, domain);
  const std::string name = reading.config->name;
  const std::string state_dir = reading.config->state_dir;
  return MachineFiles{name, state_dir, fs::absolute(file), std::move(reading.config), false};
}

// False also where this user may not look.
bool IsFolder(const std::string& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

MachineFiles FromFolder(const std::string& state_dir, const MachineOrigin& origin) {
  MachineFiles files{origin.name, state_dir, origin.file, std::nullopt, false};
  if (IsFolder(origin.file)) return files;  // an upgrade root
  files.config = ReadConfigFile(origin.file).config;
  if (files.config) TakeStateDir(*files.config, origin.domain);
  if (files.config && files.config->state_dir != state_dir) files.config.reset();
  return files;
}

// The machine of a project, as `musher new` makes them: its state folder is inside.
std::optional<MachineFiles> InWorkingDirectory(const std::string& name_space, int domain) {
  std::error_code error;
  if (!fs::exists("robot.toml", error)) return std::nullopt;
  auto files = FromConfig("robot.toml", domain);
  auto* found = std::get_if<MachineFiles>(&files);
  if (found == nullptr || found->config->name_space != name_space) return std::nullopt;
  const auto origin = LoadOrigin(found->state_dir);
  if (!origin || origin->name != found->name || origin->domain != domain) return std::nullopt;
  return std::move(*found);
}

// The folders below the default places of a machine of that namespace and domain; newest first.
std::vector<MachineFiles> Stopped(const std::string& name_space, int domain) {
  std::vector<fs::path> folders = EntriesOf(UserPlace());
  if (UserPlace() != kServicePlace) {
    const std::vector<fs::path> more = EntriesOf(fs::path(kServicePlace));
    folders.insert(folders.end(), more.begin(), more.end());
  }
  std::vector<std::pair<fs::file_time_type, MachineFiles>> found;
  for (const fs::path& folder : folders) {
    const auto origin = LoadOrigin(folder);
    if (!origin || origin->name_space != name_space || origin->domain != domain) continue;
    found.emplace_back(LastUse(folder), FromFolder(folder, *origin));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<MachineFiles> files;
  files.reserve(found.size());
  for (auto& [used, one] : found) files.push_back(std::move(one));
  return files;
}

// Those of the namespace and domain that this user can read, the most likely first.
std::vector<MachineFiles> Unled(const std::string& name_space, int domain) {
  std::vector<MachineFiles> files = Stopped(name_space, domain);
  if (auto here = InWorkingDirectory(name_space, domain)) {
    files.insert(files.begin(), std::move(*here));
  }
  return files;
}

bool IsOfAnother(const std::string& folder) {
  struct stat info {};
  return stat(folder.c_str(), &info) == 0 && info.st_uid != geteuid();
}

}  // namespace

std::variant<MachineFiles, Failure> FindMachineFiles(const std::string& config,
                                                     const GlobalOptions& global) {
  const auto domain = transport::DomainId({});
  if (!domain) return Failure{ExitCode::kUsage, domain.error()};
  const auto lock_of = [&domain](const std::string& name_space) {
    return NameLock::NameOf(domain.value(), name_space, "musher/controller");
  };
  const auto led_in = [&lock_of](const std::string& name_space) {
    const pid_t leader = NameLock::HolderOf(lock_of(name_space)).pid;
    return leader == 0 ? "" : StateDirOfProcess(leader);
  };
  // A controller of another user has open files that only root sees.
  const auto led_by_another = [&](const std::string& name_space) {
    return led_in(name_space).empty() && NameLock::IsHeld(lock_of(name_space));
  };
  if (!config.empty()) {
    auto files = FromConfig(config, domain.value());
    if (auto* found = std::get_if<MachineFiles>(&files)) {
      const std::string& name_space = found->config->name_space;
      const bool by_another = IsOfAnother(found->state_dir) && led_by_another(name_space);
      found->led = by_another || found->state_dir == led_in(name_space);
    }
    return files;
  }
  const std::string led_dir = led_in(global.name_space);
  if (!led_dir.empty()) {
    if (const auto origin = LoadOrigin(led_dir)) {
      MachineFiles files = FromFolder(led_dir, *origin);
      files.led = true;
      return files;
    }
  }
  const bool by_another = led_dir.empty() && led_by_another(global.name_space);
  for (MachineFiles& files : Unled(global.name_space, domain.value())) {
    if (by_another && !IsOfAnother(files.state_dir)) continue;  // an earlier one of this user
    files.led = by_another;
    return std::move(files);
  }
  if (by_another) return Failure{ExitCode::kNotDone, {kCodeFailed, FilesOfAnotherUser()}};
  return Failure{
      ExitCode::kNoController,
      {kCodeNetError,
       fmt::format("no machine in {} of DDS domain {} has files on this host: no "
                   "controller leads here, and none has its state folder below {}{}; --config FILE "
                   "names the config of a machine, --namespace and --domain another one",
                   NamespaceText(global.name_space), domain.value(), UserPlace().string(),
                   HiddenFilesNote())}};
}

std::optional<MachineIdentity> MachineOfFilesHere(const GlobalOptions& global) {
  const auto found = FindMachineFiles("", global);
  const auto* files = std::get_if<MachineFiles>(&found);
  if (files == nullptr) return std::nullopt;
  const auto origin = LoadOrigin(files->state_dir);
  return origin ? MachineIdentity{origin->name, origin->id} : MachineIdentity{files->name, ""};
}

std::string MachineInOtherNetwork::Text() const {
  const bool several = actuators.find(", ") != std::string::npos;
  const std::string runs = actuators.empty() ? fmt::format("process {} leads {}", pid, name)
                                             : fmt::format("{} of {} run{} without a controller",
                                                           actuators, name, several ? "" : "s");
  return runs + " in another network namespace of this host; as root, " +
         InNetworkOf(pid, "musher COMMAND") + (several ? " reaches them" : " reaches it");
}

std::optional<MachineInOtherNetwork> InOtherNetwork(const MachineFiles& files) {
  const pid_t owner = StateStore::OwnerOf(files.state_dir);
  const bool led = StateStore::IsOwner(files.state_dir, owner);
  if (led && IsInOtherNetwork(owner)) return MachineInOtherNetwork{files.name, owner};
  if (led) return std::nullopt;
  const auto children = StateStore::ChildrenInOtherNetworkIn(files.state_dir, HostId());
  if (children.empty()) return std::nullopt;
  return MachineInOtherNetwork{files.name, children.front().pid, NamesOf(children)};
}

std::optional<MachineInOtherNetwork> FindInOtherNetwork(const GlobalOptions& global) {
  const auto domain = transport::DomainId({});
  if (!domain) return std::nullopt;
  for (const MachineFiles& files : Unled(global.name_space, domain.value())) {
    auto beyond = InOtherNetwork(files);
    if (!beyond) continue;
    const auto origin = LoadOrigin(files.state_dir);
    const MachineIdentity machine{files.name, origin ? origin->id : ""};
    const std::string& meant = global.machine;
    if (meant.empty() || meant == machine.name || BeginsIdOf(machine, meant)) return beyond;
  }
  return std::nullopt;
}

std::string StateDirOf(const MachineOrigin& machine, const std::string& by_user,
                       const std::string& service_place) {
  const fs::path by_service = fs::path(service_place) / fs::path(by_user).filename();
  const auto origin = LoadOrigin(by_service);
  if (!origin) return by_user;
  MachineOrigin own = machine;
  if (IsFolder(origin->file)) own.file = origin->file;  // an upgrade root
  const bool newer = !LoadOrigin(by_user) || LastUse(by_service) > LastUse(by_user);
  return newer && origin->IsOf(own, false) ? by_service.string() : by_user;
}

void TakeStateDir(MachineConfig& config, int domain) {
  if (config.state_dir != config_toml::DefaultStateDir(config.name, config.name_space)) return;
  config.state_dir = StateDirOf({config.name, config.name_space, domain, fs::absolute(config.file)},
                                config.state_dir, kServicePlace);
}

std::string HiddenFilesNote() {
  std::string hidden = kServicePlace;
  if (access(kServicePlace, F_OK) != 0) return "";
  if (access(kServicePlace, R_OK | X_OK) == 0) {
    const auto folders = EntriesOf(fs::path(kServicePlace));
    const auto closed = std::find_if(folders.begin(), folders.end(), [](const fs::path& folder) {
      return access(folder.c_str(), R_OK | X_OK) != 0;
    });
    if (closed == folders.end()) return "";
    hidden = *closed;
  }
  return fmt::format(
      "; {}, with the files of robots that systemd starts, cannot be read by this user: {}", hidden,
      kHowToRead);
}

std::string FilesOfAnotherUser() {
  return fmt::format(
      "a controller of another user leads the machine on this host, and this user may not read its "
      "files: {}",
      kHowToRead);
}

std::string WhyUnreadable(const MachineFiles& files) {
  const std::string folder = files.state_dir + "/logs";
  if (access(folder.c_str(), R_OK | X_OK) == 0 || errno != EACCES) return "";
  return fmt::format("this user may not read {}: {}", folder, kHowToRead);
}

std::string LogPathOf(const MachineFiles& files, const std::string& actuator) {
  const bool is_actuator = files.config && files.config->IndexOf(actuator).has_value();
  if (actuator != kControllerWord || is_actuator) {
    return files.state_dir + "/logs/" + actuator + ".log";
  }
  return files.config ? ControllerLogFile(*files.config) : files.state_dir + "/controller.log";
}

}  // namespace musher::cli
