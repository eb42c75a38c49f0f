// musher keys.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {

void Grammar::AddKeysCommands() {
  CLI::App* keys = AddFamily("keys", "Make and revoke the keys that let a process in");
  const auto add_days = [](CLI::App* command, int& days) {
    command->add_option("--days", days, "How long certificates are valid; default 730")
        ->check(CLI::Range(1, 3650).description(""))
        ->type_name("N");
  };

  auto init = std::make_shared<KeysInitOptions>();
  auto* command = AddSubcommand(*keys, "init", "Make a machine's CAs and first identities", init);
  Offer(command->add_option("WHERE", init->where,
                            "A state config with [security]: for the controller,\n"
                            "the operator and all its actuators; or a folder"),
        Names::kConfigs)
      ->required()
      ->type_name("");
  add_days(command, init->days);
  command->add_flag("--signed-only", init->signed_only,
                    "Data can be read on the network, not forged;\ndefault: encrypted, too");
  command->add_flag("--force", init->force, "Replace those that are there");

  auto add = std::make_shared<KeysAddOptions>();
  command = AddSubcommand(*keys, "add", "Make one more identity", add);
  Offer(command->add_option("NAME", add->name, "An actuator's, or a person's"), Names::kActuators)
      ->required()
      ->type_name("");
  OneOf(command->add_option("--role", add->role, "What it may do; default actuator"),
        {"controller", "actuator", "operator", "observer"});
  add_days(command, add->days);
  command->add_flag("--force", add->force, "Replace it, and revoke the one before");

  auto revoke = std::make_shared<KeysRevokeOptions>();
  command = AddSubcommand(*keys, "revoke", "Let an identity in no more", revoke);
  command->add_option("NAME", revoke->name, "Whose certificate")->required()->type_name("");

  AddSubcommand(*keys, "list", "Show who has keys, as what, until when",
                std::make_shared<KeysListOptions>());
}

}  // namespace musher::cli
