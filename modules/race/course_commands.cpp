// The commands of a course: none may hide those of every race, or be hidden by another one.

#include <algorithm>
#include <array>
#include <set>

#include "musher/base/toml/names.hpp"
#include "musher/modules/race/course_parts.hpp"

namespace musher::race::parts {
namespace {

constexpr std::array<std::string_view, 3> kOfEveryRace = {"START", "STOP", "RESET"};

bool IsOfEveryRace(std::string_view command) {
  return std::ranges::find(kOfEveryRace, command) != kOfEveryRace.end();
}

class CheckingCommands {
 public:
  CheckingCommands(TableReader& root, Reading& reading) : root_(root), reading_(reading) {}

  void Run() {
    for (const ResultRule& result : reading_.course.results) CheckResult(result);
    for (const CourseCommand& own : reading_.course.commands) {
      const bool hidden = IsOfEveryRace(own.name) || defaults_.contains(own.name);
      if (hidden) Fail("command", own.name, "", "hides the command of that name");
    }
  }

 private:
  void CheckResult(const ResultRule& result) {
    if (result.command.empty()) return;
    if (!config_toml::IsName(result.command)) {
      Fail("result", result.name, "command", "expected " + std::string(config_toml::kNameRule));
    } else if (IsOfEveryRace(result.command)) {
      Fail("result", result.name, "command", "hides the command " + result.command);
    } else if (!defaults_.insert(result.command + "_DEFAULT").second) {
      Fail("result", result.name, "command",
           "expected another command; " + result.command + " is also that of another result");
    }
  }

  // At the key of a table [section.name]; without a key at the table.
  void Fail(const char* section, const std::string& name, std::string_view key,
            const std::string& what) {
    const std::string path = std::string(section) + "." + name;
    for (const config_toml::Member& member : *root_.SubTable(section)) {
      if (member.key != name) continue;
      TableReader table(*member.value.As<Table>(), member.at, path, reading_.findings);
      if (key.empty()) return reading_.findings.Error(member.at, path + ": " + what);
      return table.Fault(table.At(key), key, what);
    }
  }

  TableReader& root_;
  Reading& reading_;
  std::set<std::string> defaults_;  // SET_…_DEFAULT
};

}  // namespace

void CheckCommands(TableReader& root, Reading& reading) {
  CheckingCommands(root, reading).Run();
}

}  // namespace musher::race::parts
