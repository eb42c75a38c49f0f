#include "musher/controller/storage/other_starts.hpp"

#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "musher/base/checksum.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/process/network_namespace.hpp"
#include "musher/controller/storage/computer.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/lifecycle/step/emergency_stops.hpp"

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

// The home folders of all users of a file like /etc/passwd, which needs no server of a directory.
std::vector<fs::path> HomesOf(const std::string& users) {
  std::istringstream lines(ReadFile(users));
  std::vector<fs::path> homes;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);  // name:password:uid:gid:comment:home:shell
    std::string field;
    for (int i = 0; i < 6 && std::getline(fields, field, ':'); ++i) continue;
    if (const fs::path home = field; home.is_absolute()) homes.push_back(home);
  }
  return homes;
}

// Whether a start at boot may have to wait for a path: it is on a file system of another host, or
// on one that is mounted on demand. By text alone, which waits for nothing. `mounts`: as in
// /proc/self/mountinfo.
bool IsOnNetwork(const fs::path& path, const std::string& mounts) {
  constexpr std::array<std::string_view, 14> kTypes = {
      "nfs", "nfs4",       "cifs",           "smb3",      "autofs",      "ceph",      "afs",
      "9p",  "fuse.sshfs", "fuse.glusterfs", "fuse.ceph", "fuse.rclone", "fuse.s3fs", "fuse.davfs"};
  std::istringstream lines(mounts);
  std::size_t longest = 0;
  bool on_network = false;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);  // id parent device root PLACE options... - TYPE source
    std::string field;
    fs::path place;
    for (int i = 0; i < 5 && fields >> field; ++i) place = field;
    while (fields >> field && field != "-") continue;
    fields >> field;
    const fs::path below = path.lexically_relative(place);
    const bool covers = !below.empty() && *below.begin() != "..";
    if (!covers || place.native().size() < longest) continue;
    longest = place.native().size();  // of two at one place the later one
    on_network = place != "/" && std::ranges::count(kTypes, field) != 0;
  }
  return on_network;
}

// Why a file cannot be read, as errno; 0: it can, or there is none.
int WhyUnreadable(const std::string& file) {
  if (OpenRegular(file).valid()) return 0;
  return errno == ENOENT || errno == ENOTDIR ? 0 : errno;
}

bool IsClosed(const std::string& file) {
  return WhyUnreadable(file) == EACCES;
}

std::string StampOf(const std::string& path, const struct stat& info) {
  return path + " " + std::to_string(info.st_ino) + " " + std::to_string(info.st_mtim.tv_sec) +
         "." + std::to_string(info.st_mtim.tv_nsec) + "\n";
}

std::string StampOf(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 ? StampOf(path, info) : std::string();
}

// The id of a stop without an id in a folder. It changes when the file is written again.
StopId IdOfUnknownStop(const std::string& folder) {
  const std::uint64_t hash = Fnv1a(StampOf(StateStore::EmergencyStopFileIn(folder)));
  return StopId(std::max(hash, kUnknownStop.value() + 1));
}

bool IsOfFile(const MachineOrigin& origin, const MachineOrigin& machine) {
  std::error_code error;
  const bool same = origin.file == machine.file || fs::equivalent(origin.file, machine.file, error);
  return same && !error && !IsOtherComputer(origin.computer, machine.computer);
}

// The folders other than `state_dir` that belong to this machine, as far as is known; each once.
std::vector<std::string> OthersOf(const std::string& state_dir, const MachineOrigin& machine,
                                  const std::vector<std::string>& folders) {
  std::vector<std::string> others;
  for (const std::string& folder : folders) {
    std::error_code error;
    const bool own = folder == state_dir || fs::equivalent(folder, state_dir, error);
    if (own || std::ranges::count(others, folder) != 0) continue;
    const auto origin = LoadOrigin(folder);
    if (!origin || origin->IsOf(machine, true) || IsOfFile(*origin, machine)) {
      others.push_back(folder);
    }
  }
  return others;
}

