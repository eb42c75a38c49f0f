#include "musher/cli/machine/silent_controller.hpp"

#include <fmt/format.h>

#include "musher/base/scheduling.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/controller/storage/machine_origin.hpp"

namespace musher::cli {

SilentController ExamineSilent(pid_t pid, const GlobalOptions& global) {
  SilentController controller{pid, RunStateOf(pid) == ProcessRunState::kStopped, std::nullopt, ""};
  if (const auto origin = OriginOfProcess(pid)) controller.file = origin->file;
  const auto found = FindMachineFiles("", global);
  const auto* files = std::get_if<MachineFiles>(&found);
  if (files != nullptr && files->led && files->config) {
    controller.security = !files->config->keys.empty();
  }
  return controller;
}

std::string WhySilent(const SilentController& controller, const GlobalOptions& global) {
  const std::string leads = fmt::format("process {} leads it on this host but ", controller.pid);
  const std::string replace =
      "`musher up " + (controller.file.empty() ? "FILE" : controller.file) + " --takeover`";
  if (controller.stopped) {
    return leads + fmt::format(
                       "does not answer: it is stopped; `kill -CONT {}` continues it, {} "
                       "replaces it",
                       controller.pid, replace);
  }
  const bool keys = !global.keys.empty();
  if (!keys && controller.security == true) {
    return leads + "is unreachable without keys: the machine has [security]; use --keys FOLDER";
  }
  if (keys && controller.security == false) {
    return leads +
           "is unreachable with keys: the machine has no [security]; leave --keys and "
           "MUSHER_KEYS out";
  }
  std::string why = leads +
                    "does not answer: it hangs, or uses another transport, network "
                    "interface or CYCLONEDDS_URI";
  if (keys) {
    why += fmt::format(", or the keys of {} in {} are not of its machine", global.identity,
                       global.keys);
  } else if (!controller.security) {
    why += ", or has [security] (--keys FOLDER)";
  }
  return why + "; `musher doctor` checks the network, " + replace + " replaces it";
}

}  // namespace musher::cli
