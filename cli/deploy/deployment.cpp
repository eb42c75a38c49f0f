#include "musher/cli/deploy/deployment.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <utility>

#include "musher/base/exit_status.hpp"
#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/program.hpp"
#include "musher/base/unique_fd.hpp"
#include "musher/base/version.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/deploy/host_slot.hpp"
#include "musher/cli/machine/host_query.hpp"
#include "musher/controller/process/ssh.hpp"
#include "musher/ota/bundle.hpp"
#include "musher/ota/posix_disk.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kLookWithin = Milliseconds(10'000);
constexpr Duration kSendWithin = std::chrono::minutes(15);
constexpr Duration kStageWithin = std::chrono::minutes(5);
constexpr Duration kSwitchWithin = std::chrono::minutes(1);
constexpr Duration kUndoWithin = kStageWithin;     // it reads the whole version before
constexpr std::uint64_t kDeployReserve = 4 << 20;  // bytes, for folders and the state of the slots
constexpr const char* kNoTemporaryFolder = "there is no folder for temporary files; set TMPDIR";
constexpr int kSshFailed = 255;  // its exit code when it has not reached the host

// A folder that is removed with its content.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = (fs::temp_directory_path() / "musher-deploy-XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) path_.clear();
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  const std::string& path() const { return path_; }  // empty: there is none

 private:
  std::string path_;
};

std::string OnHost(const HostConfig& host) {
  return "host " + host.name + " (" + host.Login() + "): ";
}

std::uint64_t SizeOf(const HostFiles& files) {
  std::uint64_t bytes = 0;
  for (const auto& [path, source] : files.files) {
    std::error_code error;
    const auto size = fs::file_size(source, error);
    if (!error) bytes += size;
  }
  return bytes;
}

std::string LookScript(const std::string& root) {
  return "root=" + ShellWord(root) + R"sh(
place=$root
until [ -d "$place" ]; do place=$(dirname "$place"); done
beside=$(dirname "$root")
until [ -d "$beside" ]; do beside=$(dirname "$beside"); done
command -v musher >/dev/null && echo "version $(musher --version </dev/null)"
command -v tar >/dev/null || echo "missing tar"
echo "processor$(od -An -tx1 -j18 -N2 /proc/self/exe)"
echo "arch $(uname -m)"
set -- $(df -Pk "$place" | tail -n 1)
echo "free $4"
echo "user $(id -un)"
[ -w "$place" ] || echo "unwritable $place"
[ -w "$beside" ] || echo "unwritable-beside $beside"
)sh";
}

// What of the host does not fit; empty: all does.
std::string Misfit(const HostFiles& files, const std::vector<std::string>& lines) {
  std::map<std::string, std::string> facts;
  for (const std::string& line : lines) {
    const std::size_t space = line.find(' ');
    if (space != std::string::npos) facts[line.substr(0, space)] = line.substr(space + 1);
  }
  const std::string ssh = "ssh " + files.host->Login();
  const std::string version = facts["version"].substr(facts["version"].rfind(' ') + 1);
  if (version.empty()) return "it has no `musher`, which keeps its versions; install it there";
  if (version != Version()) {
    return fmt::format("it has musher {}, this program is {}; install the same version there",
                       version, Version());
  }
  if (facts.contains("missing")) return "it has no `tar`; install it there";
  for (const auto& [path, source] : files.files) {
    const std::string processor = ProcessorOf(source);
    if (processor.empty() || processor == facts["processor"]) continue;
    return fmt::format(
        "{} is built for another processor than this host's {}; put the one for it into a folder "
        "{}/ of --from",
        source, facts["arch"], files.host->name);
  }
  if (facts.contains("unwritable-beside")) {
    return fmt::format(
        "its user {} may not write {}, where the files are kept beside {} while they are sent; set "
        "`user` to root, or name a root in a folder of {}",
        facts["user"], facts["unwritable-beside"], files.root, facts["user"]);
  }
  if (facts.contains("unwritable")) {
    return fmt::format(
        "its user {} may not write {}; set `user` to root, or run there as root: chown -R {} {}",
        facts["user"], facts["unwritable"], facts["user"], ShellWord(facts["unwritable"]));
  }
  const std::string& free = facts["free"];
  std::uint64_t free_kib = 0;
  std::from_chars(free.data(), free.data() + free.size(), free_kib);
  // Once as it was sent, and once in its slot.
  const std::uint64_t need_kib = (2 * SizeOf(files) + kDeployReserve) >> 10;
  if (free.empty() || need_kib <= free_kib) return {};
  return fmt::format("it needs {} MiB for {}, there are {}; `{} journalctl --vacuum-size=100M`",
                     (need_kib >> 10) + 1, files.root, free_kib >> 10, ssh);
}

