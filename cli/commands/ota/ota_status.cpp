// musher ota status: the versions of a robot and the outcome of the last trial boot.

#include <CLI/CLI.hpp>
#include "musher/cli/commands/ota/ota_commands.hpp"
#include "musher/cli/commands/ota/ota_root.hpp"
#include "musher/cli/console/table.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/ota/posix_disk.hpp"

namespace musher::cli {
namespace {

struct OtaStatusOptions {
  std::string root;
};

using ota::Slot;

// The role of a slot; a value of the JSON document, too.
std::string RoleOf(const ota::SlotState& state, Slot slot) {
  if (slot == state.confirmed) return "confirmed";
  if (state.on_trial_boot) return state.started ? "on trial" : "tried at the next start";
  return state.other_good ? "the one before" : "not used";
}

ExitCode OtaStatus(const OtaStatusOptions& options, const GlobalOptions& global, Console& console) {
  const auto path = FindRoot(options.root, global);
  if (!path) return console.Fail(path.error());
  ota::PosixDisk disk;
  const auto root = ota::Root::Open(disk, path.value());
  if (!root) return console.Fail(root.error());
  const auto state = root.value().State();
  if (!state) return console.Fail({ExitCode::kNotDone, state.error()});

  OtaRobot robot{root.value().config().robot,
                 path.value(),
                 ota::HolderOf(root.value().RunLock()),
                 state.value().last,
                 {}};
  for (const Slot slot : {Slot::kA, Slot::kB}) {
    const auto content = root.value().Look(slot);
    robot.slots.push_back({std::string(ota::SlotName(slot)), RoleOf(state.value(), slot),
                           content ? content.value().text : "",
                           content ? "" : content.error().message});
  }
  if (console.mode().json) {
    console.Print(OtaStatusJson(robot));
    return ExitCode::kDone;
  }
  console.Print(robot.robot + "  " + robot.root +
                (robot.pid == 0 ? "  (not running)" : "  controller " + std::to_string(robot.pid)));
  Table table({"SLOT", "VERSION", "ROLE", "NOTE"});
  const bool waits = state.value().on_trial_boot && !state.value().started && robot.pid != 0;
  for (OtaRobot::SlotInfo& slot : robot.slots) {
    const bool tried = slot.slot != ota::SlotName(state.value().confirmed);
    if (waits && tried && slot.fault.empty()) {
      slot.fault = "its trial boot waits for `musher down` and the next start";
    }
    const bool bad = slot.version.empty() && slot.role != "not used";
    table.Add({{slot.slot},
               {slot.version.empty() ? "-" : slot.version},
               {slot.role, slot.role == "confirmed" ? Style::kGood : Style::kPlain},
               {slot.fault, bad ? Style::kBad : Style::kDim}});
  }
  console.Print(table.Text(console.mode().colour));
  if (robot.last && !robot.last->kept) {
    console.Print("version " + robot.last->version + " failed: " + robot.last->reason);
  }
  return ExitCode::kDone;
}

}  // namespace

void AddOtaStatus(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add("status", "Show the versions of a robot", OtaStatus, &family);
  AddRoot(grammar, app, options.root);
}

}  // namespace musher::cli
