// musher check FILE...: every fault of state configs. Touches no network.

#include "musher/controller/cli/commands.hpp"
#include "musher/controller/cli/program_check.hpp"
#include "musher/controller/cli/render/json.hpp"
#include "musher/controller/cli/render/text.hpp"
#include "musher/lifecycle/config_toml.hpp"

namespace musher::cli {

ExitCode Check(const CheckOptions& options, Console& console) {
  std::vector<Diagnostic> all;
  for (const std::string& file : options.files) {
    ConfigReading reading = ReadConfigFile(file);
    if (const auto& read = reading.config ? reading.config : reading.faulty) {
      const auto found = CheckPrograms(*read);
      reading.diagnostics.insert(reading.diagnostics.end(), found.begin(), found.end());
      if (HasError(found)) reading.config.reset();
    }
    all.insert(all.end(), reading.diagnostics.begin(), reading.diagnostics.end());
    if (console.mode().json) continue;
    std::string text;
    for (const Diagnostic& d : reading.diagnostics) text += Printable(FormatDiagnostic(d)) + '\n';
    const std::string of_file = options.files.size() > 1 ? Printable(file) + ": " : "";
    if (reading.config) text += of_file + "ok: " + ConfigSummary(*reading.config) + '\n';
    console.Print(text);
  }
  if (console.mode().json) console.Print(CheckJson(all));
  return HasError(all) ? ExitCode::kUsage : ExitCode::kDone;
}

}  // namespace musher::cli
