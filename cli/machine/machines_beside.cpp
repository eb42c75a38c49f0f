#include "musher/cli/machine/machines_beside.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/storage/computer.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/other_starts.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

bool NamesNamespace(const GlobalOptions& global) {
  return global.name_space_given || !global.name_space.empty();
}

// Whether the command may mean a machine there: nothing that it names says otherwise.
bool MayBeMeant(const MachinePlace& place, const GlobalOptions& global) {
  const MachinePlace own = PlaceOf(global);
  if (place == own) return false;
  if (place.name_space != own.name_space && NamesNamespace(global)) return false;
  return place.domain == own.domain || !global.domain;
}

bool IsWord(const MachineIdentity& machine, const std::string& word) {
  return machine.name == word || BeginsIdOf(machine, word);
}

// The folders of machines that were started on this computer by a config that is still there.
std::vector<std::pair<std::string, MachineOrigin>> FoldersHere() {
  std::vector<std::string> folders;
  std::error_code error;
  if (fs::is_regular_file("robot.toml", error)) {
    const auto config = ReadConfigFile("robot.toml").config;
    if (config) folders.push_back(config->state_dir);
  }
  const fs::path by_user = fs::path(config_toml::DefaultStateDir("any", "")).parent_path();
  for (const fs::path& place : std::set<fs::path>{by_user, fs::path(kServicePlace)}) {
    for (const fs::path& folder : EntriesOf(place)) folders.push_back(folder);
  }
  const std::vector<std::string> computer = ComputerParts();
  std::vector<std::pair<std::string, MachineOrigin>> found;
  for (const std::string& folder : folders) {
    auto origin = LoadOrigin(folder);
    if (!origin || !fs::exists(origin->file, error)) continue;
    if (IsOtherComputer(origin->computer, computer)) continue;
    found.emplace_back(folder, std::move(*origin));
  }
  // That of the working directory is the most likely one.
  const fs::path here = fs::absolute("robot.toml", error).lexically_normal();
  std::stable_partition(found.begin(), found.end(),
                        [&](const auto& one) { return one.second.file == here; });
  return found;
}

using Folders = std::vector<std::pair<std::string, MachineOrigin>>;

bool HasFolder(const Folders& folders, const MachinePlace& place) {
  return std::ranges::any_of(folders, [&place](const auto& folder) {
    return MachinePlace{folder.second.domain, folder.second.name_space} == place;
  });
}

}  // namespace

MachinePlace PlaceOf(const GlobalOptions& global) {
  const auto domain = transport::DomainId({});
  return {domain ? domain.value() : 0, global.name_space};
}

std::vector<MachinePlace> PlacesToStop(const GlobalOptions& global) {
  const MachinePlace own = PlaceOf(global);
  std::vector<MachinePlace> places = PlacesHere();
  const bool own_runs = std::ranges::count(places, own) != 0;
  const Folders folders = FoldersHere();
  std::erase_if(places, [&](const MachinePlace& place) {
    const bool of_robot = place.domain == own.domain || HasFolder(folders, place);
    return !of_robot || !MayBeMeant(place, global);
  });
  const bool in_domain =
      own_runs || std::ranges::count(places, own.domain, &MachinePlace::domain) != 0;
  if (in_domain) {
    std::erase_if(places, [&](const MachinePlace& place) { return place.domain != own.domain; });
  }
  return places;
}

std::string MachineBeside::Text(const GlobalOptions& global) const {
  const std::string machine = MachineText(identity);
  return "the machine of this host" + (machine.empty() ? "" : ", " + machine + ",") +
         (runs ? " runs in " : " does not run and belongs to ") +
         place.Text(PlaceOf(global).domain);
}

std::string MachineBeside::InsteadOf(const std::string& others, const GlobalOptions& global) const {
  const MachinePlace own = PlaceOf(global);
  const bool by_domain = place.domain != own.domain;
  std::string variables = place.name_space != own.name_space ? "MUSHER_NAMESPACE" : "";
  if (by_domain) variables += variables.empty() ? "ROS_DOMAIN_ID" : " and ROS_DOMAIN_ID";
  return Text(global) + ", and this command speaks to " + own.Text(place.domain) + "; found " +
         others + ". Nothing was done; " + place.Options(own) + ", or " + variables +
         ", speaks to it, --machine NAME speaks to another machine";
}

std::vector<MachineBeside> MachinesBeside(const GlobalOptions& global) {
  const auto folders = FoldersHere();
  std::vector<MachineBeside> machines;
  const auto is_meant = [&global](const MachineBeside& one) {
    if (global.machine.empty()) return MayBeMeant(one.place, global);
    return one.place != PlaceOf(global) && IsWord(one.identity, global.machine);
  };
  const auto add = [&](MachineBeside machine) {
    const bool known = std::ranges::count(machines, machine.place, &MachineBeside::place) != 0;
    if (!known && is_meant(machine)) machines.push_back(std::move(machine));
  };
  for (const MachinePlace& place : PlacesHere()) {
    const bool in_domain = place.domain == PlaceOf(global).domain;
    if (!in_domain && !HasFolder(folders, place)) continue;
    MachineBeside machine{place, {}, true};
    auto origin = OriginHere(place.domain, place.name_space);
    for (const auto& [folder, one] : folders) {
      if (!origin && MachinePlace{one.domain, one.name_space} == place) origin = one;
    }
    if (origin) machine.identity = {origin->name, origin->id};
    add(std::move(machine));
  }
  for (const auto& [folder, one] : folders) {
    add({{one.domain, one.name_space}, {one.name, one.id}, false});
  }
  return machines;
}

std::vector<MachinePlace> PlacesOfRemoteActuators(const GlobalOptions& global) {
  std::set<MachinePlace> found;
  const MachinePlace own = PlaceOf(global);
  for (const auto& [folder, one] : FoldersHere()) {
    const MachinePlace place{one.domain, one.name_space};
    if (place.domain != own.domain || !MayBeMeant(place, global)) continue;
    if (!global.machine.empty() && !IsWord({one.name, one.id}, global.machine)) continue;
    if (!StateStore::RemoteActuatorsIn(folder, HostId()).empty()) found.insert(place);
  }
  for (const MachinePlace& place : PlacesHere()) found.erase(place);
  return {found.begin(), found.end()};
}

}  // namespace musher::cli
