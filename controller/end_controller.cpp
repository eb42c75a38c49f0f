#include "musher/controller/end_controller.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "musher/base/host.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/words.hpp"
#include "musher/controller/controller.hpp"
#include "musher/controller/process/child_processes.hpp"
#include "musher/controller/process/network_namespace.hpp"
#include "musher/controller/storage/state_store.hpp"
#include "musher/messages/musher_msgs/heartbeats.hpp"
#include "musher/wire/lifecycle_wire.hpp"

namespace musher {
namespace {

constexpr int kReleaseTimeoutMs = 1000;
constexpr int kEndTimeoutMs = 5000;

// SIGKILL is pending, or the process has begun to exit.
bool IsKilled(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  constexpr std::uint64_t kKill = std::uint64_t{1} << (SIGKILL - 1);
  for (std::string key; status >> key; std::getline(status, key)) {
    std::uint64_t pending = 0;
    if (key != "SigPnd:" && key != "ShdPnd:") continue;
    if (status >> std::hex >> pending && (pending & kKill) != 0) return true;
  }
  std::ifstream stat("/proc/" + std::to_string(pid) + "/stat");
  std::string text;
  std::getline(stat, text);
  const std::size_t name_end = text.rfind(')');  // a name may contain anything
  if (name_end == std::string::npos) return true;
  std::istringstream rest(text.substr(name_end + 1));
  constexpr std::uint64_t kExiting = 4;  // PF_EXITING of linux/sched.h
  std::string state, skipped;
  std::uint64_t flags = 0;
  rest >> state;
  for (int i = 0; i < 5; ++i) rest >> skipped;
  rest >> flags;
  return state == "Z" || state == "X" || (flags & kExiting) != 0;
}

// A running one is received within some 10 ms, a lost packet of the discovery is repeated, and with
// credentials the handshake takes a while; a busy host takes longer.
constexpr Duration kReachedWithin = std::chrono::seconds(10);

// Whether a thread of the process has run between the samples.
bool HasRun(const std::optional<ProcessSample>& before, const std::optional<ProcessSample>& after) {
  if (!before || !after) return false;
  return std::ranges::any_of(after->threads, [&](const auto& thread) {
    const auto then = before->threads.find(thread.first);
    return then == before->threads.end() || thread.second.cpu.ran > then->second.cpu.ran;
  });
}

// "; its CYCLONEDDS_URI is not set, here it is '…'": the variables of the two that differ.
std::string DifferencesTo(pid_t pid) {
  const auto text = [](const std::string& value) {
    constexpr std::size_t kShown = 200;  // bytes
    if (value.empty()) return std::string("not set");
    return "'" + value.substr(0, kShown) + (value.size() > kShown ? "…'" : "'");
  };
  std::string differences;
  for (const char* name : {"CYCLONEDDS_URI", "MUSHER_TRANSPORT", "MUSHER_KEYS"}) {
    const char* set = std::getenv(name);  // NOLINT(concurrency-mt-unsafe)
    const std::string ours = set == nullptr ? "" : set;
    const std::string theirs = VariableOf(pid, name);
    if (ours == theirs) continue;
    differences += std::string("; its ") + name + " is " + text(theirs) + ", here " + text(ours);
  }
  return differences;
}

}  // namespace

Result<> CheckReached(transport::Node& node, const MachineConfig& config, pid_t pid) {
  if (RunStateOf(pid) == ProcessRunState::kStopped) return Ok();
  const std::string host = HostId();
  bool reached = false;
  const auto heartbeats = transport::MakeSubscription<msg::ControllerHeartbeat>(
      node, transport::ControllerHeartbeatTopic(config.name_space),
      [&](const msg::ControllerHeartbeat& heartbeat, const transport::SampleInfo& info) {
        if (!transport::IsOwn(heartbeat.participant, info)) return;
        reached |= heartbeat.pid == pid && heartbeat.host == host;
      },
      transport::kLatchedFromManyQos);
  if (!heartbeats) return heartbeats.error();
  transport::EventLoop& loop = node.loop();
  const auto before = SampleProcess(pid, loop.Now());
  const auto decided = [&] { return reached || !StartTimeOf(pid); };
  if (loop.RunUntil(decided, loop.Now() + kReachedWithin)) return Ok();
  if (!HasRun(before, SampleProcess(pid, loop.Now()))) return Ok();
  const std::string number = std::to_string(pid);
  return Error{kCodeTargetBusy,
               "process " + number +
                   " leads this machine and runs, but no heartbeat of it arrives "
                   "here: it uses another CYCLONEDDS_URI, transport or keys, and a controller here "
                   "would not reach its actuators either, so no process is ended" +
                   DifferencesTo(pid) +
                   "; repeat it with those of the controller, or end it with "
                   "`kill -KILL " +
                   number + "` if it hangs"};
}

bool AwaitKilled(pid_t pid) {
  auto process = OpenPidfd(pid);
  if (!process) return true;
  pollfd ended{process.value().get(), POLLIN, 0};
  return IsKilled(pid) && poll(&ended, 1, kEndTimeoutMs) == 1;
}

Result<> EndController(pid_t pid, const std::function<Result<>()>& is_it) {
  const std::string previous = "the previous controller (pid " + std::to_string(pid) + ")";
  auto process = OpenPidfd(pid);
  if (!process) return Ok();  // it has exited meanwhile
  if (auto proven = is_it(); !proven) return proven;
  pollfd ended{process.value().get(), POLLIN, 0};
  const auto send = [&](int signal) { return SendSignal(ended.fd, signal) || errno == ESRCH; };
  if (!send(kReleaseControlSignal)) return SystemError("can't end " + previous);
  if (poll(&ended, 1, kReleaseTimeoutMs) == 1) return Ok();
  if (!send(SIGKILL)) return SystemError("can't end " + previous);
  if (poll(&ended, 1, kEndTimeoutMs) == 1) return Ok();
  return Error{kCodeTimeout, previous + " does not exit, not even after SIGKILL"};
}

Result<> EndOwnerOf(const std::string& state_dir) {
  const pid_t owner = StateStore::OwnerOf(state_dir);
  return EndController(owner, [&]() -> Result<> {
    if (!StateStore::IsOwner(state_dir, owner)) {
      return Error{
          kCodePermissionDenied,
          state_dir + ": its lock file names process " + std::to_string(owner) +
              ", which does not hold the lock or cannot be inspected; no process is "
              "ended; `fuser " +
              ShellWord(state_dir + "/controller.lock") +
              "` shows the holder, unless it runs in another container or on another host"};
    }
    if (!IsInOtherNetwork(owner)) return Ok();
    return Error{kCodeTargetBusy,
                 "the controller of this machine (process " + std::to_string(owner) +
                     ") runs in another network namespace, and so do its actuators: a controller "
                     "here would reach none of them, so no process is ended; as root, " +
                     InNetworkOf(owner, "musher up --takeover FILE") + " replaces it there"};
  });
}

std::string HowToReplace(pid_t pid) {
  if (IsInOtherNetwork(pid)) {
    return "it runs in another network namespace, where commands of this one reach neither it nor "
           "its actuators; as root, " +
           InNetworkOf(pid, "musher status") + " shows it";
  }
  if (RunStateOf(pid) != ProcessRunState::kStopped)
    return "`musher status` shows it, --takeover replaces it";
  return "it is stopped: `kill -CONT " + std::to_string(pid) +
         "` continues it, --takeover replaces it";
}

std::string HowToReplaceOwnerOf(const std::string& state_dir) {
  const pid_t owner = StateStore::OwnerOf(state_dir);
  if (owner == 0 || StateStore::IsOwner(state_dir, owner)) return HowToReplace(owner);
  return "that process is not visible here: the controller runs in another container, or on "
         "another host, which shares the folder; run the command there";
}

}  // namespace musher
