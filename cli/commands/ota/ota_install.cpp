// musher ota install|rollback: writes another version into the unused slot, trial-boots it, and
// rolls back if that fails. This process handles the files and can be killed at any time; the
// controller handles the machine, on request.

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <csignal>

#include "musher/base/words.hpp"
#include "musher/cli/commands/ota/ota_commands.hpp"
#include "musher/cli/commands/ota/ota_progress.hpp"
#include "musher/cli/commands/ota/ota_root.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/lifecycle/config/config_toml.hpp"
#include "musher/ota/fault.hpp"
#include "musher/ota/install.hpp"
#include "musher/ota/install_flow.hpp"
#include "musher/ota/posix_disk.hpp"

namespace musher::cli {
namespace {

struct OtaInstallOptions {
  std::string bundle;
  std::string root;
  bool allow_downgrade = false;
};

struct OtaRollbackOptions {
  std::string root;
};

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
    // Checked before the robot lies down: there may be no version to roll back to.
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
    return PrintResult(flow);
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
    // Checked before the robot lies down: the config may have an error.
    const std::string file = bundle_ + "/" + ota::kPayload + "/" + root_.config().config;
    ConfigReading reading = ReadConfigFile(file);
    if (reading.config) {
      if (auto fault = UpgradeFault(*reading.config))
        return FaultError(ota::Fault::kBadManifest, *fault);
      if (RulesBelow(*reading.config, bundle_ + "/" + ota::kPayload).empty()) return Ok();
      reading.diagnostics = RulesOf(*reading.config).diagnostics;
      if (reading.diagnostics.empty()) return Ok();
    }
    std::string message = "its state config is invalid";
    for (const Diagnostic& diagnostic : reading.diagnostics) {
      if (diagnostic.severity != Severity::kError) continue;
      message += ": " + FormatDiagnostic(diagnostic);
      break;
    }
    return FaultError(ota::Fault::kBadManifest, message);
  }

  Result<> MarkTrialBoot() {
    if (installation_) return installation_->MarkTrialBoot();
    auto version = ota::MarkRollback(root_, running());
    if (!version) return version.error();
    version_ = version.value().text;
    return Ok();
  }

  ExitCode PrintResult(const Flow& flow) {
    if (flow.afterwards) {
      console_.PrintError("the machine stays in OTA: " + flow.afterwards->message);
    }
    if (flow.failure) return PrintFailure(*flow.failure);
    const bool kept = machine_ != nullptr;
    console_.Print(console_.mode().json ? OtaResultJson(version_, kept ? "kept" : "waiting", "")
                   : kept
                       ? "version " + version_ + " runs and is kept"
                       : "version " + version_ + " is trial-booted at the next start: musher up " +
                             ShellWord(root_.path()));
    return ExitCode::kDone;
  }

  ExitCode PrintFailure(const Error& failure) {
    const bool interrupted = machine_ && machine_->Interrupted();
    const ExitCode exit = interrupted ? ExitCode::kInterrupted : ExitCode::kNotDone;
    if (!ota::Is(failure, ota::Fault::kRolledBack)) return console_.Fail({exit, failure});
    if (console_.mode().json) {
      console_.Print(OtaResultJson(version_, "rolled_back", failure.message));
    }
    console_.PrintError("version " + version_ +
                        " failed, the robot has rolled back: " + failure.message);
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

// Finds the root and its machine and runs `work` with them.
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

ExitCode OtaInstall(const OtaInstallOptions& options, const GlobalOptions& global,
                    Console& console) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit counts as a full disk
  return WithRoot(options.root, global, console, [&](Upgrade& upgrade) {
    return upgrade.Install(options.bundle, {options.allow_downgrade});
  });
}

ExitCode OtaRollback(const OtaRollbackOptions& options, const GlobalOptions& global,
                     Console& console) {
  return WithRoot(options.root, global, console,
                  [](Upgrade& upgrade) { return upgrade.Rollback(); });
}

}  // namespace

void AddOtaInstall(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add(
      "install", "Install a bundle, trial-boot it, keep it or roll back", OtaInstall, &family);
  AddBundle(grammar, app, options.bundle);
  AddRoot(grammar, app, options.root);
  app.add_flag("--allow-downgrade", options.allow_downgrade, "Accept an older version, too");
}

void AddOtaRollback(Grammar& grammar, CLI::App& family) {
  auto [app, options] =
      grammar.Add("rollback", "Roll back to the previous version", OtaRollback, &family);
  AddRoot(grammar, app, options.root);
}

}  // namespace musher::cli
