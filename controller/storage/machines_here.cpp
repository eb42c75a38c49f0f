#include "musher/controller/storage/machines_here.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/joined.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/other_starts.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The words of a file of /proc that end with zeros.
std::vector<std::string> WordsOf(const fs::path& file) {
  std::istringstream text(ReadFile(file));
  std::vector<std::string> words;
  for (std::string word; std::getline(text, word, '\0');) words.push_back(word);
  return words;
}

// The rest of the first word that begins so.
std::string After(const std::vector<std::string>& words, std::string_view begin) {
  const auto found =
      std::ranges::find_if(words, [begin](const auto& word) { return word.starts_with(begin); });
  return found == words.end() ? "" : found->substr(begin.size());
}

// The config that a process was started with; empty: none, or the process is hidden from this user.
std::string ConfigOf(const fs::path& process, const std::vector<std::string>& environment) {
  const std::vector<std::string> argv = WordsOf(process / "cmdline");
  std::string config = After(argv, "--config=");
  const auto option = std::ranges::find(argv, "--config");
  if (config.empty() && option != argv.end() && option + 1 != argv.end()) config = *(option + 1);
  if (config.empty()) config = After(environment, "MUSHER_CONFIG=");
  if (config.empty()) return "";
  std::error_code hidden;
  const fs::path folder = fs::read_symlink(process / "cwd", hidden);
  return (folder / config).string();  // an absolute path stays as it is
}

// Where a user may not look.
bool IsClosed(const fs::path& folder) {
  return access(folder.c_str(), R_OK | X_OK) != 0 && errno == EACCES;
}

// Whether this user may not read the folder, or its machine is not known: the file of the machine
// has another owner, or the disk fails.
bool IsUnread(const fs::path& folder) {
  if (IsClosed(folder)) return true;
  return !OpenRegular(OriginFile(folder)).valid() && errno != ENOENT;
}

class Search {
 public:
  Search(int domain_id, const std::string& name_space)
      : domain_id_(domain_id),
        name_space_(name_space),
        lock_(NameLock::NameOf(domain_id, name_space, "")) {}

  // The machine that is led here.
  void Led() {
    const std::string controller = lock_ + "musher/controller";
    if (!NameLock::IsHeld(controller)) return;
    const pid_t leader = NameLock::HolderOf(controller).pid;
    const std::string folder = StateDirOfProcess(leader);
    if (!folder.empty()) InFolder(folder);
    if (leader == 0) {
      AddUnread(NameLock::HeldBelow(lock_), "its controller is a process of another user");
    }
  }
  void InFolder(const fs::path& folder) {
    const auto origin = LoadOrigin(folder);
    if (!origin || origin->name_space != name_space_ || origin->domain != domain_id_) return;
    MachineHere machine{{origin->name, origin->id}};
    machine.elsewhere = ElsewhereBy(folder);
    machine.lost = LostBy(folder);
    const auto config = Read(origin->file);  // none of a root of upgrades, which is a folder
    if (config && IsHere(*config) && config->name == origin->name) Take(machine, *config);
    found_.push_back(std::move(machine));
  }
  // Returns whether the config can be read. `transport`: the profile that the environment names
  // instead of it; may be empty.
  bool InConfig(const std::string& file, const std::string& transport = "") {
    const auto config = Read(file);
    if (!config || !IsHere(*config)) return config.has_value();
    MachineHere machine{{config->name, ""}};
    Take(machine, *config);
    if (transport == "lan") machine.lan = true;
    const std::string absolute = fs::absolute(file).lexically_normal().string();
    std::vector<std::string> folders =
        DefaultStateDirs({config->name, name_space_, domain_id_, absolute});
    folders.push_back(config->state_dir);
    for (const std::string& folder : folders) {
      const auto origin = LoadOrigin(folder);
      if (!origin || origin->name != config->name || origin->domain != domain_id_) continue;
      for (std::string& name : ElsewhereBy(folder)) machine.elsewhere.push_back(std::move(name));
      for (StoredActuator& lost : LostBy(folder)) machine.lost.push_back(std::move(lost));
    }
    found_.push_back(std::move(machine));
    return true;
  }
  // Adds the machines of the actuators that run here. Reads each config once, however many of its
  // actuators run.
  void InProcesses() {
    std::map<std::pair<std::string, std::string>, bool> read;
    std::vector<std::string> hidden;  // of a user whose processes this one may not read
    for (const auto& [name, holder] : NameLock::HoldersBelow(lock_)) {
      if (holder.pid == 0) {
        hidden.push_back(name);
        continue;
      }
      const fs::path process = fs::path("/proc") / std::to_string(holder.pid);
      const std::vector<std::string> environment = WordsOf(process / "environ");
      const std::string config = ConfigOf(process, environment);
      if (config.empty() || std::atoi(After(environment, "ROS_DOMAIN_ID=").c_str()) != domain_id_) {
        of_no_config_.push_back(name);
        continue;
      }
      const std::string transport = After(environment, "MUSHER_TRANSPORT=");
      const auto [known, is_new] = read.try_emplace({config, transport}, false);
      if (is_new) known->second = InConfig(config, transport);
      if (!known->second) AddUnread({name}, config + ", the config of " + name + ", is not read");
    }
    if (hidden.empty()) return;
    AddUnread(hidden, Joined(hidden) + (hidden.size() == 1 ? " runs" : " run") +
                          " as processes of another user, whose config is not read");
  }
  // Adds the machines of the state folders in a default place. A closed folder may belong to the
  // machine of an actuator whose process names no config.
  void InPlace(const fs::path& place) {
    if (IsClosed(place)) AddUnread(of_no_config_, place.string() + " is not read");
    for (const fs::path& folder : EntriesOf(place)) {
      std::error_code hidden;
      if (!fs::is_directory(folder, hidden)) continue;
      if (!IsUnread(folder)) {
        InFolder(folder);
        continue;
      }
      const std::string name = folder.filename().string();
      const std::string machine = name.substr(0, std::min(name.find('@'), name.find(".domain")));
      const fs::path own = config_toml::DefaultStateDir(machine, name_space_);
      if (own.filename() != name) continue;  // of another namespace or domain
      AddUnread(of_no_config_, folder.string() + " is not read", machine);
    }
  }
  std::vector<MachineHere> Take() { return std::move(found_); }