// What can be seen from outside of a folder that this user may not read.
struct SeenFolder {
  UnreadFolder unread;
  bool shows_starts = true;  // each start there changes its mark
};

// Whether only its owner and root, who can touch a closed place, can start a machine in it.
bool IsOfOneUser(const struct stat& place) {
  return (place.st_mode & (S_IXGRP | S_IXOTH)) == 0;
}

enum class Readable : std::uint8_t { kYes, kToOthers, kToNone };

Readable ReadableIn(const std::string& folder) {
  const int stops = WhyUnreadable(StateStore::EmergencyStopFileIn(folder));
  const int policy = WhyUnreadable(StateStore::PolicyFileIn(folder));
  if (IsClosed(OriginFile(folder)) || stops == EACCES || policy == EACCES) {
    return Readable::kToOthers;
  }
  return stops == 0 && policy == 0 ? Readable::kYes : Readable::kToNone;  // its disk fails
}

// nullopt: the folder can be read, belongs to another machine, or cannot be seen at all.
std::optional<SeenFolder> UnreadIn(const std::string& folder, const MachineOrigin& machine) {
  SeenFolder seen{{folder}};
  UnreadFolder& unread = seen.unread;
  struct stat info {};
  std::string stamp;
  if (stat(folder.c_str(), &info) == 0) {
    const auto origin = LoadOrigin(folder);
    if (origin && !origin->IsOf(machine, true)) return std::nullopt;
    const Readable readable = ReadableIn(folder);
    if (readable == Readable::kYes) return std::nullopt;
    if (readable == Readable::kToOthers) unread.owner = UserOf(info.st_uid).name;
    seen.shows_starts = readable == Readable::kToOthers;  // on a disk that fails no start is seen
    stamp = StampOf(StateStore::EmergencyStopFileIn(folder));
  } else if (errno == EACCES) {
    unread.folder = fs::path(folder).parent_path();
    if (stat(unread.folder.c_str(), &info) != 0) return std::nullopt;
    seen.shows_starts = IsOfOneUser(info);
    unread.owner = UserOf(info.st_uid).name;
  } else {
    if (errno == ENOENT || errno == ENOTDIR) return std::nullopt;
    seen.shows_starts = false;
  }
  unread.mark = Fnv1a(StampOf(unread.folder, info) + stamp);
  return seen;
}

}  // namespace

std::vector<std::string> DefaultStateDirs(const MachineOrigin& machine, const std::string& users,
                                          const std::string& mounts_file) {
  const fs::path by_user = config_toml::DefaultStateDir(machine.name, machine.name_space);
  const fs::path name = by_user.filename();
  std::vector<std::string> folders{by_user, fs::path(kServicePlace) / name};
  const auto add = [&](const std::string& folder) {
    if (std::ranges::count(folders, folder) == 0) folders.push_back(folder);
  };
  const fs::path in_home = fs::path(".local/state/musher") / name;
  if (const fs::path home = HomeOfOwner(machine.file); home.is_absolute()) add(home / in_home);
  if (geteuid() != 0) return folders;
  const std::string mounts = ReadFile(mounts_file);
  for (const fs::path& home : HomesOf(users)) {
    if (IsOnNetwork(home, mounts)) continue;
    struct stat info {};
    const bool seen = lstat((home / in_home).c_str(), &info) == 0;
    bool counts = seen || (errno != ENOENT && errno != ENOTDIR);
    if (seen && S_ISLNK(info.st_mode)) {
      std::error_code error;
      counts = !IsOnNetwork(fs::read_symlink(home / in_home, error), mounts);
    }
    if (counts) add(home / in_home);
  }
  return folders;
}

std::vector<std::string> FoldersOfFile(const MachineOrigin& machine,
                                       const std::vector<std::string>& folders) {
  std::vector<std::string> found;
  std::set<fs::path> places;
  for (const std::string& folder : folders) {
    const fs::path place = fs::path(folder).parent_path();
    if (!places.insert(place).second) continue;
    for (const fs::path& one : EntriesOf(place)) {
      const auto origin = LoadOrigin(one);
      if (!origin || origin->IsOf(machine, true) || !IsOfFile(*origin, machine)) continue;
      if (std::ranges::count(folders, one.string()) == 0) found.push_back(one);
    }
  }
  return found;
}

