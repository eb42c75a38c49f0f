#pragma once
// The grammar of `musher`'s command line, built with CLI11: one file for each group of commands.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "musher/controller/cli/command_line.hpp"

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace musher::cli {

class Grammar {
 public:
  Grammar();
  ~Grammar();
  Grammar(const Grammar&) = delete;
  Grammar& operator=(const Grammar&) = delete;

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv);

  // The possible completions of the last of these words, which is unfinished. `words` starts after
  // the program's name.
  CommandLine Complete(const std::vector<std::string>& words);

  // See GrammarLines().
  std::vector<std::string> Lines() const;

 private:
  class Walk;

  // CLI11 fills in the options when it parses the command.
  template <class Options>
  CLI::App* AddCommand(const std::string& name, const std::string& what,
                       std::shared_ptr<Options> options) {
    return AddTo(*app_, name, what, [options] { return *options; });
  }
  // A command with subcommands.
  CLI::App* AddFamily(const std::string& name, const std::string& what);
  template <class Options>
  CLI::App* AddSubcommand(CLI::App& group, const std::string& name, const std::string& what,
                          std::shared_ptr<Options> options) {
    return AddTo(group, name, what, [options] { return *options; });
  }
  CLI::App* AddTo(CLI::App& parent, const std::string& name, const std::string& what,
                  std::function<CommandOptions()> take);
  // The parser accepts only these words; completion offers them.
  CLI::Option* OneOf(CLI::Option* option, const std::vector<std::string>& words);
  // Completion offers these.
  CLI::Option* Offer(CLI::Option* option, Names names);
  static const char* const kCommandFooter;
  void AddGlobalOptions();
  void AddConfigCommands();
  void AddRunCommands();
  void AddCompletion();
  void AddGraph();
  void AddSimulate();
  void AddMachineCommands();
  void AddSwitchingCommands();
  void AddRecordCommands();
  void AddPolicyCommands();
  void AddKeysCommands();
  void AddOtaCommands();
  std::string ErrorText(const CLI::ParseError& e) const;
  void TakeEnvironment();
  void TakeGlobalOptions();

  std::unique_ptr<CLI::App> app_;
  std::string group_;  // help group of the commands that are added next
  std::map<const CLI::Option*, Names> offers_;
  std::map<const CLI::Option*, std::vector<std::string>> choices_;
  GlobalOptions global_;
  std::string name_space_;
  std::string colour_;
  double timeout_s_ = 0;
  CLI::Option* namespace_ = nullptr;
  CLI::Option* timeout_ = nullptr;
  std::function<CommandOptions()> take_command_;
};

}  // namespace musher::cli
