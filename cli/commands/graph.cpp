// musher graph FILE: draws the states or the actuators of a config, the state machine or behaviour
// tree of an application, a skill, or the behaviour tree of a file.

#include <CLI/CLI.hpp>
#include <filesystem>

#include "musher/base/files.hpp"
#include "musher/behavior/tree/xml/tree_xml.hpp"
#include "musher/cli/commands/commands.hpp"
#include "musher/cli/config/config_file.hpp"
#include "musher/cli/config/tree_file.hpp"
#include "musher/cli/grammar/grammar.hpp"
#include "musher/cli/machine/behavior_request.hpp"
#include "musher/cli/machine/skill_choice.hpp"
#include "musher/cli/machine/skill_offers.hpp"
#include "musher/cli/machine/skill_request.hpp"
#include "musher/cli/render/graph.hpp"
#include "musher/cli/render/json.hpp"
#include "musher/cli/render/svg.hpp"
#include "musher/cli/render/tree.hpp"

namespace musher::cli {
namespace {

struct GraphOptions {
  std::string file;           // empty: draw `behavior`, `tree` or `skill`
  std::string behavior;       // the application whose state machine is drawn
  std::string tree;           // the application whose behaviour tree is drawn, or a file
  std::string skill;          // the skill that is drawn
  std::string actuator;       // of `skill`; empty: the only one that offers it
  std::string what = "flow";  // or "actuators"
  std::string format;         // "dot", "mermaid" or "svg"
  std::string output;         // empty: standard output
};

Result<std::string> FormatOf(const GraphOptions& options) {
  if (!options.format.empty()) return options.format;
  const std::string end = std::filesystem::path(options.output).extension();
  if (end == ".svg") return std::string("svg");
  if (end == ".mmd" || end == ".mermaid") return std::string("mermaid");
  if (end.empty() || end == ".dot" || end == ".gv") return std::string("dot");
  return Error{kCodeParametersInvalid,
               options.output + ": unknown graph format; expected .dot, .gv, .mmd, .mermaid or " +
                   ".svg, or --format"};
}

Result<std::string> Draw(const MachineConfig& config, const std::string& what,
                         const std::string& format) {
  const bool flow = what == "flow";
  if (format == "mermaid") return flow ? FlowMermaid(config) : ActuatorsMermaid(config);
  const std::string dot = flow ? FlowDot(config) : ActuatorsDot(config);
  return format == "svg" ? RenderSvg(dot) : Result<std::string>(dot);
}

using Drawing = std::variant<std::string, Failure>;

Drawing OrFailure(Result<std::string> drawing) {
  if (!drawing) return Failure{ExitCode::kUsage, drawing.error()};
  return std::move(drawing).value();
}

Drawing DrawBehavior(const std::string& name, const std::string& format,
                     const GlobalOptions& global) {
  const auto link = Link::Open(global);
  if (!link) return Failure{ExitCode::kUsage, link.error()};
  const bool svg = format == "svg";
  auto answer = QueryBehavior(*link.value(), global, name, {svg ? "dot" : format, 0});
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  std::string graph = std::move(std::get<msg::GetBehavior::Response>(answer).graph);
  return svg ? OrFailure(RenderSvg(graph)) : Drawing(std::move(graph));
}

Drawing DrawTree(const std::string& name, const std::string& format,
                 const msg::GetTree::Response& report) {
  if (format == "mermaid") return TreeMermaid(report);
  const std::string dot = TreeDot(name, report);
  return format == "svg" ? OrFailure(RenderSvg(dot)) : Drawing(dot);
}

Drawing DrawRunningTree(const std::string& name, const std::string& format,
                        const GlobalOptions& global) {
  const auto link = Link::Open(global);
  if (!link) return Failure{ExitCode::kUsage, link.error()};
  const auto answer = QueryTree(*link.value(), global, name, {"", 0, false});
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  return DrawTree(name, format, std::get<msg::GetTree::Response>(answer));
}

bool IsTreeFile(const std::string& file) {
  return std::filesystem::path(file).extension() == ".xml";
}

Drawing DrawTreeFile(const std::string& file, const std::string& format, Console& console) {
  const tree::Reading reading = tree::ReadTreeFile(file);
  for (const Diagnostic& each : reading.diagnostics) console.Note(FormatDiagnostic(each));
  if (!reading.ok()) {
    return Failure{ExitCode::kUsage, {kCodeParametersInvalid, file + " is not a valid tree"}};
  }
  const auto nodes = NodesOf(reading.document, "");
  if (!nodes)
    return Failure{ExitCode::kUsage, {nodes.error().code, file + ": " + nodes.error().message}};
  msg::GetTree::Response report;
  for (const FileNode& one : nodes.value()) report.nodes.push_back(one.node);
  return DrawTree(std::filesystem::path(file).stem(), format, report);
}

Drawing DrawSkill(const GraphOptions& options, const std::string& format,
                  const GlobalOptions& global) {
  const auto link = Link::Open(global);
  if (!link) return Failure{ExitCode::kUsage, link.error()};
  const auto offers = SkillOffers::Begin(*link.value(), global);
  if (!offers) return Failure{ExitCode::kUsage, offers.error()};
  if (auto failure = offers.value()->Await(options.actuator)) return *std::move(failure);
  const auto skill = ChooseSkill(offers.value()->all(), options.skill, options.actuator);
  if (!skill) return Failure{ExitCode::kNotDone, skill.error()};
  const bool svg = format == "svg";
  auto answer = QuerySkill(*link.value(), global, skill.value().actuator,
                           {options.skill, svg ? "dot" : format});
  if (const auto* failure = std::get_if<Failure>(&answer)) return *failure;
  std::string graph = std::move(std::get<msg::GetSkill::Response>(answer).graph);
  return svg ? OrFailure(RenderSvg(graph)) : Drawing(std::move(graph));
}

ExitCode Graph(const GraphOptions& options, const GlobalOptions& global, Console& console) {
  const Result<std::string> known = FormatOf(options);
  if (!known) return console.Fail(known.error());
  const std::string& format = known.value();
  Drawing drawn;
  if (!options.behavior.empty()) {
    drawn = DrawBehavior(options.behavior, format, global);
  } else if (!options.skill.empty()) {
    drawn = DrawSkill(options, format, global);
  } else if (IsTreeFile(options.tree.empty() ? options.file : options.tree)) {
    drawn = DrawTreeFile(options.tree.empty() ? options.file : options.tree, format, console);
  } else if (!options.tree.empty()) {
    drawn = DrawRunningTree(options.tree, format, global);
  } else if (options.file.empty()) {
    drawn = Failure{ExitCode::kUsage,
                    {kCodeParametersInvalid,
                     "FILE, or --behavior, --tree or --skill with a NAME, is required; see musher "
                     "graph --help"}};
  } else {
    const auto config = LoadConfig(options.file, console);
    if (!config) return ExitCode::kUsage;
    drawn = OrFailure(Draw(*config, options.what, format));
  }
  if (const auto* failure = std::get_if<Failure>(&drawn)) return console.Fail(*failure);
  const std::string& drawing = std::get<std::string>(drawn);
  if (options.output.empty()) {
    console.Print(console.mode().json ? GraphJson(format, drawing) : drawing);
    return ExitCode::kDone;
  }
  if (const auto written = WriteFile(options.output, drawing); !written) {
    return console.Fail(written.error());
  }
  if (console.mode().json) console.Print(GraphFileJson(format, options.output));
  return ExitCode::kDone;
}

}  // namespace

void AddGraph(Grammar& grammar) {
  auto [app, options] = grammar.Add("graph", "Draw a config, a state machine, a tree or a skill",
                                    Graph, "musher graph robot.toml --what actuators -o robot.svg");
  auto* file = grammar
                   .Offer(app.add_option("FILE", options.file,
                                         "State config (TOML), or behaviour trees (XML)"),
                          Names::kDrawings)
                   ->type_name("");
  auto* what = grammar.OneOf(app.add_option("--what", options.what,
                                            "flow: the transitions between states (default);\n"
                                            "actuators: their stages and start order"),
                             {"flow", "actuators"});
  auto* behavior = grammar
                       .Offer(app.add_option("--behavior", options.behavior,
                                             "Instead of a config: the state machine of this\n"
                                             "running application, with its current state marked"),
                              Names::kStateMachines)
                       ->excludes(file)
                       ->excludes(what)
                       ->type_name("NAME");
  auto* tree = grammar
                   .Offer(app.add_option("--tree", options.tree,
                                         "Instead of a config: the behaviour tree of this\n"
                                         "running application, with status and times"),
                          Names::kTrees)
                   ->excludes(file)
                   ->excludes(what)
                   ->excludes(behavior)
                   ->type_name("NAME");
  auto* skill = grammar
                    .Offer(app.add_option("--skill", options.skill,
                                          "Instead of a config: this skill of the running\n"
                                          "robot, with its current state marked"),
                           Names::kSkills)
                    ->excludes(file)
                    ->excludes(what)
                    ->excludes(behavior)
                    ->excludes(tree)
                    ->type_name("NAME");
  grammar
      .Offer(
          app.add_option("--actuator", options.actuator, "The one of several that offer the skill"),
          Names::kSkillActuators)
      ->needs(skill)
      ->type_name("NAME");
  grammar.OneOf(
      app.add_option("--format", options.format,
                     "svg needs Graphviz; default: from the output file's name, else dot"),
      {"dot", "mermaid", "svg"});
  grammar
      .Offer(app.add_option("-o,--output", options.output, "Default standard output"),
             Names::kFiles)
      ->type_name("FILE");
}

}  // namespace musher::cli
