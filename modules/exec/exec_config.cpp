#include "musher/modules/exec/exec_config.hpp"

#include <algorithm>
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

bool HasProgram(const ExecConfig& config) {
  const auto set_up = config.states.find(State(kSetUp));
  return set_up != config.states.end() && !set_up->second.start.empty();
}

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

// `run`, or in its place `shell`, a line for /bin/sh.
Rows RunOrShell(std::vector<std::string>& argv, const std::filesystem::path& folder) {
  const auto read_shell = [&argv](TableReader& reader) {
    const auto line = reader.String("shell");
    if (!line) return;
    if (reader.Has("run")) {
      reader.Fault(line->at, "shell", "expected either run or shell, found both");
    }
    argv = {"/bin/sh", "-c", line->text};
  };
  return {Command("run", argv, folder), read_shell};
}

Rows StateRows(const State& state, StateActions& actions, const std::filesystem::path& folder) {
  const auto check_start = [&](TableReader& reader) {
    if (!reader.Has("start") || state == kSetUp) return;
    reader.Fault(reader.At("start"), "start",
                 "a program that keeps running is started in SetUp; here only run and shell are "
                 "possible");
  };
  Rows rows = {Command("start", actions.start, folder), check_start};
  const Rows command = RunOrShell(actions.run, folder);
  rows.insert(rows.end(), command.begin(), command.end());
  return rows;
}

// The table [emergency_stop]. The states have been read.
Row EmergencyStop(ExecConfig& config, const std::filesystem::path& folder) {
  return [&config, folder](TableReader& root) {
    auto reader = root.Sub("emergency_stop");
    if (!reader) return;
    EmergencyStopAction& action = config.emergency_stop.emplace();
    Rows rows = RunOrShell(action.run, folder);
    rows.push_back(row::Time("time_ms", action.time));
    rows.push_back(row::Bool("end_program", action.end_program));
    ReadRows(*reader, rows);
    const bool faulty =
        reader->IsFaulty("run") || reader->IsFaulty("shell") || reader->IsFaulty("end_program");
    if (action.run.empty() && !action.end_program && !faulty) {
      root.Fault(reader->at(), "emergency_stop", "expected run, shell or end_program = true");
    }
    if (action.end_program && !HasProgram(config)) {
      reader->Fault(reader->At("end_program"), "end_program", "[state.SetUp] starts no program");
    }
  };
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
  config.file = std::filesystem::path(path).filename();
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::Integer("module", config.module, 0, kHighestModule),
            row::Time("stop_ms", config.stop_time), row::File("cwd", config.cwd, folder),
            row::Required("state", "a table [state.<name>] for each state that runs something",
                          States(config, actuator, folder, findings)),
            EmergencyStop(config, folder)});
  const std::string unstopped = WhyNothingStops(config);
  if (!unstopped.empty() && !findings.HasErrors()) {
    findings.Warning({1, 1}, unstopped + "; `musher estop` does not confirm its stop");
  }
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

std::string WhyNothingStops(const ExecConfig& config) {
  if (config.emergency_stop) return "";
  const bool switches_on = std::ranges::any_of(config.states, [](const auto& state) {
    return (state.first == kActive || state.first == kProtected) && !state.second.run.empty();
  });
  const bool program = HasProgram(config);
  if (!program && !switches_on) return "";
  const std::string who = config.file.empty() ? "started without a file, it" : config.file;
  return who + " has no [emergency_stop]: nothing stops " +
         (program ? "its program" : "what its commands switch on");
}

ExecConfig ConfigForProgram(std::vector<std::string> program) {
  ExecConfig config;
  config.states[State(kSetUp)].start = std::move(program);
  return config;
}

}  // namespace musher::exec