std::string OtherRun::Text(const MachineOrigin& now) const {
  const bool led = controller != 0;
  const pid_t process = led ? controller : actuators.front().pid;
  std::string command = "musher --namespace " + ShellWord(machine.name_space) + " --domain " +
                        std::to_string(machine.domain) + " down";
  if (!led) command += " --without-controller";
  const bool beyond = IsInOtherNetwork(process);
  return (led ? "process " + std::to_string(controller) + " leads "
              : NamesOf(actuators) + " run without a controller as ") +
         machine.Text() + "; a start of the same config as " + now.Text() +
         " would run each actuator twice. " +
         (beyond ? "As root, " + InNetworkOf(process, command) : "`" + command + "`") + " ends " +
         (led ? "the first" : "them");
}

std::optional<OtherRun> FindOtherRun(const MachineOrigin& machine,
                                     const std::vector<std::string>& folders) {
  for (const std::string& folder : FoldersOfFile(machine, folders)) {
    const auto origin = LoadOrigin(folder);
    if (!origin) continue;
    // In one namespace and domain the processes find each other by their names.
    if (origin->name_space == machine.name_space && origin->domain == machine.domain) continue;
    const pid_t owner = StateStore::OwnerOf(folder);
    if (StateStore::IsOwner(folder, owner)) return OtherRun{*origin, owner, {}};
    auto running = StateStore::LoadChildren(folder, HostId());
    std::erase_if(running, [](const ChildProcess& child) { return !IsRunning(child); });
    if (!running.empty()) return OtherRun{*origin, 0, std::move(running)};
  }
  return std::nullopt;
}

StoredStops OpenStopsIn(const std::string& folder) {
  if (IsClosed(StateStore::EmergencyStopFileIn(folder))) return {};
  return StateStore::EmergencyStopsIn(folder);
}

std::vector<StopsElsewhere> FindStopsElsewhere(const std::string& state_dir,
                                               const MachineOrigin& machine,
                                               const std::vector<std::string>& folders,
                                               const StoredStops& known) {
  std::vector<StopsElsewhere> found;
  for (const std::string& folder : OthersOf(state_dir, machine, folders)) {
    StoredStops stops = StopsThatHold(known, OpenStopsIn(folder), IdOfUnknownStop(folder));
    if (!stops.engaged.empty() || stops.awaits_request) found.push_back({folder, std::move(stops)});
  }
  return found;
}

std::vector<LevelElsewhere> FindLevelsElsewhere(const std::string& state_dir,
                                                const MachineOrigin& machine,
                                                const std::vector<std::string>& folders) {
  std::vector<LevelElsewhere> found;
  for (const std::string& folder : OthersOf(state_dir, machine, folders)) {
    const std::string file = StateStore::PolicyFileIn(folder);
    if (WhyUnreadable(file) != 0) continue;
    const BatteryLevel level = StateStore::PolicyIn(folder).level;
    if (level != BatteryLevel::kFree) found.push_back({folder, level, Fnv1a(StampOf(file))});
  }
  return found;
}

std::vector<StayDownElsewhere> FindStayDownElsewhere(const std::string& state_dir,
                                                     const MachineOrigin& machine,
                                                     const std::vector<std::string>& folders) {
  std::vector<StayDownElsewhere> found;
  for (const std::string& folder : OthersOf(state_dir, machine, folders)) {
    std::vector<StoredActuator> down = StateStore::ActuatorsIn(folder, HostId());
    std::erase_if(down, [](const auto& one) { return one.stays_down == StaysDown::kNo; });
    for (StoredActuator& one : down) one = {one.name, one.stays_down};
    if (down.empty()) continue;
    const std::string stamp = StampOf(StateStore::ActuatorsFileIn(folder));
    found.push_back({folder, std::move(down), Fnv1a(stamp)});
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
