#include "musher/controller/storage/state_store.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/controller/storage/computer.hpp"
#include "musher/controller/storage/private_folder.hpp"
#include "musher/controller/storage/slot_file.hpp"
#include "musher/controller/storage/stored_power.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

// Bytes of the small files here: the names and hosts of kMostActuators are 2 MiB at most.
constexpr std::size_t kMaxFileSize = 4 << 20;
constexpr std::size_t kLongestText = 256;  // bytes, of who engaged a stop and why, of a host

std::string ReadSmall(int fd) {
  struct stat info {};
  if (fstat(fd, &info) != 0) return "";
  std::string text(std::min(kMaxFileSize, static_cast<std::size_t>(info.st_size)), '\0');
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  return text;
}

// Whether the path names this file.
bool IsAt(const std::string& path, dev_t device, ino_t inode) {
  struct stat info {};
  return lstat(path.c_str(), &info) == 0 && info.st_dev == device && info.st_ino == inode;
}

std::string BootOfHost() {
  const std::string host = HostId();
  return host.substr(0, host.find('/'));
}

// Whether the folder was used in this boot: then it is on the same computer. `owner`: the text of
// the lock's file.
bool IsOfThisBoot(const std::string& owner) {
  const std::string boot = BootOfHost();
  return !boot.empty() && owner.ends_with("\n" + boot + "\n");
}

// The lock counts, not what is in the file: on a full disk it may stay empty.
void NameOwner(int lock, const MachineOrigin& machine) {
  const std::string owner =
      std::to_string(getpid()) + " " + machine.name + "\n" + BootOfHost() + "\n";
  if (ftruncate(lock, 0) == 0) WriteAll(lock, owner);
}

// Only this user may change what is in them: see CheckOwnFolder().
Result<> MakeFolders(const std::string& dir) {
  if (auto own = CheckOwnFolder(dir); !own) return own;
  if (IsLink(dir + "/logs")) return Ok();  // which no log follows
  if (auto made = MakePrivateFolder(fs::path(dir) / "logs"); !made) return made;
  return CheckOwnFolder(dir + "/logs");
}

// Shows the start to a user who may not read the folder, or its parent folder: see
// FindUnreadFolders(). The new times outlast a power cut, like a stop that is saved later.
void Touch(const fs::path& dir) {
  for (const fs::path& folder : {dir, dir.parent_path()}) {
    if (utimensat(AT_FDCWD, folder.c_str(), nullptr, 0) == 0) SyncFolder(folder);
  }
}

std::string OneWord(std::string text) {
  std::erase_if(text, [](unsigned char c) { return c <= ' '; });
  return text.substr(0, kLongestText);
}

// The boot in a HostId(), "BOOT/PID NAMESPACE".
std::string BootOf(const std::string& host) {
  return host.substr(0, host.find('/'));
}

std::string StopsText(const StoredStops& stops) {
  const auto line = [](const std::string& name, std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    return name + " " + text.substr(0, kLongestText) + "\n";
  };
  std::string text;
  for (const EmergencyStop& stop : stops.engaged) {
    text += line("engaged", ToString(stop.id));
    text += line("by", stop.by) + line("reason", stop.reason);
  }
  for (const StopId id : stops.released) {
    const bool replaced = std::ranges::count(stops.replaced, id) != 0;
    text += line(replaced ? "replaced" : "released", ToString(id));
  }
  if (stops.awaits_request) text += "awaits request\n";
  if (stops.led_elsewhere) text += "led elsewhere\n";
  if (stops.engagements != 0) text += line("engagements", std::to_string(stops.engagements));
  for (const UnreadFolder& unread : stops.unread) {
    const std::string owner = unread.owner.empty() ? "-" : OneWord(unread.owner);
    text += line(unread.answered ? "answered" : "unread",
                 std::to_string(unread.mark) + " " + owner + " " + unread.folder);
  }
  return text + "end\n";
}

