#include "musher/modules/exec/exec_config.hpp"

#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/table_reader.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::exec {
namespace {

using config_toml::Findings;
using config_toml::Member;
using config_toml::Quote;
using config_toml::Table;
using config_toml::TableReader;
using config_toml::Word;

constexpr std::int64_t kHighestModule = 100'000;

class Reader {
 public:
  Reader(const std::string& path, const ActuatorConfig& actuator, Findings& findings)
      : folder_(config_toml::FolderOf(path)), actuator_(actuator), findings_(findings) {}

  ExecConfig Read(const Table& table) {
    TableReader root(table, {1, 1}, "", findings_);
    const auto module = root.Integer("module", 0, kHighestModule);
    config_.module = static_cast<std::int32_t>(module.value_or(config_.module));
    config_.stop_time = root.Time("stop_ms").value_or(config_.stop_time);
    if (const auto cwd = root.String("cwd")) {
      config_.cwd = config_toml::Absolute(folder_, cwd->text);
    }
    root.Require("state", "a table [state.<name>] for each state that runs something");
    if (const Table* states = root.SubTable("state")) {
      for (const Member& member : *states) ReadState(member);
    }
    root.RefuseOthers();
    return std::move(config_);
  }

 private:
  void ReadState(const Member& member) {
    const std::string path = "state." + member.key;
    if (!actuator_.Lists(member.key)) {
      const std::vector<std::string_view> listed(actuator_.states.begin(), actuator_.states.end());
      const std::string guess = findings_.Guess(member.key, listed);
      findings_.Error(member.at, path + ": the state config does not list this state for " +
                                     actuator_.name + "; it lists " + config_toml::Listing(listed) +
                                     guess);
    }
    const auto* table = member.value.As<Table>();
    if (table == nullptr) {
      return findings_.Error(member.value.at, path + ": expected a table, found " +
                                                  std::string(TypeName(member.value)));
    }
    TableReader reader(*table, member.value.at, path, findings_);
    StateActions actions;
    actions.start = ReadCommand(reader, "start");
    actions.run = ReadCommand(reader, "run");
    if (const auto line = reader.String("shell")) {
      if (reader.Has("run")) {
        reader.Fault(line->at, "shell", "expected either run or shell, found both");
      }
      actions.run = {"/bin/sh", "-c", line->text};
    }
    if (reader.Has("start") && member.key != kSetUp) {
      reader.Fault(reader.At("start"), "start",
                   "a program that keeps running is started in SetUp; here only run and shell are "
                   "possible");
    }
    reader.RefuseOthers();
    config_.states.emplace(member.key, std::move(actions));
  }

  std::vector<std::string> ReadCommand(TableReader& reader, std::string_view key) {
    const config_toml::Value* value = reader.Get(key);
    if (value == nullptr) return {};
    if (const auto* line = value->As<std::string>()) {
      reader.Fault(value->at, key,
                   "expected an array of strings, found a string; write [\"program\", "
                   "\"argument\"], or shell = " +
                       Quote(*line) + " for a shell line");
      return {};
    }
    const auto words = reader.Strings(key, {.may_repeat = true});
    if (!words || words->empty()) return {};
    std::vector<std::string> argv;
    for (const Word& word : *words) argv.push_back(word.text);
    if (argv.front().empty()) {
      reader.Fault(words->front().at, key, "expected a program, found an empty string");
    } else if (argv.front().find('/') != std::string::npos) {
      argv.front() = config_toml::Absolute(folder_, argv.front());
    }
    return argv;
  }

  const std::filesystem::path folder_;
  const ActuatorConfig& actuator_;
  Findings& findings_;
  ExecConfig config_;
};

}  // namespace

ExecReading ReadExecText(std::string_view text, const std::string& path,
                         const ActuatorConfig& actuator) {
  return config_toml::ReadTextWith<ExecReading>(
      text, path, [&](const Table& root, Findings& findings) {
        return Reader(path, actuator, findings).Read(root);
      });
}

ExecReading ReadExecFile(const std::string& path, const ActuatorConfig& actuator) {
  return config_toml::ReadFileWith(path, [&](const std::string& text, const std::string& name) {
    return ReadExecText(text, name, actuator);
  });
}

ExecConfig ConfigForProgram(std::vector<std::string> program) {
  ExecConfig config;
  config.states[State(kSetUp)].start = std::move(program);
  return config;
}

}  // namespace musher::exec
