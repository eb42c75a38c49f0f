// musher doctor [CONFIG]: what of this computer keeps a robot from running well, and the commands
// that fix it. Changes nothing.

#include <CLI/CLI.hpp>
#include <filesystem>

#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/cli/doctor/read_facts.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/cli/render/doctor.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::cli {
namespace {

struct DoctorOptions {
  std::string file;  // empty: only the computer
};

ExitCode Doctor(const DoctorOptions& options, const GlobalOptions& global, Console& console) {
  std::optional<MachineConfig> config;
  if (!options.file.empty()) {
    config = LoadConfig(options.file, console);
    if (!config) return ExitCode::kUsage;
    if (const auto domain = transport::DomainId({})) TakeStateDir(*config, domain.value());
  }
  const std::vector<DoctorCheck> checks = Diagnose(ReadFacts(std::move(config), global));
  console.Print(console.mode().json ? DoctorJson(checks)
                                    : DoctorText(checks, console.mode().colour));
  return Worst(checks) == CheckStatus::kError ? ExitCode::kNotDone : ExitCode::kDone;
}

}  // namespace

void AddDoctor(Grammar& grammar) {
  auto [app, options] =
      grammar.Add("doctor", "Check this computer for what a robot needs, and show fixes", Doctor,
                  "musher doctor robot.toml");
  grammar
      .Offer(app.add_option("CONFIG", options.file,
                            "State config (TOML): also check its state folder,\n"
                            "programs and keys"),
             Names::kConfigs)
      ->type_name("");
}

}  // namespace musher::cli