bool IsInterrupted(const DeployOptions& options) {
  pollfd waiting{options.interrupt, POLLIN, 0};
  return poll(&waiting, 1, 0) == 1;
}

// The bundle of a host, with the public key, as they are sent.
Result<ota::Manifest> MakeBundleOf(const HostFiles& files, const DeployOptions& options,
                                   const std::string& folder) {
  ota::PosixDisk disk;
  const std::string payload = folder + "/payload";
  const std::string sent = folder + "/sent";
  try {
    for (const auto& [path, source] : files.files) {
      const fs::path to = fs::path(payload) / path;
      fs::create_directories(to.parent_path());
      fs::copy_file(source, to);
    }
    fs::create_directory(sent);
  } catch (const fs::filesystem_error& error) {
    return Error{kCodeFailed, error.what()};
  }
  ota::Manifest manifest;
  manifest.robot = options.robot;
  manifest.version = options.version;
  manifest.created = options.created;
  auto made = ota::MakeBundle(disk, payload, manifest, options.private_pem, sent + "/bundle",
                              [&](std::uint64_t) { return !IsInterrupted(options); });
  if (!made) return made.error();
  const auto key = ota::WriteAll(disk, sent + "/ota.pub", options.public_pem, 0644);
  if (!key) return key.error();
  return made;
}

// How what sends the files has ended.
struct SendEnd {
  ExitStatus status;
  bool timed_out = false;
  std::optional<ProgramFailure> failure;  // it was not executed
};

// Runs it in a group of its own, which is killed after `within`, or once `interrupt` is readable.
Result<SendEnd> RunSender(ProgramSpec spec, Duration within, int interrupt) {
  spec.after_fork = [](char* const*) { setsid(); };
  const auto sender = ForkProgram(spec);
  if (!sender) return sender.error();
  const pid_t pid = sender.value().pid();
  const auto exit = OpenPidfd(pid);
  SendEnd end;
  const Time until = std::chrono::steady_clock::now() + within;
  pollfd waits[] = {{exit ? exit.value().get() : -1, POLLIN, 0}, {interrupt, POLLIN, 0}};
  for (int ready = -1; exit && ready < 0;) {
    const Duration left = std::max(until - std::chrono::steady_clock::now(), Duration::zero());
    const auto left_ms = std::chrono::ceil<std::chrono::milliseconds>(left).count();
    ready = poll(waits, std::size(waits), static_cast<int>(left_ms));
    if (ready < 0 && errno != EINTR) break;
    end.timed_out = ready == 0;
  }
  if (waits[0].revents == 0) {
    kill(-pid, SIGKILL);  // with ssh
    kill(pid, SIGKILL);
  }
  end.failure = sender.value().Failure(Duration::zero());
  end.status = ReapChild(pid).value_or(ExitStatus::Unknown());
  if (!exit) return exit.error();
  return end;
}

