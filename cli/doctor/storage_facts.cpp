#include "musher/cli/doctor/storage_facts.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <system_error>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/cli/console/wall_time.hpp"
#include "musher/cli/doctor/host_facts.hpp"
#include "musher/cli/doctor/in_child.hpp"
#include "musher/cli/machine/command_times.hpp"
#include "musher/controller/storage/machine_origin.hpp"
#include "musher/controller/storage/state_store.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

std::string OwnerOfFile(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0) return "";
  const passwd* user = getpwuid(info.st_uid);  // NOLINT(concurrency-mt-unsafe): no threads yet
  return user != nullptr ? user->pw_name : fmt::format("user {}", info.st_uid);
}

// Lines: the user of the lock file, whether it is writable, the process that holds it, the other
// machine that the folder belongs to, who else can change what is in it; then the path and the user
// of each log that is not writable.
std::string DescribeFiles(const MachineConfig& config, int domain) {
  const std::string lock = config.state_dir + "/controller.lock";
  MachineOrigin own{config.name, config.name_space, domain, fs::absolute(config.file)};
  const auto origin = LoadOrigin(config.state_dir);
  if (origin && fs::is_directory(origin->file)) own.file = origin->file;  // an upgrade root
  const pid_t owner = StateStore::OwnerOf(config.state_dir);
  const bool held = owner != 0 && StateStore::IsOwner(config.state_dir, owner);
  const bool foreign = origin && !origin->IsOf(own, held);
  auto own_folder = CheckOwnFolder(config.state_dir);
  if (own_folder) own_folder = CheckOwnFolder(config.state_dir + "/logs");
  std::string text =
      fmt::format("{}\n{}\n{}\n{}\n{}\n", OwnerOfFile(lock),
                  access(lock.c_str(), W_OK) == 0 ? 1 : 0, held ? owner : 0,
                  foreign ? origin->Text() : "", own_folder ? "" : own_folder.error().message);
  std::vector<std::string> logs = {ControllerLogFile(config)};
  for (const ActuatorConfig& actuator : config.actuators) {
    logs.push_back(config.state_dir + "/logs/" + actuator.name + ".log");
  }
  for (const std::string& log : logs) {
    const std::string user = OwnerOfFile(log);
    if (!user.empty() && access(log.c_str(), W_OK) != 0) text += log + '\n' + user + '\n';
  }
  return text;
}

constexpr std::int64_t kWeekNs = std::int64_t{7} * 24 * 3600 * 1'000'000'000;

// Lines: why the times are not known, or empty; the number of commands; then each warning.
std::string DescribeTimes(const MachineConfig& config) {
  const std::string journal = config.state_dir + "/journal.sqlite";
  if (access(journal.c_str(), R_OK) != 0) return "there is no journal that this user can read\n";
  const auto read = ReadCommandTimes(journal, WallNow() - kWeekNs);
  if (!read) return read.error().message + '\n';
  const auto& commands = read.value().commands;
  std::string text = fmt::format("\n{}\n", commands.size());
  for (const std::string& warning : TimeWarnings(LearnTimes(commands, config, {}))) {
    text += warning + '\n';
  }
  return text;
}

TimesFacts ReadTimes(const MachineConfig& config, Duration timeout) {
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  auto child = InChild::Start([&] { return DescribeTimes(config); });
  const auto text = child ? child.value().Await(deadline) : Result<std::string>(child.error());
  if (!text) return {"the journal was not read: " + text.error().message};
  std::istringstream lines(text.value());
  TimesFacts times;
  std::string line;
  std::getline(lines, times.error);
  std::getline(lines, line);
  times.commands = std::strtoul(line.c_str(), nullptr, 10);
  while (std::getline(lines, line)) times.warnings.push_back(line);
  return times;
}

// As much as the journal needs for its next pages and their index.
constexpr std::size_t kTestWrite = 128 << 10;  // bytes

// Writes a file without a name, which leaves nothing behind; returns why that fails.
std::string TestWrite(const std::string& folder) {
  const UniqueFd file(open(folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600));
  const bool unknown = errno == EOPNOTSUPP || errno == EISDIR;  // to this file system
  if (!file.valid()) return unknown ? "" : std::generic_category().message(errno);
  if (WriteAll(file.get(), std::string(kTestWrite, '\0')) && fsync(file.get()) == 0) return "";
  return std::generic_category().message(errno);
}

}  // namespace

void ReadStorage(DoctorFacts& facts, Duration timeout) {
  if (!facts.config) return;
  const MachineConfig& config = *facts.config;
  facts.state_dir = ReadFolder(config.state_dir, timeout, facts.clock.newest_file_s);
  if (!facts.state_dir->error.empty()) return;
  std::int64_t newest = 0;
  facts.log_dirs.push_back(ReadFolder(config.state_dir + "/logs", timeout, newest));
  if (!config.log.empty()) {
    facts.log_dirs.push_back(ReadFolder(fs::path(config.log).parent_path(), timeout, newest));
  }
  if (facts.state_dir->is_folder && facts.state_dir->writable) {
    auto test = InChild::Start([&] { return TestWrite(facts.state_dir->existing); });
    const auto error = test ? test.value().Await(std::chrono::steady_clock::now() + timeout)
                            : Result<std::string>(test.error());
    facts.state_dir->write_error = error ? error.value() : error.error().message;
  }
  const Time deadline = std::chrono::steady_clock::now() + timeout;
  auto child = InChild::Start([&] { return DescribeFiles(config, facts.domain); });
  const auto text = child ? child.value().Await(deadline) : Result<std::string>(child.error());
  if (!text) return;
  std::istringstream lines(text.value());
  const auto line = [&lines] {
    std::string next;
    std::getline(lines, next);
    return next;
  };
  LockFacts lock;
  lock.path = config.state_dir + "/controller.lock";
  lock.owner = line();
  lock.writable = line() == "1" || lock.owner.empty();
  lock.held_by = static_cast<int>(std::strtol(line().c_str(), nullptr, 10));
  lock.belongs_to = line();
  facts.state_dir->untrusted = line();
  facts.lock = std::move(lock);
  for (std::string path = line(); !path.empty(); path = line()) {
    facts.unwritable_logs.push_back({path, line()});
  }
  facts.times = ReadTimes(config, timeout);
}

}  // namespace musher::cli
