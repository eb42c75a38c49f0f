#include "musher/controller/storage/machine_origin.hpp"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/words.hpp"

namespace musher {
namespace {

namespace fs = std::filesystem;

constexpr const char* kLock = "controller.lock";

// One line of the file.
std::string Line(const std::string& key, std::string value) {
  std::replace(value.begin(), value.end(), '\n', ' ');
  return key + " " + value + "\n";
}

}  // namespace

std::string OriginFile(const std::string& state_dir) {
  return state_dir + "/machine";
}

std::string MachineOrigin::Text() const {
  return name + " of " + file + " (" + NamespaceText(name_space) + ", domain " +
         std::to_string(domain) + ")";
}

bool MachineOrigin::IsOf(const MachineOrigin& now, bool led) const {
  if (name != now.name || name_space != now.name_space || domain != now.domain) return false;
  if (file == now.file) return true;
  std::error_code error;
  if (!fs::exists(file, error)) return !led;
  return fs::equivalent(file, now.file, error) && !error;
}

std::optional<MachineOrigin> LoadOrigin(const std::string& state_dir) {
  constexpr std::size_t kLongest = 64 << 10;  // bytes
  const UniqueFd file = OpenRegular(OriginFile(state_dir));
  if (!file.valid()) return std::nullopt;
  std::string text(kLongest, '\0');
  const ssize_t size = pread(file.get(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  std::istringstream in(text);
  MachineOrigin origin;
  for (std::string line; std::getline(in, line);) {
    const std::size_t space = std::min(line.find(' '), line.size());
    const std::string key = line.substr(0, space);
    const std::string value = space < line.size() ? line.substr(space + 1) : "";
    if (key == "name") origin.name = value;
    if (key == "namespace") origin.name_space = value;
    if (key == "domain") {
      std::from_chars(value.data(), value.data() + value.size(), origin.domain);
    }
    if (key == "file") origin.file = value;
    if (key == "id") origin.id = value;
    if (key == "computer") {
      std::istringstream parts(value);
      for (std::string part; parts >> part;) origin.computer.push_back(part);
    }
  }
  if (origin.name.empty() || origin.file.empty()) return std::nullopt;
  return origin;
}

Result<> SaveOrigin(const std::string& state_dir, const MachineOrigin& origin, bool synced) {
  std::string text = Line("name", origin.name) + Line("namespace", origin.name_space) +
                     Line("domain", std::to_string(origin.domain)) + Line("file", origin.file) +
                     Line("id", origin.id);
  std::string computer;
  for (const std::string& part : origin.computer) computer += (computer.empty() ? "" : " ") + part;
  if (!computer.empty()) text += Line("computer", computer);
  return ReplaceFile(OriginFile(state_dir), text, {.synced = synced});
}

std::string NewMachineId() {
  std::ifstream file("/proc/sys/kernel/random/uuid");
  std::string id;
  std::getline(file, id);
  return id;
}

std::string StateDirOfProcess(pid_t pid) {
  for (const fs::path& descriptor : EntriesOf("/proc/" + std::to_string(pid) + "/fd")) {
    std::error_code closed;
    const fs::path target = fs::read_symlink(descriptor, closed);
    if (closed || target.filename() != kLock) continue;
    if (HoldsLockOn(pid, target)) return target.parent_path();
  }
  return {};
}

std::optional<MachineOrigin> OriginOfProcess(pid_t pid) {
  const std::string state_dir = StateDirOfProcess(pid);
  return state_dir.empty() ? std::nullopt : LoadOrigin(state_dir);
}

std::optional<MachineOrigin> OriginHere(int domain, const std::string& name_space) {
  return OriginOfProcess(
      NameLock::HolderOf(NameLock::NameOf(domain, name_space, "musher/controller")).pid);
}

}  // namespace musher
