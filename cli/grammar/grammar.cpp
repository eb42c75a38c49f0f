#include "musher/cli/grammar/grammar.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <sstream>

#include "musher/base/suggest.hpp"
#include "musher/base/version.hpp"

namespace musher::cli {
namespace {

constexpr const char* kDescription =
    "Musher drives a team of robot processes: it starts them, switches all of them between states\n"
    "such as Active, LowPower and Error, and reports a definite outcome for every switch.";

constexpr const char* kFooter = R"(
A first tour:
  musher new robot rover           make a robot's config; new module NAME an actuator in C++
  musher doctor robot.toml         check this computer for what the robot needs
  musher check robot.toml          report every error in a config
  musher up robot.toml             start the machine; Ctrl-C takes it down
  musher status --follow           (another terminal) watch it live
  musher top                       CPU, memory and heartbeats, live
  musher describe audio            all about one actuator, and what to do next
  musher logs -f audio             what its process prints
  musher capabilities              what the robot can do now, and why not
  musher plan LowPower             show what a switch would do; changes nothing
  musher set LowPower              switch the machine
  musher set Active audio          switch one actuator
  musher restart audio             restart its process
  musher behavior show             an application's state machine: current state and last changes
  musher skill list                what the robot can do on request; skill run NAME does it
  musher estop "smoke"             emergency stop of all actuators, now; --release ends it
  musher history --since 10m       what happened
  musher history --why             why the machine is in its state
  musher replay journal.sqlite     re-run the recorded decisions, without a robot
  musher view                      show the robot in a browser
  musher record -o run.mcap        record it; musher play run.mcap publishes it again
  musher keys init robot.toml      from now on admit only processes with credentials
  musher ota install BUNDLE        install a version; roll back if it does not come up
  musher down                      take the machine down

Exit codes: 0 done; 1 refused, undone or done-degraded (reason on stderr); 2 wrong usage or
config; 3 no controller found; 4 the controller did not answer in time; 5 the controller exited
during the switch and no successor reports its outcome, or a skill's actuator is lost; 130
interrupted.
Environment: MUSHER_NAMESPACE, MUSHER_MACHINE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS,
MUSHER_IDENTITY, MUSHER_OTA_ROOT, CYCLONEDDS_URI, NO_COLOR.)";

// Of a command's help.
std::string Footer(const std::string& example) {
  return (example.empty() ? "" : "\nExample: " + example + "\n") +
         "\nOptions of every command (--json, --namespace, --domain, ...): musher --help";
}

constexpr std::string_view kInvalidNamespace = "invalid namespace '";

bool IsNamespace(const std::string& text) {
  if (text.empty()) return true;
  bool at_begin = true;  // at the first character of a part between slashes
  for (const char c : text) {
    if (c == '/' ? at_begin : !(std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_')) {
      return false;
    }
    if (at_begin && std::isdigit(static_cast<unsigned char>(c)) != 0) return false;
    at_begin = c == '/';
  }
  return !at_begin && text.size() <= 200;
}

bool IsShown(const CLI::Option* option) {
  return !option->get_group().empty();
}

bool TakesValue(const CLI::Option* option) {
  return option->get_items_expected_max() > 0;
}

std::string LongName(const CLI::Option* option) {
  return option->get_lnames().empty() ? "" : "--" + option->get_lnames().front();
}

std::string OneLine(std::string description) {
  std::replace(description.begin(), description.end(), '\n', ' ');
  return description;
}

std::vector<CLI::Option*> Positionals(CLI::App* command) {
  return command->get_options([](const CLI::Option* option) { return option->get_positional(); });
}

}  // namespace

std::function<std::string(const std::string&)> Between(double least, double most,
                                                       const std::string& unit) {
  return [=](const std::string& text) {
    double number = 0;
    const bool good = CLI::detail::lexical_cast(text, number) && number >= least && number <= most;
    return good ? "" : fmt::format("{} is not between {} and {} {}", text, least, most, unit);
  };
}

Grammar::Grammar() : app_(std::make_unique<CLI::App>(kDescription, "musher")) {
  app_->require_subcommand(1);
  app_->fallthrough();
  app_->footer(kFooter);
  app_->get_formatter()->column_width(32);
  app_->get_formatter()->label("SUBCOMMAND", "COMMAND");
  app_->get_formatter()->label("REQUIRED", "");
  app_->set_version_flag("--version", "musher " + std::string(Version()), "Print the version");
  app_->set_help_flag("-h,--help", "Print this help");
  AddGlobalOptions();
}

std::variant<CommandLine, ParseEnd> Grammar::Parse(int argc, const char* const* argv) {
  try {
    app_->parse(argc, argv);
    TakeGlobalOptions();
  } catch (const CLI::ParseError& e) {
    std::ostringstream out;
    std::ostringstream ignored;
    if (app_->exit(e, out, ignored) == 0) return ParseEnd{ExitCode::kDone, out.str(), "", false};
    return ParseEnd{ExitCode::kUsage, "", ErrorText(e), false};
  }
  return CommandLine{global_, run_};
}

Grammar::~Grammar() = default;

void Grammar::Group(std::string title) {
  group_ = std::move(title);
}

CLI::App& Grammar::AddTo(CLI::App* family, const std::string& name, const std::string& what,
                         RunCommand run, const std::string& example) {
  CLI::App* command = (family == nullptr ? *app_ : *family).add_subcommand(name, what);
  command->group(family == nullptr ? group_ : "Commands");
  command->footer(Footer(example));
  command->callback([this, run = std::move(run)] { run_ = run; });
  return *command;
}

CLI::App& Grammar::AddFamily(const std::string& name, const std::string& what,
                             const std::string& example) {
  CLI::App* family = app_->add_subcommand(name, what);
  family->group(group_);
  family->require_subcommand(1);
  family->footer(Footer(example));
  return *family;
}

CLI::Option* Grammar::OneOf(CLI::Option* option, const std::vector<std::string>& words) {
  choices_[option] = words;
  return option->check(CLI::IsMember(words).description(""))
      ->type_name(option->get_positional() ? "" : CLI::detail::join(words, "|"));
}

CLI::Option* Grammar::Suggest(CLI::Option* option, const std::vector<std::string>& words) {
  choices_[option] = words;
  return option;
}

CLI::Option* Grammar::Offer(CLI::Option* option, Names names) {
  offers_[option] = names;
  return option;
}

void Grammar::AddGlobalOptions() {
  app_->add_flag("--json", global_.json, "Print JSON: one document, or one on each line");
  namespace_ = app_->add_option("--namespace", name_space_,
                                "Namespace of the machine, as in its config;\n"
                                "default $MUSHER_NAMESPACE, else none")
                   ->type_name("NAME");
  app_->add_option("--machine", global_.machine,
                   "Name (or id) of the machine, if several answer;\n"
                   "default $MUSHER_MACHINE, else the one of this host")
      ->type_name("NAME");
  app_->add_option("--domain", global_.domain, "DDS domain; default $ROS_DOMAIN_ID, else 0")
      ->check(CLI::Range(0, 232).description(""))
      ->type_name("N");
  OneOf(app_->add_option("--transport", global_.transport,
                         "local: machines on this host; lan: also on others;\n"
                         "default $MUSHER_TRANSPORT, else local (up: as its config says)"),
        {"local", "lan"});
  timeout_ = app_->add_option("--timeout", timeout_s_,
                              "Time to wait for the controller's answer;\n"
                              "default 60 for set, wait, down and restart, else 5;\n"
                              "skill run: for the end of the skill, no default")
                 ->check(Between(0.001, 1e6, "seconds"))
                 ->type_name("SECONDS");
  Offer(app_->add_option("--keys", global_.keys,
                         "Folder with the credentials of a machine with [security];\n"
                         "default $MUSHER_KEYS, else none"),
        Names::kFolders)
      ->type_name("FOLDER");
  app_->add_option("--identity", global_.identity,
                   "Whose credentials; default $MUSHER_IDENTITY, else operator")
      ->type_name("NAME");
  OneOf(app_->add_option("--color", colour_,
                         "Colour the output; auto: on a terminal, unless NO_COLOR is set"),
        {"auto", "always", "never"});
}

// "; …" for a word of other tools, by what its user wants; empty: it is none. Who types `stop` may
// want the robot to stop at once: a command that is only spelled alike would not help.
std::string Grammar::OtherWord(std::string_view word) {
  for (const char* stop : {"stop", "halt", "kill", "abort", "quit"}) {
    if (word == stop) {
      return "; `musher estop` stops the robot at once, `musher down` ends the machine;";
    }
  }
  if (word == "start" || word == "launch" || word == "run") {
    return "; `musher up robot.toml` starts a machine;";
  }
  if (word == "ps" || word == "list") return "; `musher status` shows the actuators;";
  return "";
}

// "--domain: …": the help of a command does not list these options.
bool Grammar::IsOfGlobalOption(std::string_view error) const {
  if (error.starts_with(kInvalidNamespace)) return true;  // perhaps of the environment
  const auto options = app_->get_options();
  return std::any_of(options.begin(), options.end(), [error](const CLI::Option* option) {
    return error.starts_with(option->get_name() + ":");
  });
}

std::string Grammar::ErrorText(const CLI::ParseError& e) const {
  std::string help = "see musher";
  const CLI::App* command = app_.get();
  if (IsOfGlobalOption(e.what())) return std::string(e.what()) + "; " + help + " --help";
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
    help += " " + command->get_name();
  }
  help += " --help";
  const auto unknown = app_->remaining(/*recurse=*/true);
  std::vector<std::string> commands;
  for (const CLI::App* known : command->get_subcommands({})) commands.push_back(known->get_name());
  if (commands.empty()) return std::string(e.what()) + "; " + help;
  if (unknown.empty()) {
    const bool missing = dynamic_cast<const CLI::RequiredError*>(&e) != nullptr;
    return (missing ? "missing command" : std::string(e.what())) + "; " + help;
  }
  std::string hint = command == app_.get() ? OtherWord(unknown.front()) : "";
  if (hint.empty()) hint = DidYouMean(unknown.front(), commands);
  return "unknown command '" + unknown.front() + "'" + (hint.empty() ? ";" : hint) + " " + help;
}