// "MARK OWNER FOLDER"; nullopt: damaged.
std::optional<UnreadFolder> UnreadFrom(const std::string& text) {
  std::istringstream words(text);
  UnreadFolder unread;
  if (!(words >> unread.mark >> unread.owner) || words.get() != ' ') return std::nullopt;
  if (!std::getline(words, unread.folder)) return std::nullopt;
  if (unread.owner == "-") unread.owner.clear();
  return unread;
}

// nullopt: it is damaged or cut short.
std::optional<StoredStops> StopsFrom(const std::string& text) {
  std::istringstream lines(text);
  StoredStops stops;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string name = line.substr(0, space);
    const std::string value = space < line.size() ? line.substr(space + 1) : "";
    std::uint64_t id = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), id);
    const bool is_id = error == std::errc() && end == value.data() + value.size() && id != 0;
    if (line == "end") return stops;
    if (line == "awaits request") {
      stops.awaits_request = true;
    } else if (line == "led elsewhere") {
      stops.led_elsewhere = true;
    } else if (name == "engaged" && is_id) {
      stops.engaged.push_back({StopId(id), "", ""});
    } else if ((name == "released" || name == "replaced") && is_id) {
      stops.released.emplace_back(id);
      if (name == "replaced") stops.replaced.emplace_back(id);
    } else if (name == "engagements" && is_id) {
      stops.engagements = id;
    } else if (name == "unread" || name == "answered") {
      // What is damaged is found again, and waits for a request again.
      if (auto unread = UnreadFrom(value)) {
        unread->answered = name == "answered";
        stops.unread.push_back(std::move(*unread));
      }
    } else if (name == "by" && !stops.engaged.empty()) {
      stops.engaged.back().by = value;
    } else if (name == "reason" && !stops.engaged.empty()) {
      stops.engaged.back().reason = value;
    } else if (name == "engaged" || name == "released" || name == "replaced" || name == "by" ||
               name == "reason" || name == "engagements") {
      return std::nullopt;
    }  // else it is of a later version
  }
  return std::nullopt;
}

std::string BootFileIn(const std::string& dir) {
  return dir + "/boot";
}

std::string ProcessesFileIn(const std::string& dir) {
  return dir + "/processes";
}

// What decides which actuators move after a restart, besides emergency_stop. A full disk takes its
// saves, too.
constexpr std::array<std::string_view, 2> kShortSlotFiles = {"epoch", "policy"};
constexpr std::array<std::string_view, 2> kLongSlotFiles = {"actuators", "processes"};

// nullopt: the file has no slots.
std::optional<SlotFile> SlotsOf(const std::string& path) {
  const std::string name = fs::path(path).filename();
  if (std::ranges::count(kShortSlotFiles, name) != 0) return SlotFile(path, SlotFile::kShortSlot);
  if (std::ranges::count(kLongSlotFiles, name) != 0) return SlotFile(path);
  return std::nullopt;
}

// The saved text; after a torn save the older text. Empty where none is known.
std::string SavedText(const std::string& path) {
  const auto content = SlotsOf(path)->Read();
  return content ? content->text : "";
}

// What an earlier version has written is converted. On a full disk without the files it fails, and
// again at each save.
void ReserveSmallFiles(const std::string& dir) {
  const auto reserve = [&dir](std::string_view name) {
    const auto slots = SlotsOf(dir + "/" + std::string(name));
    const auto content = slots->Read();
    if (content && content->error != 0) return;  // it stays unreadable until it is saved
    static_cast<void>(slots->Reserve(content && content->plain ? content->text : ""));
  };
  std::ranges::for_each(kShortSlotFiles, reserve);
  std::ranges::for_each(kLongSlotFiles, reserve);
}

// What a person has released at the other computer, which the folder was copied from, was not
// released here: a panel that stops both may still publish it. What is engaged there holds here,
// too, which is the safe side.
void ForgetReleasesIn(const std::string& dir) {
  StoredStops stops = StateStore::EmergencyStopsIn(dir);
  if (stops.released.empty()) return;
  stops.released.clear();
  stops.replaced.clear();
  static_cast<void>(SlotFile(StateStore::EmergencyStopFileIn(dir)).Write(StopsText(stops)));
}