// Empty: it was sent.
std::string SendTo(const HostFiles& files, const std::string& folder, int interrupt) {
  const HostConfig& host = *files.host;
  const std::string to = ShellWord(IncomingFolder(files.root));
  ProgramSpec spec;
  spec.argv = {"sh", "-c", "tar -C \"$0\" -cf - . | \"$@\"", folder + "/sent"};
  for (std::string& word : SshArguments(host)) spec.argv.push_back(std::move(word));
  spec.argv.push_back("exec sh -c " +
                      ShellWord("rm -rf " + to + " && mkdir -p " + to + " && chmod 700 " + to +
                                " && exec tar -xpof - -C " + to));
  spec.env = {{"LC_ALL", "C"}};
  spec.without = {"SSH_ASKPASS"};
  const std::string said = folder + "/said";
  const UniqueFd output(open(said.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  if (!output.valid()) return OnHost(host) + SystemError("can't write " + said).message;
  spec.output = spec.errors = output.get();
  const auto run = RunSender(spec, kSendWithin, interrupt);
  if (!run) return OnHost(host) + run.error().message;
  const SendEnd& end = run.value();
  if (end.failure) return OnHost(host) + end.failure->error.message;
  if (end.timed_out) {
    return OnHost(host) + fmt::format("its files were not sent within {} min",
                                      ToMilliseconds(kSendWithin) / 60'000);
  }
  if (end.status.ok()) return {};
  std::string why = LastLineOf(ReadFile(said));
  if (why.empty()) why = "the files were not sent: " + end.status.Text();
  const bool of_ssh = !end.status.killed && end.status.number == kSshFailed;
  return OnHost(host) + (of_ssh ? SshTroubleOf(why, host.Login()).text : why);
}

constexpr std::string_view kStepExit = "musher-exit ";

struct StepAnswer {
  std::string trouble;   // with its host; empty: the step was done
  bool unknown = false;  // whether it was done
  std::string said;      // by a step that was done, in its last line
};

// A step of host_slot.hpp on each of these hosts, at the same time.
std::vector<StepAnswer> TakeOn(const std::vector<const HostFiles*>& hosts, const std::string& step,
                               const DeployOptions& options, Duration within, int interrupt = -1) {
  std::vector<HostQuery> queries;
  for (const HostFiles* files : hosts) {
    std::string command = "musher deploy --step " + step + " --root " + ShellWord(files->root) +
                          " --version " + ShellWord(options.version.text);
    if (options.install.allow_downgrade) command += " --allow-downgrade";
    queries.push_back(
        {files->host, command + " 2>&1 </dev/null\necho \"" + std::string(kStepExit) + "$?\"\n"});
  }
  std::vector<StepAnswer> taken;
  for (const HostAnswer& answer : QueryHosts(queries, within, interrupt)) {
    const HostConfig& host = *queries[taken.size()].host;
    StepAnswer& one = taken.emplace_back();
    const std::string end = answer.lines.empty() ? "" : answer.lines.back();
    if (!answer.trouble.empty() || !end.starts_with(kStepExit)) {
      one.unknown = true;
      one.trouble = answer.trouble.empty()
                        ? OnHost(host) + "it does not say how `" + step + "` ended"
                        : answer.trouble;
    } else if (end != std::string(kStepExit) + "0") {
      std::string why = answer.lines.size() < 2 ? end : answer.lines[answer.lines.size() - 2];
      constexpr std::string_view kProgram = "musher: ";
      if (why.starts_with(kProgram)) why.erase(0, kProgram.size());
      one.trouble = OnHost(host) + why;
    } else if (answer.lines.size() > 1) {
      one.said = answer.lines[answer.lines.size() - 2];
    }
  }
  return taken;
}

std::vector<std::string> TroublesOf(const std::vector<StepAnswer>& answers) {
  std::vector<std::string> troubles;
  for (const StepAnswer& answer : answers) {
    if (!answer.trouble.empty()) troubles.push_back(answer.trouble);
  }
  return troubles;
}

std::vector<std::string> LookAt(const DeployPlan& plan, int interrupt) {
  std::vector<HostQuery> queries;
  for (const HostFiles& files : plan.hosts) {
    queries.push_back({files.host, LookScript(files.root)});
  }
  const std::vector<HostAnswer> answers = QueryHosts(queries, kLookWithin, interrupt);
  std::vector<std::string> troubles;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    if (!answers[i].trouble.empty()) {
      troubles.push_back(answers[i].trouble);
    } else if (const std::string why = Misfit(plan.hosts[i], answers[i].lines); !why.empty()) {
      troubles.push_back(OnHost(*plan.hosts[i].host) + why);
    }
  }
  return troubles;
}

// What is still to be done on which hosts.
struct Needs {
  std::vector<const HostFiles*> send;       // and stage
  std::vector<const HostFiles*> switch_to;  // these, and those that have staged it already
};

// Adds a host to what it needs, or to those that have the version. The trouble, or "".
std::string AddHost(const HostFiles& files, const PlacedVersion& placed,
                    const DeployOptions& options, Needs& needs, DeployOutcome& outcome) {
  if (placed.place != Place::kNowhere) {
    const TemporaryFolder folder;
    if (folder.path().empty()) return kNoTemporaryFolder;
    const auto made = MakeBundleOf(files, options, folder.path());
    if (!made) return OnHost(*files.host) + made.error().message;
    const bool same = placed.digest == ContentDigest(made.value());
    if (same && placed.place == Place::kStaged) {
      needs.switch_to.push_back(&files);
      return {};
    }
    if (same) {
      outcome.had.insert(files.host->name);
      return {};
    }
    if (placed.place == Place::kRuns) {
      return OnHost(*files.host) + "it is the same version with other files: it has " +
             options.version.text + " in " + files.root + "; give these a newer version";
    }
  }
  needs.send.push_back(&files);
  needs.switch_to.push_back(&files);
  return {};
}

// One host was not switched, or it is not known: none is to be. Also one that refused the switch:
// its state may be of the new version, and its link of the old one.
DeployOutcome Undo(const std::vector<const HostFiles*>& hosts,
                   const std::vector<StepAnswer>& switched, const DeployOptions& options) {
  DeployOutcome outcome;
  outcome.troubles = TroublesOf(switched);
  const std::vector<StepAnswer> undone = TakeOn(hosts, "undo", options, kUndoWithin);
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    if (undone[i].trouble.empty()) continue;
    outcome.unknown = true;
    outcome.troubles.push_back(undone[i].trouble + "; it may run version " + options.version.text +
                               " now: once it is reached, run `ssh " + hosts[i]->host->Login() +
                               " musher deploy --step undo --root " +
                               ShellWord(ShellWord(hosts[i]->root)) + " --version " +
                               options.version.text + "`");
  }
  return outcome;
}

DeployOutcome Interrupted() {
  return {
      {"interrupted; a host that was sent a version may go on with it for a while, unseen: repeat "
       "`musher deploy` after that"},
      /*unknown=*/false,
      /*interrupted=*/true};
}

// Sends the files to those hosts that need them, and has them staged. Empty troubles: it is done.
DeployOutcome SendAndStage(const std::vector<const HostFiles*>& hosts, const DeployOptions& options,
                           const std::function<void(const std::string&)>& progress) {
  for (const HostFiles* files : hosts) {
    progress("send to " + files->host->name);
    const TemporaryFolder folder;
    if (folder.path().empty()) return {{kNoTemporaryFolder}};
    const auto made = MakeBundleOf(*files, options, folder.path());
    if (IsInterrupted(options)) return Interrupted();
    if (!made) {
      return {{OnHost(*files->host) + made.error().message}};
    }
    const std::string trouble = SendTo(*files, folder.path(), options.interrupt);
    if (IsInterrupted(options)) return Interrupted();
    if (!trouble.empty()) return {{trouble}};
  }
  if (hosts.empty()) return {};
  progress("stage");
  const auto staged = TakeOn(hosts, "stage", options, kStageWithin, options.interrupt);
  if (IsInterrupted(options)) return Interrupted();
  return {TroublesOf(staged)};
}

}  // namespace

