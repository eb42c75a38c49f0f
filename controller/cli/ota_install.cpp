// musher ota install|rollback: another version into the slot that is not used, a trial boot of it,
// and back where it fails. The files are this process's work, which can be killed at any time; the
// machine is the controller's, which is only asked.

#include <fmt/format.h>

#include <csignal>

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/ota_progress.hpp"
#include "musher/controller/cli/ota_root.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/ota/fault.hpp"
#include "musher/controller/ota/install.hpp"
#include "musher/controller/ota/install_flow.hpp"
#include "musher/controller/ota/posix_disk.hpp"
#include "musher/lifecycle/config_toml.hpp"

namespace musher::cli {
namespace {

using ota::Flow;
using ota::Step;

// An upgrade while it is under way.
class Upgrade {
 public:
  Upgrade(const ota::Root& root, std::unique_ptr<RootMachine> machine, Console& console)
      : root_(root), machine_(std::move(machine)), console_(console), progress_(console) {}

  std::optional<ota::Slot> running() const {
    return machine_ ? std::optional(machine_->slot()) : std::nullopt;
  }

  ExitCode Install(const std::string& bundle, ota::InstallOptions options) {
    auto installation = ota::Installation::Begin(root_, bundle, options, running());
    if (!installation) return console_.Fail({ExitCode::kNotDone, installation.error()});
    installation_.emplace(std::move(installation).value());
    bundle_ = bundle;
    return Run(ota::InstallFlow(machine_ != nullptr));
  }
  ExitCode Rollback() {
    // A robot does not have to lie down to learn that there is nothing to go back to.
    const auto version = ota::FindRollback(root_, running());
    if (!version) return console_.Fail({ExitCode::kNotDone, version.error()});
    return Run(ota::RollbackFlow(machine_ != nullptr));
  }

 private:
  ExitCode Run(Flow flow) {
    while (!flow.left.empty()) {
      const Step step = flow.left.front();
      progress_.Begin(ota::StepName(step), BytesOf(step));
      const auto outcome = Do(step);
      if (outcome) progress_.End();
      ota::Advance(flow, outcome);
    }
    return Tell(flow);
  }

  std::uint64_t BytesOf(Step step) const {
    if (!installation_) return 0;
    if (step == Step::kCheck) {
      const auto read = ota::ReadManifest(root_.disk(), bundle_, root_.public_key());
      return read ? read.value().manifest.SizeBytes() : 0;
    }
    const bool counts = step == Step::kCopy || step == Step::kCheckWritten;
    return counts ? installation_->manifest().SizeBytes() : 0;
  }

  Result<> Do(Step step) {
    const ota::OnBytes count = [this](std::uint64_t bytes) {
      progress_.Add(bytes);
      return !machine_ || !machine_->Interrupted();
    };
    switch (step) {
      case Step::kCheck:
        return Check(count);
      case Step::kEnterOta:
        return machine_->EnterOta();
      case Step::kPrepare:
        return installation_->Prepare();
      case Step::kCopy:
        return installation_->Copy(count);
      case Step::kCheckWritten:
        return installation_->CheckWritten(count);
      case Step::kMarkTrialBoot:
        return MarkTrialBoot();
      case Step::kStartAgain:
        return machine_->StartAgain();
      case Step::kTrialBoot:
        return machine_->AwaitTrialBoot();
      case Step::kLeaveOta:
        break;
    }
    return machine_->LeaveOta();
  }

  Result<> Check(const ota::OnBytes& count) {
    if (auto checked = installation_->Check(count); !checked) return checked;
    version_ = installation_->manifest().version.text;
    // A robot does not have to lie down to learn that a config has a slip.
    const std::string file = bundle_ + "/" + ota::kPayload + "/" + root_.config().config;
    const ConfigReading reading = ReadConfigFile(file);
    if (reading.config) {
      if (auto fault = UpgradeFault(*reading.config))
        return Refusal(ota::Fault::kBadManifest, *fault);
      return Ok();
    }
    std::string message = "its state config is faulty";
    for (const Diagnostic& diagnostic : reading.diagnostics) {
      if (diagnostic.severity != Severity::kError) continue;
      message += ": " + FormatDiagnostic(diagnostic);
      break;
    }
    return Refusal(ota::Fault::kBadManifest, message);
  }

  Result<> MarkTrialBoot() {
    if (installation_) return installation_->MarkTrialBoot();
    auto version = ota::MarkRollback(root_, running());
    if (!version) return version.error();
    version_ = version.value().text;
    return Ok();
  }

  ExitCode Tell(const Flow& flow) {
    if (flow.afterwards) {
      console_.Complain("the machine does not leave OTA: " + flow.afterwards->message);
    }
    if (flow.failure) return TellFailure(*flow.failure);
    const bool kept = machine_ != nullptr;
    console_.Print(console_.mode().json ? OtaResultJson(version_, kept ? "kept" : "waiting", "")
                   : kept               ? "version " + version_ + " runs, and is kept"
                          : "version " + version_ + " is tried at the next start: musher up " +
                                root_.path());
    return ExitCode::kDone;
  }

  ExitCode TellFailure(const Error& failure) {
    const bool interrupted = machine_ && machine_->Interrupted();
    const ExitCode exit = interrupted ? ExitCode::kInterrupted : ExitCode::kNotDone;
    if (!ota::Is(failure, ota::Fault::kGoneBack)) return console_.Fail({exit, failure});
    if (console_.mode().json) {
      console_.Print(OtaResultJson(version_, "gone back", failure.message));
    }
    console_.Complain("version " + version_ +
                      " is not kept, the robot has gone back: " + failure.message);
    return exit;
  }

  const ota::Root& root_;
  std::unique_ptr<RootMachine> machine_;
  Console& console_;
  OtaProgress progress_;
  std::string bundle_;
  std::string version_;
  std::optional<ota::Installation> installation_;
};

// Finds root and machine, and lets `work` do the rest.
ExitCode WithRoot(const std::string& option, const GlobalOptions& global, Console& console,
                  const std::function<ExitCode(Upgrade&)>& work) {
  const auto path = FindRoot(option, global);
  if (!path) return console.Fail(path.error());
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, path.value());
  if (!root) return console.Fail(root.error());
  auto machine = RootMachine::Find(root.value(), global);
  if (const auto* failure = std::get_if<Failure>(&machine)) return console.Fail(*failure);
  Upgrade upgrade(root.value(), std::get<std::unique_ptr<RootMachine>>(std::move(machine)),
                  console);
  return work(upgrade);
}

}  // namespace

ExitCode OtaInstall(const OtaInstallOptions& options, const GlobalOptions& global,
                    Console& console) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a disk that is full
  return WithRoot(options.root, global, console, [&](Upgrade& upgrade) {
    return upgrade.Install(options.bundle, {options.allow_downgrade});
  });
}

ExitCode OtaRollback(const OtaRollbackOptions& options, const GlobalOptions& global,
                     Console& console) {
  return WithRoot(options.root, global, console,
                  [](Upgrade& upgrade) { return upgrade.Rollback(); });
}

}  // namespace musher::cli
