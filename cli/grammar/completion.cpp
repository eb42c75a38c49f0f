// Completion of a command line. It reads the grammar itself, so no second list of options exists.

#include <CLI/CLI.hpp>
#include <algorithm>

#include "musher/cli/grammar/grammar.hpp"

namespace musher::cli {
namespace {

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

}  // namespace musher::cli
