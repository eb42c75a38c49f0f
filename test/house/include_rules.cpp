#include "musher/test/house/include_rules.hpp"

#include <algorithm>
#include <map>
#include <regex>
#include <set>

namespace musher::house {
namespace {

using Folders = std::set<std::string>;

// Our own folders that the files of a folder may include. test/ may include everything.
const std::map<std::string, Folders>& MayInclude() {
  static const std::map<std::string, Folders> table = {
      {"lifecycle", {"lifecycle"}},
      {"behavior", {"behavior", "lifecycle"}},
      {"messages", {"messages"}},
      {"transport", {"transport", "lifecycle", "messages"}},
      {"actuator", {"actuator", "lifecycle", "messages", "transport"}},
      {"application",
       {"application", "actuator", "lifecycle", "messages", "transport", "behavior"}},
      {"controller", {"controller", "lifecycle", "messages", "transport"}},
      {"simulation",
       {"simulation", "actuator", "controller", "lifecycle", "messages", "transport"}},
      {"modules",
       {"modules", "application", "actuator", "lifecycle", "messages", "transport", "behavior"}},
      {"examples",
       {"application", "actuator", "controller", "simulation", "lifecycle", "messages", "transport",
        "behavior"}},
  };
  return table;
}

// Libraries by the beginning of their headers, and the places that may include them.
const std::map<std::string, std::vector<std::string>>& Libraries() {
  static const std::map<std::string, std::vector<std::string>> table = {
      {"dds/", {"transport/dds/", "test/contract/", "test/benchmark/"}},
      {"openssl/", {"transport/keys/", "controller/ota/signature.cpp"}},
      {"toml++/", {"lifecycle/toml/"}},
      {"CLI/", {"controller/cli/", "modules/", "test/benchmark/", "test/fault_injection/"}},
      {"SQLiteCpp/", {"controller/", "test/controller/"}},
      {"sqlite3.h", {"controller/", "test/controller/"}},
      {"nlohmann/", {"controller/", "modules/", "test/"}},
      {"zlib.h", {"controller/log_files.cpp", "test/controller/"}},
      {"fmt/", {"controller/", "modules/", "test/"}},
      {"opencv2/", {"modules/", "test/modules/"}},
      {"Eigen/", {"modules/", "test/modules/"}},
      {"alsa/", {"modules/audio/"}},
      {"espeak-ng/", {"modules/audio/"}},
      {"sndfile.h", {"modules/audio/", "test/modules/audio/"}},
  };
  return table;
}

// Headers that would burden all code that includes Musher's.
bool IsHeavy(const std::string& library) {
  static const std::set<std::string> heavy = {"toml++/",   "CLI/", "SQLiteCpp/", "sqlite3.h",
                                              "nlohmann/", "fmt/", "opencv2/"};
  return heavy.contains(library);
}

// "exec" of "modules/exec/child.hpp".
std::string ModuleOf(const std::string& path) {
  const std::size_t begin = std::string("modules/").size();
  return path.substr(begin, path.find('/', begin) - begin);
}

std::string EvaluateOurs(const SourceFile& file, const std::string& header) {
  const auto allowed = MayInclude().find(file.Folder());
  if (allowed == MayInclude().end()) return {};
  const std::string folder = header.substr(0, header.find('/'));
  // The command line is a program on top of everything; the rest of controller/ is not.
  if (folder == "simulation" && file.In("controller/cli/")) return {};
  if (!allowed->second.contains(folder)) return file.Folder() + " may not include " + folder;
  const bool module_to_module =
      folder == "modules" && file.Folder() == "modules" && ModuleOf(header) != ModuleOf(file.path);
  // What all their programs begin with is no module.
  if (module_to_module && ModuleOf(header) != "program") {
    return "module " + ModuleOf(file.path) + " may not include module " + ModuleOf(header);
  }
  return {};
}

std::string EvaluateLibrary(const SourceFile& file, const std::string& header) {
  for (const auto& [library, places] : Libraries()) {
    if (!header.starts_with(library)) continue;
    const bool at_home = std::any_of(places.begin(), places.end(),
                                     [&](const std::string& place) { return file.In(place); });
    if (!at_home) return "<" + header + "> has no place in " + file.Folder();
    const bool light = header.ends_with("_fwd.hpp");  // forward declarations alone
    if (file.Is(".hpp") && IsHeavy(library) && !light && !file.In("test/")) {
      return "<" + header + "> is too heavy for a header";
    }
  }
  return {};
}

}  // namespace

std::vector<std::string> ForbiddenIncludes(const SourceFile& file) {
  static const std::regex include(R"(^\s*#\s*include\s*[<"]([^>"]+)[>"])");
  std::vector<std::string> violations;
  for (const Line& line : Lines(file.text)) {
    std::smatch match;
    if (!std::regex_search(line.text, match, include)) continue;
    const std::string header = match[1];
    const bool ours = header.starts_with("musher/");
    const std::string violation =
        ours ? EvaluateOurs(file, header.substr(std::string("musher/").size()))
             : EvaluateLibrary(file, header);
    if (!violation.empty()) violations.push_back(At(file, line.number, violation));
  }
  return violations;
}

}  // namespace musher::house
