// musher-vision: shows what the detector finds. See README.md one folder above.

#include <CLI/CLI.hpp>
#include <iostream>

#include "musher/actuator/program/command_line_tool.hpp"
#include "musher/actuator/program/module_main.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/base/version.hpp"
#include "musher/modules/vision/tool/look.hpp"
#include "musher/modules/vision/tool/look_course.hpp"
#include "musher/modules/vision/tool/tune.hpp"

namespace {

using musher::program::ExitCode;

constexpr const char* kFooter = R"(
Examples:
  musher-vision look faces.toml now.png --out boxes.png     what is found, and where
  musher-vision look faces.toml now.png --hfov 70 --at 1.5  the face_m that makes the distance right
  musher-vision look course.toml hall.mp4 --detector left   what a detector of [[detectors]] finds
  musher-vision tune course.toml hall/                      [hall] of a hall, from its pictures
  musher-vision tune course.toml hall/ --write              and changes course.toml so

Exit codes: 0 done; 1 a picture or the model cannot be read, or --out not written; 2 wrong usage, or
the config is wrong.)";

musher::Result<> LookFor(const musher::vision::VisionConfig& config,
                         const musher::vision::tool::LookOptions& options) {
  if (options.detector.empty()) return musher::vision::tool::Look(config, options, std::cout);
  const auto entry = musher::vision::tool::DetectorOf(config, options.detector);
  return musher::vision::tool::LookAtCourse(entry.value(), options, std::cout);
}

// Whether the config has what is to be found.
musher::Result<> CheckOptions(const musher::vision::VisionConfig& config,
                              const musher::vision::tool::LookOptions& options) {
  if (!options.detector.empty()) {
    const auto entry = musher::vision::tool::DetectorOf(config, options.detector);
    return entry ? musher::Ok() : musher::Result<>(entry.error());
  }
  if (config.detect_faces) return musher::Ok();
  return musher::Error{musher::kCodeFailed,
                       "the config detects no faces; name one of its detectors with --detector"};
}

ExitCode Look(const musher::vision::tool::LookOptions& options) {
  const musher::Parsed<musher::vision::VisionConfig> reading =
      musher::vision::ReadVisionFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return ExitCode::kUsage;
  if (const musher::Result<> known = CheckOptions(*reading.config, options); !known) {
    std::cerr << "musher-vision: " << known.error().message << std::endl;
    return ExitCode::kUsage;
  }
  const musher::Result<> looked = LookFor(*reading.config, options);
  if (looked) return ExitCode::kDone;
  std::cerr << "musher-vision: " << looked.error().message << std::endl;
  return ExitCode::kNotDone;
}

ExitCode Tune(const musher::vision::tool::TuneOptions& options) {
  const musher::Parsed<musher::vision::VisionConfig> reading =
      musher::vision::ReadVisionFile(options.file);
  musher::program::PrintErrors(reading.diagnostics);
  if (!reading.config) return ExitCode::kUsage;
  const musher::Result<> tuned = musher::vision::tool::Tune(*reading.config, options, std::cout);
  if (tuned) return ExitCode::kDone;
  std::cerr << "musher-vision: " << tuned.error().message << std::endl;
  return ExitCode::kNotDone;
}

}  // namespace

int main(int argc, char** argv) {
  musher::vision::tool::LookOptions options;
  CLI::App app("Shows what the detectors of musher-vision-manager find.", "musher-vision");
  app.footer(kFooter);
  app.set_version_flag("--version", "musher-vision " + std::string(musher::Version()),
                       "Print the version");
  app.require_subcommand(1);
  CLI::App* look =
      app.add_subcommand("look", "Look at pictures: for faces, or with a detector of a course");
  look->add_option("FILE", options.file, "The config of musher-vision-manager (TOML)")->required();
  look->add_option("PICTURES", options.pictures,
                   "Files: .png, .jpg, .bmp; with --detector also .mp4, .avi, .mkv")
      ->required();
  auto* detector =
      look->add_option("--detector", options.detector, "Name of a table [[detectors]]; else faces");
  look->add_option("--out", options.out,
                   "Write the (last) picture with what was found to this file");
  look->add_option("--hfov", options.hfov_deg, "Degrees from its left edge to its right one")
      ->check(musher::program::Between(1, 170));
  look->add_option("--at", options.at_m,
                   "Distance of the largest face in m; prints the face_m that fits")
      ->check(musher::program::Between(0.05, 100))
      ->excludes(detector);
  musher::vision::tool::TuneOptions to_tune;
  CLI::App* tune = app.add_subcommand("tune",
                                      "Find the colours, regions and white balance of a hall by "
                                      "pictures of it, "
                                      "front_lane-left-1.png: a detector, what it has to say");
  tune->add_option("FILE", to_tune.file, "The config of musher-vision-manager (TOML)")->required();
  tune->add_option("FOLDER", to_tune.folder, "The pictures: .png, .jpg, .bmp")->required();
  tune->add_flag("--write", to_tune.write,
                 "Change the table [hall] of FILE; its other lines stay, and what is replaced is "
                 "printed");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return musher::EndOfParse(app, error, static_cast<int>(ExitCode::kUsage));
  }
  return static_cast<int>(tune->parsed() ? Tune(to_tune) : Look(options));
}