void Grammar::TakeGlobalOptions() {
  global_.name_space_given = namespace_->count() > 0;
  global_.name_space = name_space_;
  TakeEnvironment();
  if (!IsNamespace(global_.name_space)) {
    throw CLI::ValidationError(
        fmt::format("{}{}'; expected names separated by '/' that begin with no digit, as in "
                    "fleet/dog1",
                    kInvalidNamespace, global_.name_space));
  }
  if (colour_ == "always") global_.colour = ColourWhen::kAlways;
  if (colour_ == "never") global_.colour = ColourWhen::kNever;
  if (timeout_->count() > 0) {
    global_.timeout = Milliseconds(std::llround(timeout_s_ * 1000));
  }
}

void Grammar::TakeEnvironment() {
  const auto take = [](std::string& value, const char* source, const char* otherwise) {
    const char* set = std::getenv(source);  // NOLINT(concurrency-mt-unsafe)
    if (value.empty()) value = set != nullptr ? set : otherwise;
  };
  if (!global_.name_space_given) take(global_.name_space, "MUSHER_NAMESPACE", "");
  if (global_.name_space.starts_with('/')) global_.name_space.erase(0, 1);
  take(global_.machine, "MUSHER_MACHINE", "");
  take(global_.keys, "MUSHER_KEYS", "");
  take(global_.identity, "MUSHER_IDENTITY", "operator");
}