// A number a line.
std::string MarksText(const std::vector<std::uint64_t>& marks) {
  std::string text;
  for (const std::uint64_t mark : marks) text += std::to_string(mark) + "\n";
  return text;
}

std::vector<std::uint64_t> MarksIn(const std::string& path) {
  const UniqueFd file = OpenRegular(path);
  std::istringstream text(file.valid() ? ReadSmall(file.get()) : "");
  std::vector<std::uint64_t> marks;
  for (std::uint64_t mark = 0; text >> mark;) marks.push_back(mark);
  return marks;
}

Error Foreign(const std::string& dir, const MachineOrigin& recorded, const MachineOrigin& machine,
              pid_t led_by) {
  std::string what = dir + " belongs to another machine, " + recorded.Text();
  if (led_by != 0) what += ", which process " + std::to_string(led_by) + " leads";
  return {kCodePermissionDenied,
          what + "; this one is " + machine.Text() +
              ". Give this one a `name` or a `state_dir` of its own in [controller]" +
              (led_by != 0 ? "" : ", or remove " + dir + "/machine if it replaces the other")};
}

}  // namespace

Result<StateStore> StateStore::Open(const std::string& dir, const MachineOrigin& machine) {
  // A folder that cannot be locked is another machine's all the same.
  const auto failed = [&](const Error& error) {
    const auto recorded = LoadOrigin(dir);
    const bool foreign = recorded && !recorded->IsOf(machine, false);
    return foreign ? Foreign(dir, *recorded, machine, 0) : error;
  };
  if (auto made = MakeFolders(dir); !made) {
    const bool unsafe = made.error().code == kCodePermissionDenied;
    return unsafe ? made.error() : failed(made.error());
  }
  const std::string path = dir + "/controller.lock";
  UniqueFd lock(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!lock.valid()) return failed(SystemError("can't open " + path));
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return SystemError("can't lock " + path);
    std::string owner = ReadSmall(lock.get());
    owner = owner.substr(0, owner.find('\n'));
    const auto recorded = LoadOrigin(dir);
    if (recorded && !recorded->IsOf(machine, true)) {
      return Foreign(dir, *recorded, machine, OwnerOf(dir));
    }
    return Error{kCodeTargetBusy, "a controller runs with " + dir + " already: process " +
                                      (owner.empty() ? "unknown" : owner)};
  }
  const auto recorded = LoadOrigin(dir);
  if (recorded && !recorded->IsOf(machine, false)) return Foreign(dir, *recorded, machine, 0);
  MachineOrigin kept = machine;
  std::optional<std::string> copied_from;
  if (recorded) {
    kept.id = recorded->id;
    if (!kept.id.empty() && !IsOfThisBoot(ReadSmall(lock.get())) &&
        IsOtherComputer(recorded->computer, machine.computer)) {
      ForgetReleasesIn(dir);
      copied_from = std::exchange(kept.id, NewMachineId());
    } else {
      kept.computer = ComputerToStore(recorded->computer, machine.computer);
    }
  }
  // On a full disk it stays as it is, and the machine starts all the same.
  if (recorded != kept) static_cast<void>(SaveOrigin(dir, kept, recorded.has_value()));
  NameOwner(lock.get(), machine);
  Touch(dir);
  ReserveSmallFiles(dir);
  StateStore store(dir, std::move(kept), std::move(lock));
  store.copied_from_ = std::move(copied_from);
  store.ReserveEmergencyStops();
  return store;
}

