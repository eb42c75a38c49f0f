// musher new module|app|robot NAME: a project that builds and passes its own test, from the
// templates of the installation. musher new ros2 PARAMS: a config from nav2's parameters.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "musher/base/code.hpp"
#include "musher/base/files.hpp"
#include "musher/base/program_path.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/commands/new_project.hpp"
#include "musher/cli/commands/new_project_text.hpp"
#include "musher/cli/console/json_line.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/nav2/nav2_config.hpp"

namespace musher::cli {
namespace {

struct NewOptions {
  std::string name;
  std::string folder;  // empty: the name
  std::string language = "cpp";
};

ExitCode Make(const std::string& kind, const NewOptions& options, Console& console) {
  const Project project{kind, kind == "robot" ? "" : options.language};
  const auto name = ProjectName::From(options.name, project);
  if (!name) return console.Fail(name.error());
  const auto program = OwnProgram();
  const auto templates = TemplatesFolder(program);
  if (templates.empty()) {
    return console.Fail(Error{kCodeFailed,
                              "no templates in share/musher/examples beside the folder "
                              "of " +
                                  program.string() + "; install Musher again"});
  }
  std::filesystem::path folder = options.folder.empty() ? name.value().snake : options.folder;
  folder = folder.lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();  // "arm/"
  const auto files = MakeProject(templates, project, name.value(), folder);
  if (!files) return console.Fail(files.error());
  console.Print(console.mode().json
                    ? NewProjectJson(project, name.value(), folder.string(), files.value())
                    : NewProjectText(project, name.value(), folder.string(), files.value()));
  return ExitCode::kDone;
}

ExitCode NewModule(const NewOptions& options, const GlobalOptions& /*global*/, Console& console) {
  return Make("module", options, console);
}
ExitCode NewApp(const NewOptions& options, const GlobalOptions& /*global*/, Console& console) {
  return Make("app", options, console);
}
ExitCode NewRobot(const NewOptions& options, const GlobalOptions& /*global*/, Console& console) {
  return Make("robot", options, console);
}

void AddKind(Grammar& grammar, CLI::App& family, const char* kind, const char* what,
             ExitCode (*run)(const NewOptions&, const GlobalOptions&, Console&)) {
  auto [app, options] = grammar.Add(kind, what, run, &family);
  app.add_option("NAME", options.name, "left_arm or LeftArm: letters, digits and '_'")
      ->required()
      ->type_name("");
  if (std::string_view(kind) != "robot") {
    grammar.OneOf(app.add_option("--language", options.language, "Default cpp"), {"cpp", "python"})
        ->type_name("LANGUAGE");
  }
  grammar
      .Offer(app.add_option("--folder", options.folder, "The folder to make; default NAME, here"),
             Names::kFolders)
      ->type_name("FOLDER");
}

struct Ros2Options {
  std::vector<std::string> params;
  std::string output = "robot.toml";
};

// The config is a new file: an older one may have been edited.
ExitCode NewRos2(const Ros2Options& options, const GlobalOptions& /*global*/, Console& console) {
  std::vector<NamedText> files;
  for (const std::string& path : options.params) {
    std::string text = ReadFile(path);
    if (text.empty()) {
      return console.Fail(
          Error{kCodeParametersInvalid, path + " cannot be read, or has no parameters"});
    }
    files.push_back({path, std::move(text)});
  }
  const auto config = Nav2Config(files, std::filesystem::path(options.output).stem());
  if (!config) return console.Fail(config.error());
  if (std::filesystem::exists(std::filesystem::symlink_status(options.output))) {
    return console.Fail(
        Error{kCodeParametersInvalid, options.output + " exists already; choose another --output"});
  }
  if (auto written = ReplaceFile(options.output, config.value()); !written) {
    return console.Fail(written.error());
  }
  console.Print(console.mode().json ? JsonLine({{"config", options.output}})
                                    : options.output +
                                          " is made: read its comments, then `musher "
                                          "check " +
                                          options.output + "`\n");
  return ExitCode::kDone;
}

void AddRos2(Grammar& grammar, CLI::App& family) {
  auto [app, options] = grammar.Add(
      "ros2", "A state config from the parameter files of a nav2 stack", NewRos2, &family);
  grammar.Offer(app.add_option("PARAMS", options.params, "nav2_params.yaml, ..."), Names::kFiles)
      ->required()
      ->type_name("");
  grammar
      .Offer(app.add_option("--output", options.output, "The new file; default robot.toml"),
             Names::kFiles)
      ->type_name("FILE");
}

}  // namespace

void AddNew(Grammar& grammar) {
  CLI::App& family = grammar.AddFamily("new", "Make a project that builds and passes its own test",
                                       "musher new module gripper --language python");
  AddKind(grammar, family, "module", "An actuator: a class with a callback for each state",
          NewModule);
  AddKind(grammar, family, "app", "An application: a state machine that is an actuator", NewApp);
  AddKind(grammar, family, "robot", "A state config that starts at once, without a program",
          NewRobot);
  AddRos2(grammar, family);
}

}  // namespace musher::cli
