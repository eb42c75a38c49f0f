#pragma once
// The grammar of `musher`'s command line, built with CLI11. The commands add themselves
// (commands/), so that it knows none of them.

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "musher/cli/console/console.hpp"
#include "musher/cli/console/exit_code.hpp"
#include "musher/cli/console/options.hpp"

namespace CLI {
class App;
class Option;
class ParseError;
}  // namespace CLI

namespace musher::cli {

// A command with its own options; prints its result to the console.
using RunCommand = std::function<ExitCode(const GlobalOptions&, Console&)>;

struct CommandLine {
  GlobalOptions global;
  RunCommand run;
};

// No command to run: the caller requested help, or the command line is wrong.
struct ParseEnd {
  ExitCode exit = ExitCode::kDone;
  std::string out;    // help or version
  std::string err;    // what is wrong
  bool json = false;  // with `err`: --json was given
};

// What an argument can name: part of the robot, or a file.
enum class Names {
  kNone,
  kStates,
  kActuators,
  kApplications,   // state machines and trees
  kStateMachines,  // applications
  kTrees,          // applications
  kCommands,       // of the application on the command line
  kCapabilities,
  kSkills,
  kSkillKeys,       // "altitude=", of the skill on the command line
  kSkillActuators,  // those that offer skills
  kTopics,          // of the domain
  kConfigs,         // .toml files and folders
  kDrawings,        // .toml and .xml files and folders
  kTreeFiles,       // .xml files and folders
  kFiles,
  kFolders
};

// What the last word of a command line can be, as far as the grammar knows it.
struct CompleteOptions {
  struct Word {
    std::string text;
    std::string meaning;
  };
  std::vector<Word> words;  // from the grammar
  Names names = Names::kNone;
  std::string begin;   // prefix that each completion must have
  std::string prefix;  // text already typed before it: "--format="
  std::string config;  // complete names of this config; empty: of the running machine
  std::string application;
  std::string skill;  // on the command line
};

// A command that was added: CLI11's part of it, and its options, which CLI11 fills in when it
// parses.
template <class Options>
struct Added {
  CLI::App& app;
  Options& options;
};

// A check of an option: a number in the range. Not CLI::Range, for which "nan" is in every range.
std::function<std::string(const std::string&)> Between(double least, double most,
                                                       const std::string& unit);

class Grammar {
 public:
  Grammar();
  ~Grammar();
  Grammar(const Grammar&) = delete;
  Grammar& operator=(const Grammar&) = delete;

  // The group of the help to which the commands that follow belong.
  void Group(std::string title);

  // Adds a command, which is run with its options. `what` is its line in the help, `example`
  // ("musher set LowPower") stands below its own help.
  template <class Options>
  Added<Options> Add(const std::string& name, const std::string& what,
                     ExitCode (*run)(const Options&, const GlobalOptions&, Console&),
                     const std::string& example) {
    const auto options = std::make_shared<Options>();
    return {AddTo(nullptr, name, what, WithOptions(options, run), example), *options};
  }
  CLI::App& Add(const std::string& name, const std::string& what,
                ExitCode (*run)(const GlobalOptions&, Console&), const std::string& example) {
    return AddTo(nullptr, name, what, run, example);
  }
  // A command with subcommands, and the example of one of them.
  CLI::App& AddFamily(const std::string& name, const std::string& what, const std::string& example);
  // Adds a subcommand of `family`.
  template <class Options>
  Added<Options> Add(const std::string& name, const std::string& what,
                     ExitCode (*run)(const Options&, const GlobalOptions&, Console&),
                     CLI::App* family) {
    const auto options = std::make_shared<Options>();
    return {AddTo(family, name, what, WithOptions(options, run), ""), *options};
  }
  CLI::App& Add(const std::string& name, const std::string& what,
                ExitCode (*run)(const GlobalOptions&, Console&), CLI::App* family) {
    return AddTo(family, name, what, run, "");
  }

  // The parser accepts only these words; completion offers them.
  CLI::Option* OneOf(CLI::Option* option, const std::vector<std::string>& words);
  // Completion offers these words; the option checks its value itself.
  CLI::Option* Suggest(CLI::Option* option, const std::vector<std::string>& words);
  // Completion offers these.
  CLI::Option* Offer(CLI::Option* option, Names names);

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv);

  // The possible completions of the last of these words, which is unfinished, and the options of
  // every command as given. `words` starts after the program's name.
  std::pair<GlobalOptions, CompleteOptions> Complete(const std::vector<std::string>& words);

  // Every command with each of its arguments and options, see command_line.hpp.
  std::vector<std::string> Lines() const;

 private:
  class Walk;

  template <class Options>
  static RunCommand WithOptions(std::shared_ptr<Options> options,
                                ExitCode (*run)(const Options&, const GlobalOptions&, Console&)) {
    return [options = std::move(options), run](const GlobalOptions& global, Console& console) {
      return run(*options, global, console);
    };
  }
  CLI::App& AddTo(CLI::App* family, const std::string& name, const std::string& what,
                  RunCommand run, const std::string& example);
  void AddGlobalOptions();
  bool IsOfGlobalOption(std::string_view error) const;
  static std::string OtherWord(std::string_view word);
  std::string ErrorText(const CLI::ParseError& e) const;
  void TakeEnvironment();
  void TakeGlobalOptions();

  std::unique_ptr<CLI::App> app_;
  std::string group_;
  std::map<const CLI::Option*, Names> offers_;
  std::map<const CLI::Option*, std::vector<std::string>> choices_;
  GlobalOptions global_;
  std::string name_space_;
  std::string colour_;
  double timeout_s_ = 0;
  CLI::Option* namespace_ = nullptr;
  CLI::Option* timeout_ = nullptr;
  RunCommand run_;
};

}  // namespace musher::cli