StateStore::StateStore(std::string dir, MachineOrigin machine, UniqueFd lock)
    : dir_(std::move(dir)), machine_(std::move(machine)), lock_(std::move(lock)) {
  for (const std::string& path :
       {OriginFile(dir_), EpochFile(), EmergencyStopFile(), PolicyFile(), ConfigHashFile(),
        StopIntentFile(), RemoteActuatorsFile(), ActuatorsFileIn(dir_), ProcessesFileIn(dir_)}) {
    RememberFile(path);
  }
}

Result<> StateStore::SaveMachineId() {
  auto written = SaveOrigin(dir_, machine_, true);
  if (written) RememberFile(OriginFile(dir_));
  return written;
}

void StateStore::RememberFile(const std::string& path) {
  const UniqueFd file = OpenRegular(path);
  if (file.valid()) Remember(path, ReadSmall(file.get()));
}

void StateStore::Remember(const std::string& path, const std::string& content) {
  struct stat info {};
  if (lstat(path.c_str(), &info) != 0) info = {};
  kept_[path] = {content, info.st_dev, info.st_ino};
}

Result<std::vector<std::string>> StateStore::SaveRemoved() {
  std::vector<std::string> saved;
  auto taken = TakeLockAgain();
  if (!taken) return taken.error();
  if (taken.value()) saved.emplace_back("controller.lock");
  const std::map<std::string, Kept> files = kept_;
  for (const auto& [path, kept] : files) {
    if (IsAt(path, kept.device, kept.inode)) continue;
    auto written = ReplaceFile(path, kept.content, {.mode = 0600});  // with its slots
    if (!written) return written.error();
    Remember(path, kept.content);
    saved.push_back(fs::path(path).filename());
  }
  return saved;
}

// Whether the file of the lock was removed: another controller could lock the file in its place.
Result<bool> StateStore::TakeLockAgain() {
  const std::string path = dir_ + "/controller.lock";
  struct stat held {};
  if (fstat(lock_.get(), &held) == 0 && IsAt(path, held.st_dev, held.st_ino)) return false;
  if (auto made = MakeFolders(dir_); !made) return made.error();
  UniqueFd lock(open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (!lock.valid()) return SystemError("can't open " + path);
  if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) return SystemError("can't lock " + path);
  NameOwner(lock.get(), machine_);
  lock_ = std::move(lock);
  return true;
}

Result<Epoch> StateStore::EpochIn(const std::string& dir) {
  const auto content = SlotsOf(EpochFileIn(dir))->Read();
  if (!content) return Epoch();
  if (content->error != 0) return SystemError("can't read " + EpochFileIn(dir), content->error);
  const std::string& text = content->text;
  if (text.empty() && !content->plain && !content->damaged) return Epoch();  // none was saved
  std::uint64_t epoch = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), epoch);
  if (error != std::errc() || std::string_view(end, text.data() + text.size()) != "\n") {
    return Error{kCodeFailed, EpochFileIn(dir) + " is damaged: it does not hold one number"};
  }
  return Epoch(epoch);
}

Result<> StateStore::SaveEpoch(Epoch epoch) {
  return Replace(EpochFile(), ToString(epoch) + "\n");
}

Result<> StateStore::Replace(const std::string& path, const std::string& content) {
  std::string text = content;
  if (const auto slots = SlotsOf(path)) {
    if (slots->Fits(text) && slots->Write(text)) {
      RememberFile(path);
      return Ok();
    }
    // A full disk that had no room for the slots may have some for the text.
    if (text.size() == slots->size()) text += "\n";  // it is not taken for slots
  }
  auto written = ReplaceFile(path, text, {.mode = 0600});
  if (written) Remember(path, text);
  return written;
}

// "engaged ID" with its lines "by …" and "reason …", and "released ID"; "awaits request"; "led
// elsewhere"; "engagements NUMBER"; "unread MARK OWNER FOLDER", or "answered …" once a person has
// requested a state; a last line "end".
Result<> StateStore::SaveEmergencyStops(const StoredStops& stops) {
  auto written = SlotFile(EmergencyStopFile()).Write(StopsText(stops));
  if (written) RememberFile(EmergencyStopFile());
  return written;
}

