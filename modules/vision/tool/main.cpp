// musher-vision: shows what the detector finds. See README.md one folder above.

#include <CLI/CLI.hpp>
#include <iostream>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/actuator/program/module_main.hpp"
#include "musher/base/version.hpp"
#include "musher/modules/vision/tool/look.hpp"

namespace {

using musher::program::ExitCode;

constexpr const char* kFooter = R"(
Examples:
  musher-vision look faces.toml now.png --out boxes.png     what is found, and where
  musher-vision look faces.toml now.png --hfov 70 --at 1.5  the face_m that makes the distance right

Exit codes: 0 done; 1 a picture or the model cannot be read, or --out not written; 2 wrong usage, or
the config is wrong.)";

ExitCode Look(const musher::vision::tool::LookOptions& options) {
  const musher::vision::VisionReading reading = musher::vision::ReadVisionFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return ExitCode::kUsage;
  const musher::Result<> looked = musher::vision::tool::Look(*reading.config, options, std::cout);
  if (looked) return ExitCode::kDone;
  std::cerr << "musher-vision: " << looked.error().message << std::endl;
  return ExitCode::kNotDone;
}

}  // namespace

int main(int argc, char** argv) {
  musher::vision::tool::LookOptions options;
  CLI::App app("Shows what the detector of musher-vision-manager finds.", "musher-vision");
  app.footer(kFooter);
  app.set_version_flag("--version", "musher-vision " + std::string(musher::Version()),
                       "Print the version");
  app.require_subcommand(1);
  CLI::App* look = app.add_subcommand("look", "Look for faces in pictures");
  look->add_option("FILE", options.file, "The config of musher-vision-manager (TOML)")->required();
  look->add_option("PICTURES", options.pictures, "Files: .png, .jpg, .bmp")->required();
  look->add_option("--out", options.out, "Write the (last) picture with boxes to this file");
  look->add_option("--hfov", options.hfov_deg, "Degrees from its left edge to its right one")
      ->check(musher::program::Between(1, 170));
  look->add_option("--at", options.at_m,
                   "Distance of the largest face in m; prints the face_m that fits")
      ->check(musher::program::Between(0.05, 100));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::kUsage);
  }
  return static_cast<int>(Look(options));
}
