#include "musher/controller/storage/other_starts.hpp"

#include <fcntl.h>
#include <pwd.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <utility>

#include "musher/base/checksum.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/controller/storage/state_store.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

struct User {
  std::string name;
  fs::path home;  // empty where it is not known
};

User UserOf(uid_t uid) {
  struct passwd entry {};
  struct passwd* found = nullptr;
  std::array<char, 16 << 10> text{};
  const bool known =
      getpwuid_r(uid, &entry, text.data(), text.size(), &found) == 0 && found != nullptr;
  if (!known) return {std::to_string(uid), {}};
  return {found->pw_name, found->pw_dir == nullptr ? "" : found->pw_dir};
}

// The home folder of the owner of a file; empty where it is not known.
fs::path HomeOfOwner(const std::string& file) {
  struct stat info {};
  return stat(file.c_str(), &info) == 0 ? UserOf(info.st_uid).home : fs::path();
}

bool IsClosed(const std::string& file) {
  const UniqueFd opened(open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  return !opened.valid() && errno == EACCES;
}

std::string StampOf(const std::string& path, const struct stat& info) {
  return path + " " + std::to_string(info.st_ino) + " " + std::to_string(info.st_mtim.tv_sec) +
         "." + std::to_string(info.st_mtim.tv_nsec) + "\n";
}

// What can be seen from outside of a folder whose stops this user may not read.
struct SeenFolder {
  UnreadFolder unread;
  bool shows_starts = true;  // each start there changes its mark
};

// Whether only its owner and root, who can touch a closed place, can start a machine in it.
bool IsOfOneUser(const struct stat& place) {
  return (place.st_mode & (S_IXGRP | S_IXOTH)) == 0;
}

// nullopt: they can be read, or belong to another machine, or nothing is seen of a folder.
std::optional<SeenFolder> UnreadIn(const std::string& folder, const MachineOrigin& machine) {
  SeenFolder seen{{folder}};
  UnreadFolder& unread = seen.unread;
  struct stat info {};
  std::string stamp;
  bool damaged = false;  // no user can read it
  if (stat(folder.c_str(), &info) == 0) {
    const std::string stops = StateStore::EmergencyStopFileIn(folder);
    if (!IsClosed(OriginFile(folder))) {
      const auto origin = LoadOrigin(folder);
      if (!origin || !origin->IsOf(machine, true)) return std::nullopt;
      damaged = !IsClosed(stops);
      if (damaged && !StateStore::HasDamagedStops(folder)) return std::nullopt;
    }
    struct stat of_stops {};
    if (stat(stops.c_str(), &of_stops) == 0) stamp = StampOf(stops, of_stops);
  } else {
    if (errno != EACCES) return std::nullopt;
    unread.folder = fs::path(folder).parent_path();
    if (stat(unread.folder.c_str(), &info) != 0) return std::nullopt;
    seen.shows_starts = IsOfOneUser(info);
  }
  if (!damaged) unread.owner = UserOf(info.st_uid).name;
  unread.mark = Fnv1a(StampOf(unread.folder, info) + stamp);
  return seen;
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
  const auto is_released = [&](StopId id) { return std::ranges::count(known.released, id) != 0; };
  const auto is_engaged = [&](StopId id) {
    return std::ranges::count(known.engaged, id, &EmergencyStop::id) != 0;
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
    const StopId last = LastOf(stops);
    stops.awaits_request = stops.awaits_request && (last == kUnknownStop || !is_released(last));
    std::erase_if(stops.engaged, [&](const EmergencyStop& stop) {
      return stop.id == kUnknownStop || is_released(stop.id);
    });
    std::erase_if(stops.released, is_engaged);  // what is engaged here is released here
    if (!stops.engaged.empty() || stops.awaits_request) found.push_back({folder, std::move(stops)});
  }
  return found;
}

std::vector<UnreadFolder> FindUnreadFolders(const std::string& state_dir,
                                            const MachineOrigin& machine,
                                            const std::vector<std::string>& folders,
                                            const std::vector<UnreadFolder>& known) {
  std::vector<UnreadFolder> found;
  for (const std::string& folder : folders) {
    std::error_code error;
    if (fs::equivalent(folder, state_dir, error)) continue;
    auto seen = UnreadIn(folder, machine);
    if (!seen || std::ranges::count(found, seen->unread.mark, &UnreadFolder::mark) != 0) continue;
    const auto before = std::ranges::find(known, seen->unread.mark, &UnreadFolder::mark);
    seen->unread.answered = seen->shows_starts && before != known.end() && before->answered;
    found.push_back(std::move(seen->unread));
  }
  return found;
}

}  // namespace musher
