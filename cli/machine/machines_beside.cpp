#include "musher/cli/machine/machines_beside.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "musher/base/host.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

MeantPlace MeantBy(const GlobalOptions& global) {
  return {PlaceOf(global), global.name_space_given || !global.name_space.empty(),
          global.domain.has_value()};
}

bool IsWord(const MachineIdentity& machine, const std::string& word) {
  return machine.name == word || BeginsIdOf(machine, word);
}

}  // namespace

MachinePlace PlaceOf(const GlobalOptions& global) {
  const auto domain = transport::DomainId({});
  return {domain ? domain.value() : 0, global.name_space};
}

std::vector<MachinePlace> PlacesToStop(const GlobalOptions& global) {
  return PlacesToStop(MeantBy(global), PlacesHere(),
                      [](const MachinePlace& place) { return HasFolder(MachineFolders(), place); });
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
  const auto folders = MachineFolders();
  std::vector<MachineBeside> machines;
  const auto is_meant = [&global](const MachineBeside& one) {
    if (global.machine.empty()) return MeantBy(global).MayBe(one.place);
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

std::vector<MachineBeside> MachinesBeside(const GlobalOptions& global,
                                          const std::optional<MachineIdentity>& of_files) {
  std::vector<MachineBeside> machines = MachinesBeside(global);
  if (of_files) std::erase_if(machines, [](const MachineBeside& one) { return !one.runs; });
  return machines;
}

std::vector<MachinePlace> PlacesOfRemoteActuators(const GlobalOptions& global) {
  std::set<MachinePlace> found;
  const MachinePlace own = PlaceOf(global);
  for (const auto& [folder, one] : MachineFolders()) {
    const MachinePlace place{one.domain, one.name_space};
    if (place.domain != own.domain || !MeantBy(global).MayBe(place)) continue;
    if (!global.machine.empty() && !IsWord({one.name, one.id}, global.machine)) continue;
    if (!StateStore::RemoteActuatorsIn(folder, HostId()).empty()) found.insert(place);
  }
  for (const MachinePlace& place : PlacesHere()) found.erase(place);
  return {found.begin(), found.end()};
}

}  // namespace musher::cli
