#include "musher/controller/cli/command_line.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <functional>
#include <sstream>

#include "musher/lifecycle/suggest.hpp"

namespace musher::cli {
namespace {

constexpr const char* kDescription =
    "Musher drives a team of robot processes: it starts them, switches all of them between states\n"
    "such as Active, LowPower and Error, and says for certain how every switch ended.";

constexpr const char* kFooter = R"(
A first tour:
  musher check robot.toml          find every fault of a config
  musher up robot.toml             start the machine; Ctrl-C takes it down
  musher status --watch            (another terminal) see it live
  musher plan LowPower             what a switch would do, without doing it
  musher set LowPower              switch the machine
  musher set Active audio          switch one actuator
  musher restart audio             end its process and start it again
  musher estop "smoke"             stop everything that moves, now; --release ends that
  musher history --since 10m       what happened
  musher history --why             why the machine is in its state
  musher replay journal.sqlite     the same decisions once more, without a robot
  musher keys init robot.toml      from now on let in only those with keys
  musher down                      take the machine down

Exit codes: 0 done; 1 refused, undone or done without some (reason on stderr); 2 wrong usage or
config; 3 no controller found; 4 the controller did not answer in time; 130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS,
MUSHER_IDENTITY, CYCLONEDDS_URI, NO_COLOR.)";

constexpr const char* kCommandFooter =
    "\nOptions of every command (--json, --namespace, --domain, ...): musher --help";

// Not CLI::Range, for which "nan" is in every range.
CLI::Validator InSeconds() {
  return {[](const std::string& text) {
            double seconds = 0;
            const bool good =
                CLI::detail::lexical_cast(text, seconds) && seconds >= 0.001 && seconds <= 1e6;
            return good ? std::string() : text + " is not between 0.001 and 1000000 seconds";
          },
          ""};
}

bool IsNamespace(const std::string& text) {
  if (text.empty()) return true;
  bool at_begin = true;  // of a part between slashes
  for (const char c : text) {
    if (c == '/' ? at_begin : !(std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_')) {
      return false;
    }
    if (at_begin && std::isdigit(static_cast<unsigned char>(c)) != 0) return false;
    at_begin = c == '/';
  }
  return !at_begin && text.size() <= 200;
}

class Grammar {
 public:
  Grammar() {
    app_.require_subcommand(1);
    app_.fallthrough();
    app_.footer(kFooter);
    app_.get_formatter()->column_width(32);
    app_.get_formatter()->label("SUBCOMMAND", "COMMAND");
    app_.get_formatter()->label("REQUIRED", "");
    app_.set_version_flag("--version", "musher " MUSHER_VERSION, "Print the version");
    app_.set_help_flag("-h,--help", "Print this help");
    AddGlobalOptions();
    AddConfigCommands();
    AddMachineCommands();
    AddKeysCommands();
  }

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv) {
    try {
      app_.parse(argc, argv);
      TakeGlobalOptions();
    } catch (const CLI::ParseError& e) {
      std::ostringstream out;
      std::ostringstream ignored;
      if (app_.exit(e, out, ignored) == 0) return ParseEnd{ExitCode::kDone, out.str(), "", false};
      return ParseEnd{ExitCode::kUsage, "", Complaint(e), false};
    }
    return CommandLine{global_, take_command_()};
  }

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

  void AddGlobalOptions() {
    app_.add_flag("--json", global_.json, "Print JSON: one document, or one on each line");
    namespace_ = app_.add_option("--namespace", name_space_,
                                 "Namespace of the machine, as in its config;\n"
                                 "default $MUSHER_NAMESPACE, else none")
                     ->type_name("NAME");
    app_.add_option("--domain", global_.domain, "DDS domain; default $ROS_DOMAIN_ID, else 0")
        ->check(CLI::Range(0, 232).description(""))
        ->type_name("N");
    app_.add_option("--transport", global_.transport,
                    "local: machines on this host; lan: also on others;\n"
                    "default $MUSHER_TRANSPORT, else local (up: as its config says)")
        ->check(CLI::IsMember({"local", "lan"}).description(""))
        ->type_name("local|lan");
    timeout_ = app_.add_option("--timeout", timeout_s_,
                               "How long to wait for the controller's answer;\n"
                               "default 60 for set, down and restart, else 5")
                   ->check(InSeconds())
                   ->type_name("SECONDS");
    app_.add_option("--keys", global_.keys,
                    "Folder with the keys of a machine that has [security];\n"
                    "default $MUSHER_KEYS, else none")
        ->type_name("FOLDER");
    app_.add_option("--identity", global_.identity,
                    "Whose keys; default $MUSHER_IDENTITY, else operator")
        ->type_name("NAME");
    app_.add_option("--color", colour_,
                    "When to colour; auto: on a terminal, unless NO_COLOR is set")
        ->check(CLI::IsMember({"auto", "always", "never"}).description(""))
        ->type_name("auto|always|never");
  }

  void AddConfigCommands() {
    auto check = std::make_shared<CheckOptions>();
    auto* command = AddCommand("check", "Report every fault of a state config", check);
    command->add_option("FILE", check->files, "State configs (TOML)")->required()->type_name("");

    auto up = std::make_shared<UpOptions>();
    command = AddCommand("up", "Start a machine and stay with it; Ctrl-C takes it down", up);
    command->add_option("FILE", up->file, "State config (TOML)")->required()->type_name("");
    command->add_flag("-d,--detach", up->detach,
                      "Return when the start has ended; the machine stays up");
    command->add_flag("--takeover", up->takeover,
                      "End a controller that leads this machine; its actuators\n"
                      "go on and are taken over");

    auto graph = std::make_shared<GraphOptions>();
    command = AddCommand("graph", "Draw the states of a config, or its actuators", graph);
    command->add_option("FILE", graph->file, "State config (TOML)")->required()->type_name("");
    command
        ->add_option("--what", graph->what,
                     "flow: which state follows which (default);\n"
                     "actuators: their stages and what comes after what")
        ->check(CLI::IsMember({"flow", "actuators"}).description(""))
        ->type_name("flow|actuators");
    command
        ->add_option("--format", graph->format,
                     "svg needs Graphviz; default: by the output file's name, else dot")
        ->check(CLI::IsMember({"dot", "mermaid", "svg"}).description(""))
        ->type_name("dot|mermaid|svg");
    command->add_option("-o,--output", graph->output, "Default standard output")->type_name("FILE");

    AddSimulate();

    auto completion = std::make_shared<CompletionOptions>();
    command = AddCommand("completion", "Print the completion script of a shell", completion);
    command->add_option("SHELL", completion->shell, "bash or zsh")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh"}).description(""))
        ->type_name("");
  }

  void AddSimulate() {
    auto simulate = std::make_shared<SimulateOptions>();
    auto* command =
        AddCommand("simulate", "Live through thousands of faults with a state config", simulate);
    command->add_option("FILE", simulate->file, "The state config")->required()->type_name("");
    auto* seeds =
        command->add_option("--seeds", simulate->seeds, "How many stories; default 1000")
            ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{100'000'000}).description(""))
            ->type_name("N");
    command->add_option("--seed", simulate->seed, "Tell the story of this seed")
        ->excludes(seeds)
        ->type_name("N");
    command->add_option("--only", simulate->only, "Only these of its incidents, as in 3,7")
        ->type_name("LIST");
    command
        ->add_option("--bound", simulate->bound_s,
                     "Seconds in which the machine has to be at\n"
                     "rest once faults have ceased; default: by\n"
                     "the config's times and restarts")
        ->check(CLI::Range(0.001, 1e9).description(""))
        ->type_name("SECONDS");
    command->add_option("--home", simulate->home, "Where people bring it back to; default Active")
        ->type_name("STATE");
    command->add_option("--svg", simulate->svg, "Draw the shortest bad story, or the one told")
        ->type_name("FILE");
    command->add_option("-j,--jobs", simulate->jobs, "Threads; default all cores")
        ->check(CLI::Range(1U, 256U).description(""))
        ->type_name("N");
  }

  template <class Options>
  CLI::App* AddKeysCommand(CLI::App& keys, const std::string& name, const std::string& what,
                           std::shared_ptr<Options> options) {
    CLI::App* command = keys.add_subcommand(name, what);
    command->footer(kCommandFooter);
    command->callback([this, options] { take_command_ = [options] { return *options; }; });
    return command;
  }

  void AddKeysCommands() {
    CLI::App* keys = app_.add_subcommand("keys", "Make and revoke the keys that let a process in");
    keys->group("Commands");
    keys->require_subcommand(1);
    keys->footer(kCommandFooter);
    const auto add_days = [](CLI::App* command, int& days) {
      command->add_option("--days", days, "How long certificates are valid; default 730")
          ->check(CLI::Range(1, 3650).description(""))
          ->type_name("N");
    };

    auto init = std::make_shared<KeysInitOptions>();
    auto* command =
        AddKeysCommand(*keys, "init", "Make a machine's CAs and first identities", init);
    command
        ->add_option("WHERE", init->where,
                     "A state config with [security]: for the controller,\n"
                     "the operator and all its actuators; or a folder")
        ->required()
        ->type_name("");
    add_days(command, init->days);
    command->add_flag("--signed-only", init->signed_only,
                      "Data can be read on the network, not forged;\ndefault: encrypted, too");
    command->add_flag("--force", init->force, "Replace those that are there");

    auto add = std::make_shared<KeysAddOptions>();
    command = AddKeysCommand(*keys, "add", "Make one more identity", add);
    command->add_option("NAME", add->name, "An actuator's, or a person's")
        ->required()
        ->type_name("");
    command->add_option("--role", add->role, "What it may do; default actuator")
        ->check(CLI::IsMember({"controller", "actuator", "operator", "observer"}).description(""))
        ->type_name("controller|actuator|operator|observer");
    add_days(command, add->days);
    command->add_flag("--force", add->force, "Replace it, and revoke the one before");

    auto revoke = std::make_shared<KeysRevokeOptions>();
    command = AddKeysCommand(*keys, "revoke", "Let an identity in no more", revoke);
    command->add_option("NAME", revoke->name, "Whose certificate")->required()->type_name("");

    AddKeysCommand(*keys, "list", "Show who has keys, as what, until when",
                   std::make_shared<KeysListOptions>());
  }

  void AddMachineCommands() {
    AddCommand("down", "Take the machine down: TearDown, then end its processes",
               std::make_shared<DownOptions>());

    auto status = std::make_shared<StatusOptions>();
    auto* command = AddCommand("status", "Show the machine and its actuators", status);
    command->add_flag("-w,--watch", status->watch, "Show every change as it happens");

    auto set = std::make_shared<SetOptions>();
    command = AddCommand("set", "Switch the machine, or one actuator, to a state", set);
    command->add_option("STATE", set->state, "Active, LowPower, SelfCheck, ...")
        ->required()
        ->type_name("");
    command->add_option("ACTUATOR", set->actuator, "Only this one; default the whole machine")
        ->type_name("");

    auto restart = std::make_shared<RestartOptions>();
    command = AddCommand("restart", "End an actuator's process and start it again", restart);
    command->add_option("ACTUATOR", restart->actuator, "The one to restart")
        ->required()
        ->type_name("");

    auto estop = std::make_shared<EstopOptions>();
    command = AddCommand("estop", "Emergency stop: also without a controller", estop);
    auto* reason = command->add_option("REASON", estop->reason, "Why; told to everybody who asks")
                       ->type_name("");
    command
        ->add_flag("--release", estop->release,
                   "Release it; needs the controller, and changes no state")
        ->excludes(reason);

    auto plan = std::make_shared<PlanOptions>();
    command = AddCommand("plan", "Show what a switch would do; changes nothing", plan);
    command->add_option("STATE", plan->state, "The state to switch to")->required()->type_name("");
    command->add_option("ACTUATOR", plan->actuator, "Only this one; default the whole machine")
        ->type_name("");

    auto history = std::make_shared<HistoryOptions>();
    command = AddCommand("history", "Show what happened, oldest first", history);
    command->add_option("--since", history->since, "90s, 10m, 2h, 1d ago, or a date and time")
        ->type_name("TIME");
    command->add_option("--limit", history->limit, "The newest so many entries; default 1000")
        ->check(CLI::Range(1U, 1000U).description(""))
        ->type_name("N");
    command
        ->add_option("--journal", history->journal, "Read this file instead of asking a controller")
        ->type_name("FILE");
    command
        ->add_option("--why", history->why,
                     "Why the machine is in its state, or went\n"
                     "to STATE last: the chain of causes")
        ->expected(0, 1)
        ->type_name("[STATE]");

    auto replay = std::make_shared<ReplayOptions>();
    command = AddCommand("replay", "Decide once more what a journal recorded; compare", replay);
    command->add_option("JOURNAL", replay->journal, "A controller's journal.sqlite")
        ->required()
        ->type_name("");
    command->add_option("--config", replay->config, "Show what this state config would change")
        ->type_name("FILE");
    command->add_option("--since", replay->since, "90s, 10m, 2h, 1d ago, or a date and time")
        ->type_name("TIME");
    command->add_option("--epoch", replay->epoch, "Only what the controller of this epoch decided")
        ->type_name("N");
  }

  std::string Complaint(const CLI::ParseError& e) const {
    const auto unknown = app_.remaining();
    const bool has_command = !app_.get_subcommands().empty();
    if (!has_command && unknown.empty() && dynamic_cast<const CLI::RequiredError*>(&e) != nullptr) {
      return "a command is missing; see musher --help";
    }
    if (has_command || unknown.empty()) return std::string(e.what()) + "; see musher --help";
    std::vector<std::string> commands;
    for (const CLI::App* command : app_.get_subcommands({}))
      commands.push_back(command->get_name());
    const std::string near = Nearest(unknown.front(), commands);
    return "there is no command '" + unknown.front() + "'; " +
           (near.empty() ? "" : "did you mean '" + near + "'? ") + "see musher --help";
  }

  void TakeGlobalOptions() {
    global_.name_space_given = namespace_->count() > 0;
    const char* variable = std::getenv("MUSHER_NAMESPACE");  // NOLINT(concurrency-mt-unsafe)
    if (!global_.name_space_given && variable != nullptr) name_space_ = variable;
    if (!name_space_.empty() && name_space_.front() == '/') name_space_.erase(0, 1);
    if (!IsNamespace(name_space_)) {
      throw CLI::ValidationError("the namespace '" + name_space_ +
                                 "' is not made of names separated by '/', as in fleet/dog1");
    }
    global_.name_space = name_space_;
    const auto take = [](std::string& value, const char* source, const char* otherwise) {
      const char* set = std::getenv(source);  // NOLINT(concurrency-mt-unsafe)
      if (value.empty()) value = set != nullptr ? set : otherwise;
    };
    take(global_.keys, "MUSHER_KEYS", "");
    take(global_.identity, "MUSHER_IDENTITY", "operator");
    if (colour_ == "always") global_.colour = ColourWhen::kAlways;
    if (colour_ == "never") global_.colour = ColourWhen::kNever;
    if (timeout_->count() > 0) {
      global_.timeout = Milliseconds(std::llround(timeout_s_ * 1000));
    }
  }

  CLI::App app_{kDescription, "musher"};
  GlobalOptions global_;
  std::string name_space_;
  std::string colour_;
  double timeout_s_ = 0;
  CLI::Option* namespace_ = nullptr;
  CLI::Option* timeout_ = nullptr;
  std::function<CommandOptions()> take_command_;
};

}  // namespace

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv) {
  auto parsed = Grammar().Parse(argc, argv);
  if (auto* end = std::get_if<ParseEnd>(&parsed)) {
    // The parser may not have come as far as --json.
    end->json = std::find(argv, argv + argc, std::string_view("--json")) != argv + argc;
  }
  return parsed;
}

}  // namespace musher::cli