 private:
  // A process may name anything, as a pipe without a writer: a stop waits for no such thing.
  static std::optional<MachineConfig> Read(const std::string& file) {
    std::error_code error;
    if (!fs::is_regular_file(file, error)) return std::nullopt;
    return ReadConfigFile(file).config;
  }
  bool IsHere(const MachineConfig& config) const { return config.name_space == name_space_; }
  static void Take(MachineHere& machine, const MachineConfig& config) {
    machine.lan = config.transport == TransportProfile::kLan;
    machine.interfaces = config.interfaces;
    for (const ActuatorConfig& actuator : config.actuators) {
      machine.actuators.push_back(actuator.name);
    }
  }
  void AddUnread(std::vector<std::string> actuators, std::string what, std::string name = "") {
    MachineHere machine{{std::move(name), ""}, /*lan=*/true};
    machine.actuators = std::move(actuators);
    machine.unread = std::move(what);
    found_.push_back(std::move(machine));
  }
  static std::vector<std::string> ElsewhereBy(const fs::path& folder) {
    std::vector<std::string> names;
    for (RemoteActuator& actuator : StateStore::RemoteActuatorsIn(folder, HostId())) {
      names.push_back(std::move(actuator.name));
    }
    return names;
  }

  // Also a child of the last controller that has exited after it.
  std::vector<StoredActuator> LostBy(const fs::path& folder) const {
    std::vector<StoredActuator> lost = StateStore::ActuatorsIn(folder, HostId());
    std::erase_if(lost, [](const StoredActuator& one) { return one.lost_in.empty(); });
    for (const ChildProcess& child : StateStore::LoadChildren(folder, HostId())) {
      const bool runs = IsRunning(child) || NameLock::IsHeld(lock_ + child.actuator);
      const bool listed = std::ranges::count(lost, child.actuator, &StoredActuator::name) != 0;
      if (!runs && !listed) lost.push_back({child.actuator});
    }
    return lost;
  }

  const int domain_id_;
  const std::string name_space_;
  const std::string lock_;                 // the beginning of the names that are held here
  std::vector<std::string> of_no_config_;  // actuators that run here
  std::vector<MachineHere> found_;
};

}  // namespace

std::vector<MachineHere> MachinesHere(int domain_id, const std::string& name_space,
                                      const std::vector<std::string>& configs) {
  Search search(domain_id, name_space);
  search.Led();
  search.InProcesses();
  for (const std::string& config : configs) search.InConfig(config);
  std::error_code error;
  if (fs::exists("robot.toml", error)) search.InConfig("robot.toml");
  const fs::path by_user = fs::path(config_toml::DefaultStateDir("any", "")).parent_path();
  for (const fs::path& place : std::set<fs::path>{by_user, fs::path(kServicePlace)}) {
    search.InPlace(place);
  }
  return search.Take();
}

}  // namespace musher
