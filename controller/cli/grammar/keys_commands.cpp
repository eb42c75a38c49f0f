// musher keys.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddKeysCommands() {
  CLI::App* keys = AddFamily("keys", "Create and revoke the credentials of processes");
  const auto add_days = [](CLI::App* command, int& days) {
    command->add_option("--days", days, "Days that a certificate is valid; default 730")
        ->check(CLI::Range(1, 3650).description(""))
        ->type_name("N");
  };

  auto init = std::make_shared<KeysInitOptions>();
  auto* command = AddSubcommand(*keys, "init", "Create a machine's CAs and first identities", init);
  Offer(command->add_option("WHERE", init->where,
                            "A state config with [security]: for the controller,\n"
                            "the operator and all its actuators; or a folder"),
        Names::kConfigs)
      ->required()
      ->type_name("");
  add_days(command, init->days);
  command->add_flag("--signed-only", init->signed_only,
                    "Sign data but do not encrypt it; default: both");
  command->add_flag("--force", init->force, "Replace existing ones");

  auto add = std::make_shared<KeysAddOptions>();
  command = AddSubcommand(*keys, "add", "Create one more identity", add);
  Offer(command->add_option("NAME", add->name, "Name of an actuator or a person"),
        Names::kActuators)
      ->required()
      ->type_name("");
  OneOf(command->add_option("--role", add->role, "Its permissions; default actuator"),
        {"controller", "actuator", "operator", "observer"});
  add_days(command, add->days);
  command->add_flag("--force", add->force, "Replace it and revoke the previous one");

  auto revoke = std::make_shared<KeysRevokeOptions>();
  command = AddSubcommand(*keys, "revoke", "Revoke an identity's certificate", revoke);
  command->add_option("NAME", revoke->name, "Name of the identity")->required()->type_name("");

  AddSubcommand(*keys, "list", "Show identities, their roles and expiry dates",
                std::make_shared<KeysListOptions>());
}

}  // namespace musher::cli