std::vector<std::string> Grammar::Lines() const {
  std::vector<std::string> lines;
  const std::function<void(CLI::App*, const std::string&)> add = [&](CLI::App* command,
                                                                     const std::string& name) {
    for (const CLI::Option* option : command->get_options({})) {
      const bool help = option == command->get_help_ptr() || option == app_->get_version_ptr();
      if (!IsShown(option) || help) continue;
      lines.push_back(name + (option->get_positional() ? option->get_name() : LongName(option)));
    }
    const auto commands = command->get_subcommands({});
    if (commands.empty()) lines.push_back(name);
    for (CLI::App* one : commands) add(one, name + one->get_name() + " ");
  };
  add(app_.get(), "");
  for (std::string& line : lines) {
    if (line.ends_with(' ')) line.pop_back();
  }
  return lines;
}

// Completion of a command line. It reads the grammar itself, so no second list of options exists.
//
// Walks over the finished words as the parser does: into the command that they name, past its
// arguments, to an option whose value comes next.
class Grammar::Walk {
 public:
  explicit Walk(Grammar& grammar) : grammar_(grammar), command_(grammar.app_.get()) {}

  void Over(const std::string& word) {
    if (word == "=" && value_of_ != nullptr) return;  // bash splits --option=value into three words
    if (value_of_ != nullptr && !(word.starts_with('-') && value_of_->get_expected_min() == 0)) {
      return Take(std::exchange(value_of_, nullptr), word);
    }
    value_of_ = nullptr;
    if (std::exchange(after_equals_, false)) return;  // VALUE
    if (word == "=") {
      after_equals_ = true;
      return;
    }
    if (word == "--" || positionals_only_) {
      positionals_only_ = true;
      if (word != "--") TakePositional(word);
    } else if (word.starts_with('-')) {
      const std::size_t equals = word.find('=');
      const CLI::Option* option = Find(word.substr(0, equals));
      if (option == nullptr || !TakesValue(option)) return;
      if (equals == std::string::npos) {
        value_of_ = option;
      } else {
        Take(option, word.substr(equals + 1));
      }
    } else if (CLI::App* command = Subcommand(word)) {
      command_ = command;
      positionals_ = 0;
    } else if (command_ != grammar_.app_.get() || word != "help") {
      TakePositional(word);
    }
  }

