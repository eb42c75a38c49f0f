#include "musher/test/house/include_rules.hpp"

#include <algorithm>
#include <map>
#include <regex>
#include <set>

namespace musher::house {
namespace {

using Folders = std::set<std::string>;

// Our own folders that the files of a folder may include, with what is inside of them; of two rows
// the longer one holds. test/ may include everything.
using Table = std::map<std::string, Folders>;
const Table& MayInclude() {
  static const Table table = {
      {"base", {"base"}},
      {"lifecycle", {"lifecycle", "base"}},
      {"behavior", {"behavior", "base"}},
      {"navigation", {"navigation", "base"}},
      {"messages", {"messages"}},
      {"transport", {"transport", "base", "messages"}},
      {"wire", {"wire", "base", "lifecycle", "messages", "transport"}},
      {"actuator", {"actuator", "base", "lifecycle", "messages", "transport", "wire"}},
      {"application",
       {"application", "actuator", "base", "lifecycle", "messages", "transport", "wire",
        "behavior"}},
      {"controller", {"controller", "base", "lifecycle", "messages", "transport", "wire"}},
      {"ota", {"ota", "base", "lifecycle"}},
      {"cli",
       {"cli", "ota", "controller", "base", "lifecycle", "messages", "transport", "wire",
        "simulation", "search", "cyberdog", "behavior", "view/json", "view/topics"}},
      // The numbers and names of CyberDog's modules, for these too; the rest of cyberdog/ is not.
      {"cyberdog/codes", {"cyberdog/codes", "base"}},
      {"cyberdog",
       {"cyberdog", "actuator", "controller", "base", "lifecycle", "messages", "transport",
        "wire"}},
      {"search", {"search", "base", "lifecycle"}},
      {"simulation",
       {"simulation", "actuator", "controller", "cyberdog", "base", "lifecycle", "messages",
        "transport", "wire"}},
      {"modules",
       {"modules", "application", "actuator", "cyberdog/codes", "base", "lifecycle", "messages",
        "transport", "wire", "behavior", "navigation"}},
      {"view", {"view", "controller", "base", "lifecycle", "messages", "transport", "wire"}},
      {"python",
       {"python", "application", "actuator", "controller", "simulation", "cyberdog/codes", "base",
        "lifecycle", "messages", "transport", "wire", "behavior"}},
      {"examples",
       {"application", "actuator", "controller", "cyberdog", "simulation", "base", "lifecycle",
        "messages", "transport", "wire", "behavior"}},
  };
  return table;
}

// The rooms of a folder in layers, the lowest first; "" are the files at its top. A room may
// include itself and the rooms of lower layers, not one beside it. A folder inside a room belongs
// to it.
using Layers = std::vector<Folders>;
const std::map<std::string, Layers>& Rooms() {
  static const std::map<std::string, Layers> table = {
      {"lifecycle",
       {{""},
        {"config"},
        {"health", "ros2"},
        {"machine"},
        {"actuator", "record"},
        {"step"},
        {"policy"},
        {"switch", "config/toml"},
        {"supervision", "rules"},
        {"coordinator"}}},
      {"transport", {{"", "security"}, {"dds", "sim"}}},
      {"controller",
       {{"client", "journal", "link", "process"}, {"shell", "storage"}, {"ros2"}, {""}}},
      {"behavior", {{""}, {"fsm", "tree"}, {"skill"}}},
      {"view",
       {{"http", "json", "mcap", "topics"},
        {"metrics"},
        {"", "page", "record"},
        {"foxglove"},
        {"live"}}},
  };
  return table;
}

// Headers of base/ that query the kernel or the environment. Folders without IO may not include
// them.
bool IsOfTheKernel(const std::string& header) {
  static const std::set<std::string> kernel = {"base/config_path.hpp", "base/date_text.hpp",
                                               "base/exit_status.hpp", "base/files.hpp",
                                               "base/host.hpp",        "base/process_usage.hpp",
                                               "base/program.hpp",     "base/program_path.hpp",
                                               "base/scheduling.hpp",  "base/unique_fd.hpp"};
  return kernel.contains(header);
}

// Libraries by the beginning of their headers, and the places that may include them.
const std::map<std::string, std::vector<std::string>>& Libraries() {
  static const std::map<std::string, std::vector<std::string>> table = {
      {"dds/", {"transport/dds/", "test/contract/", "test/benchmark/"}},
      {"openssl/", {"transport/security/", "wire/security/", "ota/signature.cpp", "test/wire/"}},
      {"toml++/", {"base/toml/"}},
      {"tinyxml2.h", {"behavior/tree/xml/"}},
      {"CLI/",
       {"base/usage_error.cpp", "cli/", "actuator/program/", "modules/", "view/", "test/benchmark/",
        "test/fault_injection/", "test/cli/"}},
      {"SQLiteCpp/", {"controller/", "test/controller/"}},
      {"sqlite3.h", {"controller/", "test/controller/"}},
      {"nlohmann/",
       {"application/groot2/", "behavior/tree/json/", "cli/", "controller/", "cyberdog/",
        "modules/", "navigation/route/route_graph.cpp", "view/", "test/"}},
      {"zlib.h",
       {"controller/storage/log_files.cpp", "controller/storage/log_reader.cpp", "view/mcap/",
        "test/controller/"}},
      {"fmt/", {"cli/", "controller/", "modules/", "navigation/", "view/", "test/"}},
      {"boost/", {"view/http/", "test/view/"}},
      {"zstd.h", {"view/mcap/", "test/view/"}},
      {"lz4frame.h", {"view/mcap/", "test/view/"}},
      {"opencv2/",
       {"modules/", "view/live/", "test/modules/", "test/view/live/", "test/benchmark/vision/"}},
      {"Eigen/", {"modules/", "navigation/", "test/modules/"}},
      {"alsa/", {"modules/audio/"}},
      {"espeak-ng/", {"modules/audio/"}},
      {"sndfile.h", {"modules/audio/", "test/modules/audio/"}},
      {"ompl/", {"navigation/planner/smoothing.cpp", "test/benchmark/navigation/"}},
      {"octomap/", {"navigation/planner/octree_map.cpp"}},
      {"dlib/", {"navigation/controller/axis_control.cpp"}},
      {"pybind11/", {"python/"}},
      {"zmq.h", {"application/groot2/", "test/application/", "test/modules/meilin/"}},
  };
  return table;
}

// Headers that would burden all code that includes Musher's headers with them.
bool IsHeavy(const std::string& library) {
  static const std::set<std::string> heavy = {"toml++/",    "tinyxml2.h", "CLI/",
                                              "SQLiteCpp/", "sqlite3.h",  "nlohmann/",
                                              "fmt/",       "opencv2/",   "boost/"};
  return heavy.contains(library);
}

// Whether another folder may include the headers of this one. Headers of programs on top of
// everything, of modules (none includes another) and of test/ are for their own folder. So are the
// headers of the command line, for its own hundred sources.
bool IsSharedFolder(const std::string& folder) {
  return folder == "cli" ||
         std::any_of(MayInclude().begin(), MayInclude().end(), [&](const auto& row) {
           return row.first.substr(0, row.first.find('/')) != folder && row.second.contains(folder);
         });
}

// "exec" of "modules/exec/child.hpp".
std::string ModuleOf(const std::string& path) {
  const std::size_t begin = std::string("modules/").size();
  return path.substr(begin, path.find('/', begin) - begin);
}

// The row of a file; end(): none.
Table::const_iterator RowOf(const SourceFile& file) {
  const auto subfolder =
      MayInclude().find(file.path.substr(0, file.path.find('/', file.Folder().size() + 1)));
  return subfolder != MayInclude().end() ? subfolder : MayInclude().find(file.Folder());
}

Layers::const_iterator LayerOf(const std::string& room, const Layers& layers) {
  return std::find_if(layers.begin(), layers.end(),
                      [&](const Folders& layer) { return layer.contains(room); });
}

// "config/toml" of "lifecycle/config/toml/order.hpp"; the longest one of the folder's rooms.
std::string RoomOf(const std::string& path, const Layers& layers) {
  const std::size_t begin = path.find('/') + 1;
  const std::size_t end = path.rfind('/');
  std::string room = end < begin ? "" : path.substr(begin, end - begin);
  while (LayerOf(room, layers) == layers.end()) {
    const std::size_t slash = room.rfind('/');
    if (slash == std::string::npos) break;
    room.resize(slash);
  }
  return room;
}

std::string EvaluateRoom(const SourceFile& file, const std::string& header) {
  const auto row = Rooms().find(file.Folder());
  const bool program = file.path.ends_with("/main.cpp");  // above its folder
  if (row == Rooms().end() || program || !header.starts_with(file.Folder() + "/")) return {};
  const std::string from = RoomOf(file.path, row->second);
  const std::string to = RoomOf(header, row->second);
  for (const std::string& room : {from, to}) {
    if (LayerOf(room, row->second) == row->second.end()) {
      return "room '" + room + "' of " + file.Folder() + " has no layer";
    }
  }
  if (from == to || LayerOf(to, row->second) < LayerOf(from, row->second)) return {};
  return "room '" + from + "' may not include room '" + to + "'";
}

// The tests of the core are built where the floors above it are not.
std::string EvaluateTest(const SourceFile& file, const std::string& header) {
  static const Folders of_core = {
      "support",    "base",      "lifecycle", "behavior",    "search",     "transport",
      "wire",       "contract",  "actuator",  "application", "controller", "cyberdog",
      "simulation", "protocols", "golden",    "mutation",    "house"};
  static const Folders above = {"cli", "ota", "view", "python", "modules", "navigation"};
  const std::size_t begin = std::string("test/").size();
  const std::string tested = file.path.substr(begin, file.path.find('/', begin) - begin);
  const std::string folder = header.substr(0, header.find('/'));
  if (!of_core.contains(tested) || !above.contains(folder)) return {};
  return "test/" + tested + " is of the core and may not include " + folder;
}

std::string EvaluateOurs(const SourceFile& file, const std::string& header) {
  if (file.In("test/")) return EvaluateTest(file, header);
  const auto row = RowOf(file);
  if (row == MayInclude().end()) {
    return file.Folder() + " has no row in the table of what it may include";
  }
  const auto& [place, allowed] = *row;
  const std::string folder = header.substr(0, header.find('/'));
  const bool permitted = std::any_of(allowed.begin(), allowed.end(), [&](const std::string& below) {
    return header.starts_with(below + "/");
  });
  if (!permitted) return place + " may not include " + folder;
  const bool pure = file.In("lifecycle/") || file.In("behavior/") || file.In("navigation/");
  if (pure && IsOfTheKernel(header)) return file.Folder() + " may not include " + header;
  const bool module_to_module =
      folder == "modules" && file.Folder() == "modules" && ModuleOf(header) != ModuleOf(file.path);
  if (module_to_module) {
    return "module " + ModuleOf(file.path) + " may not include module " + ModuleOf(header);
  }
  return EvaluateRoom(file, header);
}

std::string EvaluateLibrary(const SourceFile& file, const std::string& header) {
  for (const auto& [library, places] : Libraries()) {
    if (!header.starts_with(library)) continue;
    const bool at_home = std::any_of(places.begin(), places.end(),
                                     [&](const std::string& place) { return file.In(place); });
    if (!at_home) return "<" + header + "> has no place in " + file.Folder();
    const bool light = header.ends_with("_fwd.hpp");  // forward declarations alone
    if (file.Is(".hpp") && IsHeavy(library) && !light && IsSharedFolder(file.Folder())) {
      return "<" + header + "> is too heavy for a header of " + file.Folder();
    }
  }
  return {};
}

// The folder of a file is its node of the graph. A main.cpp is above its folder: nothing includes
// it.
std::string NodeOf(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos || path.substr(slash) == "/main.cpp") return path;
  return path.substr(0, slash);
}

using Graph = std::map<std::string, Folders>;

Graph GraphOf(const std::vector<SourceFile>& tree) {
  static const std::regex include(R"re(^#include "musher/([^"]+)")re");
  Graph graph;
  for (const SourceFile& file : tree) {
    if (!file.IsCpp() || file.In("test/") || file.path.find('/') == std::string::npos) continue;
    const std::string from = NodeOf(file.path);
    for (const Line& line : Lines(file.text)) {
      std::smatch match;
      if (!std::regex_search(line.text, match, include)) continue;
      if (const std::string to = NodeOf(match[1]); to != from) graph[from].insert(to);
    }
  }
  return graph;
}

// What can be reached from `node`.
Folders ReachedFrom(const std::string& node, const Graph& graph) {
  Folders reached;
  std::vector<std::string> open = {node};
  while (!open.empty()) {
    const auto next = graph.find(open.back());
    open.pop_back();
    if (next == graph.end()) continue;
    for (const std::string& folder : next->second) {
      if (reached.insert(folder).second) open.push_back(folder);
    }
  }
  return reached;
}

}  // namespace

std::vector<std::string> IncludeCycles(const std::vector<SourceFile>& tree) {
  const Graph graph = GraphOf(tree);
  std::vector<std::string> cycles;
  for (const auto& [from, folders] : graph) {
    for (const std::string& to : folders) {
      if (ReachedFrom(to, graph).contains(from)) {
        cycles.push_back(from + " includes " + to + ", which includes it");
      }
    }
  }
  return cycles;
}

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
