#include "musher/modules/meilin/plan/tool.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>
#include <variant>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/usage_error.hpp"
#include "musher/modules/meilin/plan/box_map_text.hpp"
#include "musher/modules/meilin/plan/json_reader.hpp"
#include "musher/modules/meilin/plan/plan_file.hpp"
#include "musher/modules/meilin/plan/plan_text.hpp"
#include "musher/modules/meilin/plan/segments_json.hpp"

namespace musher::meilin {
namespace {

constexpr int kErrors = 2;

// Whether a text that can be parsed has the key; it then is a map of boxes.
bool HasGrid(const std::string& text, bool json) {
  if (json) {
    JsonFaults faults;
    const auto document = ParseJson(text, faults);
    return document && document->is_object() && document->contains("grid");
  }
  const auto document = config_toml::ParseDocument(text);
  const auto* table = std::get_if<config_toml::Table>(&document);
  return table != nullptr && (config_toml::Find(*table, "grid") != nullptr ||
                              config_toml::Find(*table, "team") != nullptr);
}

void AddFaults(const std::string& path, Severity severity, const std::vector<std::string>& faults,
               std::vector<Diagnostic>& diagnostics) {
  for (const std::string& fault : faults) diagnostics.push_back({path, 0, 0, severity, fault});
}

int PrintDiagnostics(const std::vector<Diagnostic>& diagnostics) {
  for (const Diagnostic& diagnostic : diagnostics) {
    std::cerr << FormatDiagnostic(diagnostic) << "\n";
  }
  return HasError(diagnostics) ? kErrors : 0;
}

int CheckFiles(const std::vector<std::string>& files, const FileCheck& others) {
  int code = 0;
  for (const std::string& file : files) {
    auto diagnostics = others ? others(file) : std::nullopt;
    if (!diagnostics && (file.ends_with(".toml") || file.ends_with(".json"))) {
      diagnostics = CheckPlanFile(file);
    }
    if (!diagnostics) {
      diagnostics = {{file, 0, 0, Severity::kError,
                      "expected a plan or a map of boxes, a file that ends in .toml or .json"}};
    }
    const int found = PrintDiagnostics(*diagnostics);
    if (found == 0) std::cout << file << ": no errors" << std::endl;
    code = std::max(code, found);
  }
  return code;
}

struct PlanOptions {
  std::string file;
  int kfs2 = -1;  // -1: what a team sends
  int index = 1;
  int entrance = 0;
  bool json = false;
};

void PrintPlan(const BoxMap& map, const std::vector<PlanStep>& steps) {
  Grid grid;
  grid.side = map.side;
  std::cout << StepTable(steps, grid) << "\n" << FieldDrawing(map, steps) << std::flush;
}

void PrintBuckets(const RouteReport& report) {
  for (std::size_t count = 0; count < report.routes.size(); ++count) {
    const RouteBucket& bucket = report.routes.at(count);
    std::cout << fmt::format("{} KFS2: {} plans{}\n", count, bucket.total,
                             bucket.routes.empty() ? ""
                                                   : fmt::format(", the best takes {:g} s",
                                                                 bucket.routes.front().cost_s));
  }
  if (!report.complete) std::cout << "The search ended at its limit: there are more plans.\n";
  std::cout << "\n";
}

int PlanOfMap(const PlanOptions& options) {
  const BoxMapFileReading reading = ReadBoxMapFile(options.file);
  if (PrintDiagnostics(reading.diagnostics) != 0 || !reading.map) return kErrors;
  RouteRules rules;
  rules.entrance = {0, options.entrance};
  const RouteReport report = FindRoutes(*reading.map, rules);
  if (options.json) {
    std::cout << RoutesJson(report.routes) << std::endl;
    return 0;
  }
  PrintBuckets(report);
  const Route* route = BestRoute(report.routes);
  if (options.kfs2 >= 0) {
    const auto& routes = report.routes.at(static_cast<std::size_t>(options.kfs2)).routes;
    const auto index = static_cast<std::size_t>(options.index - 1);
    route = index < routes.size() ? &routes.at(index) : nullptr;
  }
  if (route == nullptr) {
    const bool none = BestRoute(report.routes) == nullptr;
    std::cerr << options.file << ": there is no "
              << (none ? std::string("plan for this map: ") + kNoPath : "such plan for this map")
              << "\n";
    return kErrors;
  }
  std::cout << RouteSummary(*route) << "\n\n";
  PrintPlan(*reading.map, route->steps);
  return 0;
}

int PlanOfFile(const PlanOptions& options) {
  const DrawnPlanReading reading = ReadPlanFile(options.file);
  if (PrintDiagnostics(reading.diagnostics) != 0 || !reading.plan) return kErrors;
  BoxMap map;
  map.side = reading.plan->side;
  for (const PlanStep& step : reading.plan->steps) {
    if (!step.fetch) continue;
    map.boxes.at(static_cast<std::size_t>(step.cell.row))
        .at(static_cast<std::size_t>(step.cell.col)) = Box::kKfs2;
  }
  if (options.json) {
    Routes routes;
    routes.at(0).total = 1;
    routes.at(0).routes.push_back({reading.plan->steps, 0, 0, 0});
    std::cout << nlohmann::json::parse(RoutesJson(routes))["buckets"][0]["paths"][0]["detail"]
              << std::endl;
    return 0;
  }
  PrintPlan(map, reading.plan->steps);
  return 0;
}

int Plan(const PlanOptions& options) {
  const auto text = config_toml::ReadModuleText(options.file);
  if (!text)
    return PrintDiagnostics({{options.file, 0, 0, Severity::kError, text.error().message}});
  const bool json = options.file.ends_with(".json");
  return json || HasGrid(text.value(), json) ? PlanOfMap(options) : PlanOfFile(options);
}

}  // namespace

bool IsPlanTool(std::string_view command) {
  return command == "check" || command == "plan";
}

std::vector<Diagnostic> CheckPlanFile(const std::string& path) {
  const auto text = config_toml::ReadModuleText(path);
  if (!text) return {{path, 0, 0, Severity::kError, text.error().message}};
  const bool json = path.ends_with(".json");
  if (HasGrid(text.value(), json)) return ReadBoxMapFile(path).diagnostics;
  if (!json) return ReadPlanText(text.value(), path).diagnostics;
  const SegmentsReading reading = ReadSegmentsJson(text.value());
  std::vector<Diagnostic> diagnostics;
  AddFaults(path, Severity::kError, reading.faults, diagnostics);
  AddFaults(path, Severity::kWarning, reading.warnings, diagnostics);
  return diagnostics;
}

int RunPlanTool(int argc, const char* const* argv, const FileCheck& others) {
  const std::string command = argc > 0 ? argv[0] : "";
  CLI::App app("", "musher-meilin " + command);
  app.footer("Exit codes: 0 no errors; 2 errors, or usage.");
  std::vector<std::string> files;
  PlanOptions options;
  if (command == "check") {
    app.description("Reports every error of plans and of maps of boxes.");
    app.add_option("FILE", files, "Drawn plans, maps of boxes and old plans")->required();
  } else {
    app.description("Prints a drawn plan, or the best plans of a map of boxes.");
    app.add_option("FILE", options.file, "A drawn plan or a map of boxes")->required();
    app.add_option("--kfs2", options.kfs2, "The plan takes so many boxes, 0 to 4; default 2, or 3")
        ->check(CLI::Range(0, kMostFetched));
    app.add_option("--index", options.index, "The best with --kfs2 is 1, the next 2")
        ->check(CLI::Range(1, 10))
        ->needs("--kfs2");
    app.add_option("--entrance", options.entrance, "Of a map: the column of row 0 to enter at")
        ->check(CLI::Range(0, kCols - 1))
        ->capture_default_str();
    app.add_flag("--json", options.json, "JSON: all plans of a map; the steps of a drawn plan");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return EndOfParse(app, error, kErrors);
  }
  return command == "check" ? CheckFiles(files, others) : Plan(options);
}

}  // namespace musher::meilin
