#include "musher/controller/storage/other_starts.hpp"

#include <pwd.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "musher/base/toml/names.hpp"
#include "musher/controller/storage/state_store.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// The home folder of the owner of a file; empty where it is not known.
fs::path HomeOfOwner(const std::string& file) {
  struct stat info {};
  if (stat(file.c_str(), &info) != 0) return {};
  struct passwd entry {};
  struct passwd* found = nullptr;
  std::array<char, 16 << 10> text{};
  if (getpwuid_r(info.st_uid, &entry, text.data(), text.size(), &found) != 0) return {};
  return found == nullptr || found->pw_dir == nullptr ? "" : found->pw_dir;
}

StopId LastOf(const StoredStops& stops) {
  if (!stops.engaged.empty()) return stops.engaged.back().id;
  return stops.released.empty() ? kUnknownStop : stops.released.back();
}

}  // namespace

std::vector<std::string> DefaultStateDirs(const MachineOrigin& machine) {
  const fs::path by_user = config_toml::DefaultStateDir(machine.name, machine.name_space);
  const fs::path name = by_user.filename();
  std::vector<std::string> folders{by_user, fs::path(kServicePlace) / name};
  if (const fs::path home = HomeOfOwner(machine.file); home.is_absolute()) {
    folders.push_back(home / ".local" / "state" / "musher" / name);
  }
  return folders;
}

std::vector<StopsElsewhere> FindStopsElsewhere(const std::string& state_dir,
                                               const MachineOrigin& machine,
                                               const std::vector<std::string>& folders,
                                               const StoredStops& known) {
  const auto is_known = [&](StopId id) {
    return id == kUnknownStop || std::ranges::count(known.released, id) != 0;
  };
  std::vector<StopsElsewhere> found;
  for (const std::string& folder : folders) {
    std::error_code error;
    const auto is_it = [&](const StopsElsewhere& one) { return one.state_dir == folder; };
    if (fs::equivalent(folder, state_dir, error) || std::ranges::any_of(found, is_it)) continue;
    const auto origin = LoadOrigin(folder);
    if (!origin || !origin->IsOf(machine, true)) continue;
    StoredStops stops = StateStore::ReadableStops(folder);
    // Since its last stop is known here, this machine's own folder says whether it waits.
    stops.awaits_request = stops.awaits_request && !is_known(LastOf(stops));
    std::erase_if(stops.engaged, [&](const EmergencyStop& stop) { return is_known(stop.id); });
    if (!stops.engaged.empty() || stops.awaits_request) found.push_back({folder, std::move(stops)});
  }
  return found;
}

}  // namespace musher
