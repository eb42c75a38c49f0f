#include "musher/modules/exec/exec_config.hpp"

#include <filesystem>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/findings.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/lifecycle/state.hpp"

namespace musher::exec {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Member;
using config_toml::Quote;
using config_toml::Row;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::int64_t kHighestModule = 100'000;

// A program and its arguments. A string in their place is taken for a shell line.
Row Command(std::string_view key, std::vector<std::string>& argv,
            const std::filesystem::path& folder) {
  return [key, read = row::Program(key, argv, folder)](TableReader& state) {
    const config_toml::Value* value = state.Get(key);
    const auto* line = value == nullptr ? nullptr : value->As<std::string>();
    if (line == nullptr) return read(state);
    state.Fault(value->at, key,
                "expected an array of strings, found a string; write [\"program\", \"argument\"], "
                "or shell = " +
                    Quote(*line) + " for a shell line");
  };
}

Rows StateRows(const State& state, StateActions& actions, const std::filesystem::path& folder) {
  const auto read_shell = [&](TableReader& reader) {
    const auto line = reader.String("shell");
    if (!line) return;
    if (reader.Has("run")) {
      reader.Fault(line->at, "shell", "expected either run or shell, found both");
    }
    actions.run = {"/bin/sh", "-c", line->text};
  };
  const auto check_start = [&](TableReader& reader) {
    if (!reader.Has("start") || state == kSetUp) return;
    reader.Fault(reader.At("start"), "start",
                 "a program that keeps running is started in SetUp; here only run and shell are "
                 "possible");
  };
  return {Command("start", actions.start, folder), Command("run", actions.run, folder), read_shell,
          check_start};
}

void CheckListed(const Member& state, const ActuatorConfig& actuator, Findings& findings) {
  if (actuator.Lists(state.key)) return;
  const std::vector<std::string_view> listed(actuator.states.begin(), actuator.states.end());
  const std::string guess = findings.Guess(state.key, listed);
  findings.Error(state.at, "state." + state.key +
                               ": the state config does not list this state for " + actuator.name +
                               "; it lists " + config_toml::Listing(listed) + guess);
}

// The tables [state.<name>].
Row States(ExecConfig& config, const ActuatorConfig& actuator, const std::filesystem::path& folder,
           Findings& findings) {
  return [&](TableReader& root) {
    auto reader = root.Sub("state");
    if (!reader) return;
    for (const Member& member : *root.SubTable("state")) {
      CheckListed(member, actuator, findings);
      const State state(member.key);
      StateActions actions;
      row::Sub(member.key, StateRows(state, actions, folder))(*reader);
      if (member.value.As<Table>() != nullptr) config.states.emplace(state, std::move(actions));
    }
  };
}

ExecConfig Read(const Table& table, const std::string& path, const ActuatorConfig& actuator,
                Findings& findings) {
  const std::filesystem::path folder = config_toml::FolderOf(path);
  ExecConfig config;
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::Integer("module", config.module, 0, kHighestModule),
            row::Time("stop_ms", config.stop_time), row::File("cwd", config.cwd, folder),
            row::Required("state", "a table [state.<name>] for each state that runs something",
                          States(config, actuator, folder, findings))});
  return config;
}

}  // namespace

Parsed<ExecConfig> ReadExecText(std::string_view text, const std::string& path,
                                const ActuatorConfig& actuator) {
  return config_toml::ReadTextWith<Parsed<ExecConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, actuator, findings); });
}

Parsed<ExecConfig> ReadExecFile(const std::string& path, const ActuatorConfig& actuator) {
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
