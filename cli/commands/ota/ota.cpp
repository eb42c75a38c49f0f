// musher ota.

#include <CLI/CLI.hpp>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/ota/ota_commands.hpp"

namespace musher::cli {

void AddOta(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("ota", "Upgrade a robot; roll back if that fails",
                                       "musher ota install release-2");
  AddOtaKeygen(grammar, family);
  AddOtaBundle(grammar, family);
  AddOtaInit(grammar, family);
  AddOtaVerify(grammar, family);
  AddOtaInstall(grammar, family);
  AddOtaStatus(grammar, family);
  AddOtaRollback(grammar, family);
}

void AddRoot(Grammar& grammar, CLI::App& app, std::string& root) {
  grammar
      .Offer(app.add_option("--root", root,
                            "Upgrade root (folder of the robot's versions); default\n"
                            "$MUSHER_OTA_ROOT, else that of the running machine"),
             Names::kFolders)
      ->type_name("FOLDER");
}

void AddBundle(Grammar& grammar, CLI::App& app, std::string& bundle) {
  grammar
      .Offer(app.add_option("BUNDLE", bundle, "A folder made by `musher ota bundle`"),
             Names::kFolders)
      ->required()
      ->type_name("");
}

}  // namespace musher::cli
