#include "musher/test/house/interface_rules.hpp"

#include <algorithm>
#include <regex>
#include <set>

namespace musher::house {
namespace {

using Names = std::set<std::string>;

constexpr const char* kImplemented = "## What is implemented";
constexpr const char* kLeftOut = "## What is left out";

void Collect(const std::string& text, const std::regex& pattern, Names& names) {
  for (std::sregex_iterator i(text.begin(), text.end(), pattern), end; i != end; ++i) {
    names.insert((*i)[1]);
  }
}

// Strings of the programs, without what leads them to a namespace: "world/led" is also "led". Names
// of modules are no interfaces.
Names StringsOf(const std::vector<SourceFile>& tree) {
  static const std::regex quoted(R"re("([\w/.]+)")re");
  Names names;
  for (const SourceFile& file : tree) {
    const bool program =
        file.IsCpp() && (file.In("cli/") || file.In("controller/") || file.In("cyberdog/") ||
                         file.In("actuator/") || file.In("transport/") || file.In("modules/"));
    const bool config = file.In("config/") && file.Is(".toml");
    const bool module_names = file.In("cyberdog/codes/");
    if (program && !module_names) Collect(WithoutComments(file.text), quoted, names);
    if (config) Collect(file.text, quoted, names);
  }
  for (const std::string& name : Names(names)) names.insert(name.substr(name.rfind('/') + 1));
  return names;
}

Names TypesOf(const std::vector<SourceFile>& tree) {
  static const std::regex type(R"(struct ([A-Za-z0-9]+)_)");
  Names names;
  for (const SourceFile& file : tree) {
    if (file.In("messages/protocol/")) Collect(file.text, type, names);
  }
  return names;
}

Names InterfacesOfTheManager(const std::vector<SourceFile>& tree) {
  static const std::regex opened(
      R"re((?:Subscribe|Serve|PublishFunction|OpenClient)<[^>]+>\(\s*"([\w/]+)")re");
  static const std::regex constant(R"re(\bk\w+ = "([\w/]+)";)re");
  Names names;
  for (const SourceFile& file : tree) {
    if (!file.In("cyberdog/")) continue;
    const std::string code = WithoutComments(file.text);
    Collect(code, opened, names);
    if (file.Is("/interfaces.hpp")) Collect(code, constant, names);
  }
  return names;
}

std::vector<std::string> AllMatches(const SourceFile& file, const std::regex& pattern) {
  const std::string code = WithoutComments(file.text);
  std::vector<std::string> found;
  for (std::sregex_iterator i(code.begin(), code.end(), pattern), end; i != end; ++i) {
    found.push_back((*i)[1]);
  }
  return found;
}

bool Has(const SourceFile& page, const std::string& name) {
  return page.text.find("`" + name + "`") != std::string::npos;
}

}  // namespace

std::vector<std::string> WrongInterfaces(const SourceFile& page,
                                         const std::vector<SourceFile>& tree) {
  static const std::regex code("`([^`]+)`");
  const Names strings = StringsOf(tree);
  std::vector<std::string> violations;
  std::string section;
  bool checked_there = false;
  bool checked_left_out = false;
  for (const Line& line : Lines(page.text)) {
    if (line.text.starts_with("## ")) section = line.text;
    if (!line.text.starts_with("| `")) continue;
    Names names;
    Collect(line.text.substr(0, line.text.find('|', 1)), code, names);
    for (const std::string& name : names) {
      if (section == kImplemented && !strings.contains(name)) {
        violations.push_back(At(page, line.number, "the code has no `" + name + "`"));
      } else if (section == kLeftOut && strings.contains(name)) {
        violations.push_back(At(page, line.number, "the code has `" + name + "`"));
      }
    }
    checked_there = checked_there || section == kImplemented;
    checked_left_out = checked_left_out || section == kLeftOut;
  }
  if (!checked_there || !checked_left_out) violations.push_back(page.path + ": a table is missing");
  for (const Names& all : {TypesOf(tree), InterfacesOfTheManager(tree)}) {
    if (all.empty()) violations.push_back(page.path + ": nothing to compare it with");
    for (const std::string& name : all) {
      if (!Has(page, name)) violations.push_back(page.path + ": `" + name + "` is missing");
    }
  }
  return violations;
}

std::vector<std::string> UnlistedInterfaces(const SourceFile& constants, const SourceFile& list) {
  static const std::regex declared(R"re(\b(k\w+) = ")re");
  static const std::regex name(R"(\b(k\w+))");
  const std::vector<std::string> all = AllMatches(constants, declared);
  const std::vector<std::string> listed = AllMatches(list, name);
  std::vector<std::string> violations;
  if (all.empty()) violations.push_back(constants.path + ": nothing to compare with");
  for (const std::string& one : all) {
    if (std::count(listed.begin(), listed.end(), one) == 0) {
      violations.push_back(list.path + ": " + one + " is missing: every actuator may use it");
    }
  }
  return violations;
}

std::vector<std::string> WronglyNamedModules(const SourceFile& constants, const SourceFile& names) {
  static const std::regex declared(R"(\bModuleCode (k\w+)\{)");
  static const std::regex name(R"re(\{module_code::(k\w+), "[^"]+"\})re");
  const std::vector<std::string> all = AllMatches(constants, declared);
  const std::vector<std::string> named = AllMatches(names, name);
  std::vector<std::string> violations;
  if (all.empty()) violations.push_back(constants.path + ": nothing to compare with");
  for (const std::string& one : all) {
    const auto count = std::count(named.begin(), named.end(), one);
    if (count == 0) violations.push_back(names.path + ": " + one + " has no name");
    if (count > 1) violations.push_back(names.path + ": " + one + " has several names");
  }
  for (const std::string& one : named) {
    if (std::count(all.begin(), all.end(), one) == 0) {
      violations.push_back(names.path + ": " + one + " is no module");
    }
  }
  return violations;
}

}  // namespace musher::house