// A file that cannot be read counts as an engaged stop, and so does a file with a damaged slot: the
// slot may be the save of an engaged stop that a power cut has torn.
StoredStops StateStore::EmergencyStopsIn(const std::string& dir) {
  const auto content = SlotFile(EmergencyStopFileIn(dir)).Read();
  if (!content) return {};
  const bool none_saved = content->text.empty() && !content->plain;
  const auto read = none_saved ? StoredStops{} : StopsFrom(content->text);
  StoredStops stops = Merge(read.value_or(StoredStops{}), {});
  if (!read || content->damaged) {
    std::erase(stops.released, kUnknownStop);
    const std::string file = EmergencyStopFileIn(dir);
    AddStop(stops,
            {kUnknownStop, "",
             content->error == 0 ? file + " is damaged"
                                 : SystemError("can't read " + file, content->error).message});
  }
  return stops;
}

// On a full disk without the file it fails, and again at each save.
void StateStore::ReserveEmergencyStops() {
  const SlotFile file(EmergencyStopFile());
  const auto content = file.Read();
  const bool converts = content && (content->plain || content->error != 0);
  static_cast<void>(file.Reserve(converts ? StopsText(LoadEmergencyStops()) : ""));
  RememberFile(EmergencyStopFile());
}

Result<> StateStore::SaveStopIntent(bool intended) {
  if (intended) {
    const std::string path = StopIntentFile();
    auto written = Replace(path, "the machine is to stay down\n");
    if (written) return written;
    // The file says it, not its text: an empty one takes no block of a full disk.
    const UniqueFd empty(open(path.c_str(), O_WRONLY | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0600));
    if (!empty.valid() || !SyncFolder(dir_)) return written;
    Remember(path, ReadSmall(OpenRegular(path).get()));
    return Ok();
  }
  kept_.erase(StopIntentFile());
  const bool gone = unlink(StopIntentFile().c_str()) == 0 || errno == ENOENT;
  if (!gone || !SyncFolder(dir_)) return SystemError("can't remove " + StopIntentFile());
  return Ok();
}

bool StateStore::StopIntentIn(const std::string& dir) {
  return access(StopIntentFileIn(dir).c_str(), F_OK) == 0;
}

bool StateStore::LoadStopIntent() const {
  return StopIntentIn(dir_) || errno != ENOENT;
}

// "host HOST" of the controller, then lines "actuator NAME HOST". A host comes from the network.
Result<> StateStore::SaveRemoteActuators(const std::vector<RemoteActuator>& actuators,
                                         const std::string& host) {
  std::string text = "host " + host + "\n";
  for (const RemoteActuator& actuator : actuators) {
    text += "actuator " + actuator.name + " " + OneWord(actuator.host) + "\n";
  }
  return Replace(RemoteActuatorsFile(), text);
}

std::vector<RemoteActuator> StateStore::RemoteActuatorsIn(const std::string& dir,
                                                          const std::string& host) {
  const UniqueFd file = OpenRegular(RemoteActuatorsFileIn(dir));
  std::istringstream lines(file.valid() ? ReadSmall(file.get()) : "");
  std::vector<RemoteActuator> actuators;
  std::string boot_then;  // of this computer
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    RemoteActuator actuator;
    words >> kind;
    if (kind == "host" && words >> actuator.host) boot_then = BootOf(actuator.host);
    if (kind != "actuator" || !(words >> actuator.name)) continue;
    words >> actuator.host;
    actuator.host = OneWord(actuator.host);
    const bool was_here = !actuator.host.empty() && BootOf(actuator.host) == boot_then;
    if (was_here && boot_then != BootOf(host)) continue;
    actuators.push_back(std::move(actuator));
  }
  return actuators;
}

constexpr std::string_view kTornDownWord = "torn_down";
constexpr std::string_view kGivenUpWord = "given_up";
constexpr std::string_view kLostWord = "lost";
constexpr std::string_view kHeldWord = "held";

