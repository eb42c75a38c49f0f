// Commands that start and stop a machine.

#include <CLI/CLI.hpp>
#include <memory>
#include <vector>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddRunCommands() {
  group_ = "Start and stop";
  auto up = std::make_shared<UpOptions>();
  auto* command =
      AddCommand("up", "Start a machine, stay in the foreground; Ctrl-C takes it down", up);
  Offer(command->add_option("FILE", up->file,
                            "State config (TOML), or an upgrade root made by\n"
                            "`musher ota init`"),
        Names::kConfigs)
      ->required()
      ->type_name("");
  command->add_flag("-d,--detach", up->detach,
                    "Return once start-up is complete; the machine stays up");
  command->add_flag("--takeover", up->takeover,
                    "Replace the controller that leads this machine; its\n"
                    "actuators keep running");
  command->add_flag("--adopt", up->adopt,
                    "Take control of actuators that already run with another\n"
                    "config; without it they block the start");
  command->add_flag("--restarted", up->restarted,
                    "For supervisors such as systemd: if the last controller\n"
                    "exited during TearDown, complete that and stay down");
  // For internal use: a controller that restarts executes this program with it.
  command
      ->add_option_function<std::vector<int>>(
          "--resume",
          [up](const std::vector<int>& values) {
            up->resume = UpOptions::Resume{values.at(0), values.at(1)};
          })
      ->expected(2)
      ->delimiter(',')
      ->group("");

  auto down = std::make_shared<DownOptions>();
  command = AddCommand("down", "Take the machine down: TearDown, then stop its processes", down);
  command->add_flag("--without-controller", down->without_controller,
                    "Stop the actuators of the namespace that run without a\n"
                    "controller, all at the same time");

  AddCommand("poweroff", "Take the machine down and power the robot off",
             std::make_shared<PowerOffOptions>());
  AddCommand("reboot", "Take the machine down and reboot the robot",
             std::make_shared<RebootOptions>());
}

}  // namespace musher::cli
