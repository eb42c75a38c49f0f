// Commands that start a machine and end it.

#include <CLI/CLI.hpp>
#include <memory>
#include <vector>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddRunCommands() {
  group_ = "Start and stop";
  auto up = std::make_shared<UpOptions>();
  auto* command = AddCommand("up", "Start a machine and stay with it; Ctrl-C takes it down", up);
  Offer(command->add_option("FILE", up->file,
                            "State config (TOML), or a folder with upgrades as\n"
                            "`musher ota init` makes it"),
        Names::kConfigs)
      ->required()
      ->type_name("");
  command->add_flag("-d,--detach", up->detach,
                    "Return when the start has ended; the machine stays up");
  command->add_flag("--takeover", up->takeover,
                    "End a controller that leads this machine; its actuators\n"
                    "go on and are taken over");
  command->add_flag("--adopt", up->adopt,
                    "Take over actuators that run already with another config;\n"
                    "without it they are a reason not to start");
  command->add_flag("--restarted", up->restarted,
                    "For supervisors such as systemd: if the controller ended\n"
                    "while it took the machine down, finish that and stay down");
  // How a controller executes this program when it starts again; for no other use.
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
  command = AddCommand("down", "Take the machine down: TearDown, then end its processes", down);
  command->add_flag("--without-controller", down->without_controller,
                    "End the actuators of the namespace that run though no\n"
                    "controller leads them, all at the same time");

  AddCommand("poweroff", "Take the machine down and the robot's power off",
             std::make_shared<PowerOffOptions>());
  AddCommand("reboot", "Take the machine down and reboot the robot",
             std::make_shared<RebootOptions>());
}

}  // namespace musher::cli