// "host HOST" of the controller, then lines "torn_down NAME", "given_up NAME", "lost NAME STATE",
// "held NAME STATE".
Result<> StateStore::SaveActuators(const std::vector<StoredActuator>& actuators,
                                   const std::string& host) {
  std::string text = "host " + host + "\n";
  const auto add = [&](std::string_view word, const std::string& rest) {
    text += std::string(word) + " " + rest + "\n";
  };
  for (const StoredActuator& one : actuators) {
    if (one.stays_down == StaysDown::kTornDown) add(kTornDownWord, one.name);
    if (one.stays_down == StaysDown::kGivenUp) add(kGivenUpWord, one.name);
    if (!one.lost_in.empty()) add(kLostWord, one.name + " " + OneWord(one.lost_in));
    if (!one.kept_in.empty()) add(kHeldWord, one.name + " " + OneWord(one.kept_in));
  }
  return Replace(ActuatorsFileIn(dir_), text);
}

std::vector<StoredActuator> StateStore::ActuatorsIn(const std::string& dir,
                                                    const std::string& host) {
  std::istringstream lines(SavedText(ActuatorsFileIn(dir)));
  std::vector<StoredActuator> actuators;
  bool of_this_boot = false;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind;
    std::string name;
    if (!(words >> kind >> name)) continue;
    if (kind == "host") of_this_boot = BootOf(name) == BootOf(host);
    const bool stays = kind == kTornDownWord || (kind == kGivenUpWord && of_this_boot);
    std::string state;
    const bool has_state = kind == kLostWord || kind == kHeldWord;
    const bool in_state = has_state && of_this_boot && words >> state;
    if (!stays && !in_state) continue;
    auto found = std::ranges::find(actuators, name, &StoredActuator::name);
    if (found == actuators.end()) found = actuators.insert(found, StoredActuator{name});
    if (in_state) (kind == kLostWord ? found->lost_in : found->kept_in) = State(state);
    if (stays)
      found->stays_down = kind == kTornDownWord ? StaysDown::kTornDown : StaysDown::kGivenUp;
  }
  return actuators;
}

constexpr std::string_view kProtectedWord = "protected";
constexpr std::string_view kLowPowerWord = "low_power";

// "low_power on", "lowered Active Protected 7", the last the epoch, "level protected", and the line
// of storage/stored_power.hpp.
Result<> StateStore::SavePolicy(const StoredPolicy& policy) {
  std::string text;
  if (policy.low_power)
    text += std::string("low_power ") + (*policy.low_power ? "on" : "off") + "\n";
  if (policy.lowering) {
    text += "lowered " + policy.lowering->from + " " + policy.lowering->to + " " +
            ToString(policy.lowering->epoch) + "\n";
  }
  if (policy.level != BatteryLevel::kFree) {
    const bool is_protected = policy.level == BatteryLevel::kProtected;
    text += "level " + std::string(is_protected ? kProtectedWord : kLowPowerWord) + "\n";
  }
  if (policy.power != PowerAhead::kNone) {
    text += PowerLine(policy.power, SavedText(PolicyFile()));
  }
  return Replace(PolicyFile(), text);
}

StoredPolicy StateStore::PolicyIn(const std::string& dir) {
  StoredPolicy policy;
  const auto content = SlotsOf(PolicyFileIn(dir))->Read();
  const bool unknown = content && content->damaged && content->text.empty();
  if (unknown) policy.level = BatteryLevel::kLowPower;
  std::istringstream text(content ? content->text : "");
  for (std::string word; text >> word;) {
    std::string from;
    std::string to;
    std::uint64_t epoch = 0;
    if (word == "low_power" && text >> word) {
      if (word == "on" || word == "off") policy.low_power = word == "on";
    } else if (word == "level" && text >> word) {
      if (word == kProtectedWord) policy.level = BatteryLevel::kProtected;
      if (word == kLowPowerWord) policy.level = BatteryLevel::kLowPower;
    } else if (word == "lowered" && text >> from >> to >> epoch) {
      policy.lowering = BatteryFallback{State(from), State(to), Epoch(epoch)};
    }
  }
  policy.power = PowerIn(content ? content->text : "");
  return policy;
}

