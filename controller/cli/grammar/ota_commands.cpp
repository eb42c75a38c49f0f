// musher ota.

#include <CLI/CLI.hpp>

#include "musher/controller/cli/grammar/grammar.hpp"

namespace musher::cli {
void Grammar::AddOtaCommands() {
  CLI::App* ota = AddFamily("ota", "Upgrade a robot; roll back if that fails");
  const auto add_root = [this](CLI::App* to, std::string& root) {
    Offer(to->add_option("--root", root,
                         "Upgrade root (folder of the robot's versions); default\n"
                         "$MUSHER_OTA_ROOT, else that of the running machine"),
          Names::kFolders)
        ->type_name("FOLDER");
  };
  const auto add_config = [this](CLI::App* to, std::string& config) {
    Offer(to->add_option("--config", config,
                         "The state config, relative to the folder of files;\n"
                         "default robot.toml"),
          Names::kFiles)
        ->type_name("FILE");
  };
  const auto add_bundle = [this](CLI::App* to, std::string& bundle) {
    Offer(to->add_option("BUNDLE", bundle, "A folder made by `musher ota bundle`"), Names::kFolders)
        ->required()
        ->type_name("");
  };

  auto keygen = std::make_shared<OtaKeygenOptions>();
  auto* command = AddSubcommand(*ota, "keygen", "Create the key pair that signs bundles", keygen);
  command
      ->add_option("NAME", keygen->name, "NAME.key stays with the signer, NAME.pub goes to robots")
      ->required()
      ->type_name("");

  auto bundle = std::make_shared<OtaBundleOptions>();
  command = AddSubcommand(*ota, "bundle", "Make a signed bundle from a folder of files", bundle);
  Offer(command->add_option("FOLDER", bundle->folder, "Programs in bin/, the state config, ..."),
        Names::kFolders)
      ->required()
      ->type_name("");
  command->add_option("--version", bundle->version, "MAJOR.MINOR.PATCH, as in 1.4.0")
      ->required()
      ->type_name("VERSION");
  command
      ->add_option("--min-version", bundle->min_version, "The oldest version that it can upgrade")
      ->type_name("VERSION");
  command->add_option("--robot", bundle->robot, "Name of its robot; default the machine's name")
      ->type_name("NAME");
  add_config(command, bundle->config);
  Offer(command->add_option("--key", bundle->key, "Private key"), Names::kFiles)
      ->required()
      ->type_name("FILE");
  Offer(command->add_option("-o,--out", bundle->out, "The bundle; a new folder"), Names::kFolders)
      ->required()
      ->type_name("FOLDER");

  auto init = std::make_shared<OtaInitOptions>();
  command = AddSubcommand(*ota, "init", "Make an upgrade root from a robot's first bundle", init);
  Offer(command->add_option("ROOT", init->root, "New folder, for `musher up ROOT`"),
        Names::kFolders)
      ->required()
      ->type_name("");
  Offer(command->add_option("--from", init->bundle, "The first bundle"), Names::kFolders)
      ->required()
      ->type_name("BUNDLE");
  Offer(command->add_option("--key", init->key, "Public key that verifies later bundles"),
        Names::kFiles)
      ->required()
      ->type_name("FILE");
  add_config(command, init->config);

  auto verify = std::make_shared<OtaVerifyOptions>();
  command = AddSubcommand(*ota, "verify", "Verify a bundle; changes nothing", verify);
  add_bundle(command, verify->bundle);
  Offer(command->add_option("--key", verify->key, "Public key; default the one of the root"),
        Names::kFiles)
      ->type_name("FILE");
  add_root(command, verify->root);

  auto install = std::make_shared<OtaInstallOptions>();
  command = AddSubcommand(*ota, "install", "Install a bundle, trial-boot it, keep it or roll back",
                          install);
  add_bundle(command, install->bundle);
  add_root(command, install->root);
  command->add_flag("--allow-downgrade", install->allow_downgrade, "Accept an older version, too");

  auto status = std::make_shared<OtaStatusOptions>();
  add_root(AddSubcommand(*ota, "status", "Show the versions of a robot", status), status->root);

  auto rollback = std::make_shared<OtaRollbackOptions>();
  add_root(AddSubcommand(*ota, "rollback", "Roll back to the previous version", rollback),
           rollback->root);
}

}  // namespace musher::cli