  void At(std::string word, CompleteOptions& offer) {
    const std::size_t equals = word.find('=');
    if (value_of_ == nullptr && (after_equals_ || word == "=")) return;
    if (word == "=" && value_of_ != nullptr) {
      word.clear();
    } else if (word.starts_with("--") && equals != std::string::npos) {
      value_of_ = Find(word.substr(0, equals));
      if (value_of_ == nullptr || !TakesValue(value_of_)) return;
      offer.prefix = word.substr(0, equals + 1);
      word.erase(0, equals + 1);
    }
    offer.begin = word;
    offer.config = config_;
    offer.application = application_;
    offer.skill = skill_;
    if (value_of_ != nullptr && !word.starts_with('-')) return OfferValue(value_of_, offer);
    if (word.starts_with('-') && !positionals_only_) return OfferOptions(offer);
    for (CLI::App* command : command_->get_subcommands({})) {
      offer.words.push_back({command->get_name(), command->get_description()});
    }
    if (command_ == grammar_.app_.get()) offer.words.push_back({"help", "Print the help"});
    if (const CLI::Option* next = NextPositional()) OfferValue(next, offer);
  }

 private:
  CLI::App* Subcommand(const std::string& word) const {
    const auto all = command_->get_subcommands({});
    const auto found = std::find_if(all.begin(), all.end(), [&](const CLI::App* command) {
      return command->get_name() == word;
    });
    return found == all.end() ? nullptr : *found;
  }

  const CLI::Option* Find(const std::string& name) const {
    const CLI::Option* own = command_->get_option_no_throw(name);
    return own != nullptr ? own : grammar_.app_->get_option_no_throw(name);
  }

  // The last argument may take any number of words.
  const CLI::Option* NextPositional() const {
    const auto all = Positionals(command_);
    if (positionals_ < all.size()) return all[positionals_];
    const bool many = !all.empty() && all.back()->get_expected_max() > 1;
    return many ? all.back() : nullptr;
  }

  void TakePositional(const std::string& word) {
    if (const CLI::Option* option = NextPositional()) Take(option, word);
    ++positionals_;
  }

  // Keeps the values that decide which names are offered later.
  void Take(const CLI::Option* option, const std::string& word) {
    GlobalOptions& global = grammar_.global_;
    const auto offered = grammar_.offers_.find(option);
    const Names names = offered == grammar_.offers_.end() ? Names::kNone : offered->second;
    if (names == Names::kConfigs || names == Names::kDrawings) config_ = word;
    if (names == Names::kApplications) application_ = word;
    if (names == Names::kSkills) skill_ = word;
    const std::string name = LongName(option);
    if (name == "--namespace") {
      global.name_space = word;
      global.name_space_given = true;
    } else if (name == "--domain") {
      int domain = 0;
      if (CLI::detail::lexical_cast(word, domain)) global.domain = domain;
    } else if (name == "--transport") {
      global.transport = word;
    } else if (name == "--keys") {
      global.keys = word;
    } else if (name == "--identity") {
      global.identity = word;
    }
  }

  void OfferValue(const CLI::Option* option, CompleteOptions& offer) const {
    const auto names = grammar_.offers_.find(option);
    if (names != grammar_.offers_.end()) offer.names = names->second;
    const auto choices = grammar_.choices_.find(option);
    if (choices == grammar_.choices_.end()) return;
    for (const std::string& word : choices->second) offer.words.push_back({word, ""});
  }

  void OfferOptions(CompleteOptions& offer) const {
    const auto add = [&offer](CLI::App* of, bool with_version) {
      for (const CLI::Option* option : of->get_options({})) {
        const std::string name = LongName(option);
        if (name.empty() || option->get_positional() || !IsShown(option)) continue;
        if (name == "--version" && !with_version) continue;
        const bool known =
            std::any_of(offer.words.begin(), offer.words.end(),
                        [&](const CompleteOptions::Word& word) { return word.text == name; });
        if (!known) offer.words.push_back({name, OneLine(option->get_description())});
      }
    };
    add(command_, true);
    add(grammar_.app_.get(), false);
  }

  Grammar& grammar_;
  CLI::App* command_;
  std::size_t positionals_ = 0;
  bool positionals_only_ = false;          // after "--"
  const CLI::Option* value_of_ = nullptr;  // the next word is its value
  std::string config_;
  std::string application_;
  std::string skill_;
  bool after_equals_ = false;  // the last word is the '=' of KEY=VALUE, which bash splits
};

std::pair<GlobalOptions, CompleteOptions> Grammar::Complete(const std::vector<std::string>& words) {
  CompleteOptions offer;
  Walk walk(*this);
  for (std::size_t i = 0; i + 1 < words.size(); ++i) walk.Over(words[i]);
  walk.At(words.empty() ? "" : words.back(), offer);
  TakeEnvironment();
  return {global_, std::move(offer)};
}

}  // namespace musher::cli