Result<> StateStore::SaveLevelsTaken(const std::vector<std::uint64_t>& marks) {
  return Replace(dir_ + "/levels_taken", MarksText(marks));
}

std::vector<std::uint64_t> StateStore::LevelsTakenIn(const std::string& dir) {
  return MarksIn(dir + "/levels_taken");
}

Result<> StateStore::SaveActuatorsTaken(const std::vector<std::uint64_t>& marks) {
  return Replace(dir_ + "/actuators_taken", MarksText(marks));
}

std::vector<std::uint64_t> StateStore::ActuatorsTakenIn(const std::string& dir) {
  return MarksIn(dir + "/actuators_taken");
}

// In place, which a full disk permits: otherwise each start by a supervisor is taken for the first
// one of the boot, a person's `systemctl start` too.
Result<> StateStore::SaveBootOf(const std::string& host) {
  const std::string path = BootFileIn(dir_);
  const std::string text = BootOf(host) + "\n";
  const auto size = static_cast<ssize_t>(text.size());
  const UniqueFd file(open(path.c_str(), O_WRONLY | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC));
  struct stat info {};
  const bool has_room = file.valid() && fstat(file.get(), &info) == 0 && S_ISREG(info.st_mode) &&
                        info.st_size == size;
  if (!has_room) return Replace(path, text);
  if (pwrite(file.get(), text.data(), text.size(), 0) != size || fdatasync(file.get()) != 0) {
    return SystemError("can't save " + path);
  }
  Remember(path, text);
  return Ok();
}

bool StateStore::BeganInBootOf(const std::string& dir, const std::string& host) {
  const UniqueFd file = OpenRegular(BootFileIn(dir));
  return file.valid() && ReadSmall(file.get()) == BootOf(host) + "\n";
}

Result<> StateStore::SaveConfigHash(const std::string& hash) {
  return Replace(ConfigHashFile(), hash + "\n");
}

std::string StateStore::ConfigHashIn(const std::string& dir) {
  const UniqueFd file = OpenRegular(ConfigHashFileIn(dir));
  const std::string text = file.valid() ? ReadSmall(file.get()) : "";
  return text.substr(0, text.find('\n'));
}

Result<> StateStore::SaveChildren(const std::vector<ChildProcess>& children,
                                  const std::string& host) {
  return Replace(ProcessesFileIn(dir_), ToText(children, host));
}

Result<> StateStore::ForgetChildren(const std::string& dir) {
  // Another user's folder stays as it is.
  unlink(ProcessesFileIn(dir).c_str());
  return Ok();
}

std::vector<ChildProcess> StateStore::LoadChildren(const std::string& dir,
                                                   const std::string& host) {
  return ChildrenFrom(SavedText(ProcessesFileIn(dir)), host);
}

pid_t StateStore::OwnerOf(const std::string& dir) {
  const UniqueFd lock = OpenRegular(dir + "/controller.lock");
  const std::string text = lock.valid() ? ReadSmall(lock.get()) : "";
  pid_t owner = 0;
  std::from_chars(text.data(), text.data() + text.size(), owner);
  return std::max(owner, 0);  // a negative one would name a group of processes
}

bool StateStore::IsOwner(const std::string& dir, pid_t pid) {
  return HoldsLockOn(pid, dir + "/controller.lock");
}

std::vector<ChildProcess> StateStore::ChildrenInOtherNetworkIn(const std::string& dir,
                                                               const std::string& host) {
  return ChildrenInOtherNetwork(SavedText(ProcessesFileIn(dir)), host);
}

std::string StateStore::LogFile(std::string_view actuator) const {
  return dir_ + "/logs/" + std::string(actuator) + ".log";
}

}  // namespace musher
