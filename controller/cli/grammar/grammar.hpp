#pragma once
// The grammar of `musher`'s command line, as CLI11 has it: a file for each group of commands.

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>
#include <string>
#include <variant>

#include "musher/controller/cli/command_line.hpp"

namespace musher::cli {

inline constexpr const char* kCommandFooter =
    "\nOptions of every command (--json, --namespace, --domain, ...): musher --help";

class Grammar {
 public:
  Grammar();

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv);

 private:
  template <class Options>
  CLI::App* AddCommand(const std::string& name, const std::string& what,
                       std::shared_ptr<Options> options) {
    CLI::App* command = app_.add_subcommand(name, what);
    command->group("Commands");
    command->footer(kCommandFooter);
    command->callback([this, options] { take_command_ = [options] { return *options; }; });
    return command;
  }

  template <class Options>
  CLI::App* AddKeysCommand(CLI::App& keys, const std::string& name, const std::string& what,
                           std::shared_ptr<Options> options) {
    CLI::App* command = keys.add_subcommand(name, what);
    command->footer(kCommandFooter);
    command->callback([this, options] { take_command_ = [options] { return *options; }; });
    return command;
  }

  void AddGlobalOptions();
  void AddConfigCommands();
  void AddSimulate();
  void AddMachineCommands();
  void AddSwitchingCommands();
  void AddKeysCommands();
  std::string Complaint(const CLI::ParseError& e) const;
  void TakeGlobalOptions();

  CLI::App app_;
  GlobalOptions global_;
  std::string name_space_;
  std::string colour_;
  double timeout_s_ = 0;
  CLI::Option* namespace_ = nullptr;
  CLI::Option* timeout_ = nullptr;
  std::function<CommandOptions()> take_command_;
};

}  // namespace musher::cli
