#include "musher/controller/storage/machine_places.hpp"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

#include "musher/base/files.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/storage/computer.hpp"
#include "musher/controller/storage/other_starts.hpp"
#include "musher/lifecycle/config/config_toml.hpp"

namespace musher {
namespace {

// The place in a name that NameLock::NameOf() has made; nullopt: it is the name of no actuator or
// controller.
std::optional<MachinePlace> PlaceOfName(std::string_view name) {
  constexpr std::string_view kController = "/musher/controller";
  MachinePlace place;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), place.domain);
  if (error != std::errc() || end == name.data() + name.size() || *end != '/') return std::nullopt;
  name.remove_prefix(static_cast<std::size_t>(end - name.data()) + 1);
  const bool leads = name.ends_with(kController);
  const std::size_t last = leads ? name.size() - kController.size() : name.rfind('/');
  if (last == std::string_view::npos) return std::nullopt;
  place.name_space = name.substr(0, last);
  const std::string& where = place.name_space;
  if (!leads && (where == "musher" || where.ends_with("/musher"))) return std::nullopt;
  return place;
}

}  // namespace

std::string MachinePlace::Text(int own_domain) const {
  const std::string text = NamespaceText(name_space);
  return domain == own_domain ? text : text + " of DDS domain " + std::to_string(domain);
}

std::string MachinePlace::Options(const MachinePlace& own) const {
  std::string options;
  if (name_space != own.name_space) options = "--namespace " + ShellWord(name_space);
  if (domain == own.domain) return options;
  return options + (options.empty() ? "" : " ") + "--domain " + std::to_string(domain);
}

std::vector<MachinePlace> PlacesHere() {
  constexpr std::string_view kBegin = " @musher/";
  std::set<MachinePlace> places;
  std::ifstream table("/proc/net/unix");
  for (std::string line; std::getline(table, line);) {
    const std::size_t at = line.find(kBegin);
    if (at == std::string::npos) continue;
    const auto place = PlaceOfName(std::string_view(line).substr(at + kBegin.size()));
    if (place) places.insert(*place);
  }
  return {places.begin(), places.end()};
}

bool MeantPlace::MayBe(const MachinePlace& place) const {
  if (place == own) return false;
  if (place.name_space != own.name_space && names_namespace) return false;
  return place.domain == own.domain || !names_domain;
}

std::vector<MachinePlace> PlacesToStop(const MeantPlace& meant,
                                       const std::vector<MachinePlace>& running,
                                       const std::function<bool(const MachinePlace&)>& has_files) {
  const int domain = meant.own.domain;
  const bool own_runs = std::ranges::count(running, meant.own) != 0;
  std::vector<MachinePlace> places;
  for (const MachinePlace& place : running) {
    if (meant.MayBe(place)) places.push_back(place);
  }
  const bool in_domain = own_runs || std::ranges::count(places, domain, &MachinePlace::domain) != 0;
  std::erase_if(places, [&](const MachinePlace& place) {
    return place.domain != domain && (in_domain || !has_files(place));
  });
  return places;
}

std::vector<MachineFolder> MachineFolders() {
  namespace fs = std::filesystem;
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
  std::vector<MachineFolder> found;
  for (const std::string& folder : folders) {
    auto origin = LoadOrigin(folder);
    if (!origin || !fs::exists(origin->file, error)) continue;
    if (IsOtherComputer(origin->computer, computer)) continue;
    found.emplace_back(folder, std::move(*origin));
  }
  // The config in the working directory is the most likely one.
  const fs::path here = fs::absolute("robot.toml", error).lexically_normal();
  std::stable_partition(found.begin(), found.end(),
                        [&](const auto& one) { return one.second.file == here; });
  return found;
}

bool HasFolder(const std::vector<MachineFolder>& folders, const MachinePlace& place) {
  return std::ranges::any_of(folders, [&place](const MachineFolder& folder) {
    return MachinePlace{folder.second.domain, folder.second.name_space} == place;
  });
}

std::string WhyNotFrom(const MachinePlace& own, const std::vector<MachinePlace>& places,
                       const std::string& found) {
  const auto beside = std::ranges::find_if(
      places, [&](const MachinePlace& one) { return one != own && one.domain == own.domain; });
  const bool own_runs = std::ranges::count(places, own) != 0;
  if (own_runs || beside == places.end()) return "";
  return "the machine of this host runs in " + beside->Text(own.domain) + "; found " + found +
         " in " + own.Text(own.domain) + ". Nothing was done";
}

}  // namespace musher