DeployOutcome Deploy(const DeployPlan& plan, const DeployOptions& options,
                     const std::function<void(const std::string&)>& progress) {
  std::vector<const HostFiles*> hosts;
  for (const HostFiles& files : plan.hosts) hosts.push_back(&files);
  progress("look");
  auto misfits = LookAt(plan, options.interrupt);
  if (IsInterrupted(options)) return Interrupted();
  if (!misfits.empty()) return {misfits};
  const auto found = TakeOn(hosts, "look", options, kStageWithin, options.interrupt);
  if (IsInterrupted(options)) return Interrupted();
  DeployOutcome outcome;
  outcome.troubles = TroublesOf(found);
  if (!outcome.troubles.empty()) return outcome;
  Needs needs;
  for (std::size_t i = 0; i < hosts.size(); ++i) {
    std::string trouble = AddHost(*hosts[i], ParsePlaced(found[i].said), options, needs, outcome);
    if (IsInterrupted(options)) return Interrupted();
    if (!trouble.empty()) outcome.troubles.push_back(std::move(trouble));
  }
  if (!outcome.troubles.empty() || needs.switch_to.empty()) return outcome;
  DeployOutcome done = SendAndStage(needs.send, options, progress);
  if (done.troubles.empty()) {
    progress("switch");
    const auto switched = TakeOn(needs.switch_to, "switch", options, kSwitchWithin);
    if (!TroublesOf(switched).empty()) done = Undo(needs.switch_to, switched, options);
  }
  done.had = outcome.had;
  return done;
}

}  // namespace musher::cli
