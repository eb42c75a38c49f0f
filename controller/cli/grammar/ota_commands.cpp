// musher ota.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

void AddRoot(CLI::App* command, std::string& root) {
  command
      ->add_option("--root", root,
                   "Folder with the robot's versions; default\n"
                   "$MUSHER_OTA_ROOT, else that of the running machine")
      ->type_name("FOLDER");
}

void AddConfig(CLI::App* command, std::string& config) {
  command
      ->add_option("--config", config,
                   "The state config, relative to the folder of files;\ndefault robot.toml")
      ->type_name("FILE");
}

void AddBundleArgument(CLI::App* command, std::string& bundle) {
  command->add_option("BUNDLE", bundle, "A folder that `musher ota bundle` made")
      ->required()
      ->type_name("");
}

}  // namespace

void Grammar::AddOtaCommands() {
  CLI::App* ota = app_->add_subcommand("ota", "Upgrade a robot, and go back where that fails");
  ota->group("Commands");
  ota->require_subcommand(1);
  ota->footer(kCommandFooter);

  auto keygen = std::make_shared<OtaKeygenOptions>();
  auto* command =
      AddSubcommand(*ota, "keygen", "Make the keys that bundles are signed with", keygen);
  command
      ->add_option("NAME", keygen->name, "NAME.key stays with who signs, NAME.pub goes to robots")
      ->required()
      ->type_name("");

  auto bundle = std::make_shared<OtaBundleOptions>();
  command = AddSubcommand(*ota, "bundle", "Make a signed bundle of a folder of files", bundle);
  command->add_option("FOLDER", bundle->folder, "Its programs in bin/, its state config, ...")
      ->required()
      ->type_name("");
  command->add_option("--version", bundle->version, "MAJOR.MINOR.PATCH, as in 1.4.0")
      ->required()
      ->type_name("VERSION");
  command->add_option("--min-version", bundle->min_version, "The oldest version that it can follow")
      ->type_name("VERSION");
  command->add_option("--robot", bundle->robot, "For whom; default the machine's name")
      ->type_name("NAME");
  AddConfig(command, bundle->config);
  command->add_option("--key", bundle->key, "Private key")->required()->type_name("FILE");
  command->add_option("-o,--out", bundle->out, "The bundle; a new folder")
      ->required()
      ->type_name("FOLDER");

  auto init = std::make_shared<OtaInitOptions>();
  command = AddSubcommand(*ota, "init", "Make a robot's root from its first bundle", init);
  command->add_option("ROOT", init->root, "For `musher up ROOT`")->required()->type_name("");
  command->add_option("--from", init->bundle, "The first bundle")->required()->type_name("BUNDLE");
  command->add_option("--key", init->key, "Public key of later bundles")
      ->required()
      ->type_name("FILE");
  AddConfig(command, init->config);

  auto verify = std::make_shared<OtaVerifyOptions>();
  command = AddSubcommand(*ota, "verify", "Read all of a bundle, and change nothing", verify);
  AddBundleArgument(command, verify->bundle);
  command->add_option("--key", verify->key, "Public key; default that of the root")
      ->type_name("FILE");
  AddRoot(command, verify->root);

  auto install = std::make_shared<OtaInstallOptions>();
  command = AddSubcommand(*ota, "install", "Install a bundle, try it, keep it or go back", install);
  AddBundleArgument(command, install->bundle);
  AddRoot(command, install->root);
  command->add_flag("--allow-downgrade", install->allow_downgrade, "Take an older version, too");

  auto status = std::make_shared<OtaStatusOptions>();
  AddRoot(AddSubcommand(*ota, "status", "Show the versions of a robot", status), status->root);

  auto rollback = std::make_shared<OtaRollbackOptions>();
  AddRoot(AddSubcommand(*ota, "rollback", "Go back to the version before", rollback),
          rollback->root);
}

}  // namespace musher::cli
