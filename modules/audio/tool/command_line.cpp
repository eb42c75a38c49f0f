#include <CLI/CLI.hpp>

#include "musher/modules/audio/tool/options.hpp"

namespace musher::audio::tool {
namespace {

constexpr const char* kDescription =
    "Lets the robot speak, through the topics and services of the audio module.";

constexpr const char* kFooter = R"(
Examples:
  musher-audio say "Good morning"      speak, and return at the end of the sound
  musher-audio say 早上好 --now         interrupt what plays, do not wait
  musher-audio play 9000               a phrase
  musher-audio stop                    silence, also for all that waits
  musher-audio volume                  how loud it is
  musher-audio volume 40               make it 40 %
  musher-audio phrases                 list the phrases and their numbers

Exit codes: 0 done; 1 refused, failed or no reply (reason on stderr); 2 wrong usage;
130 interrupted.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

constexpr int kMostPlayId = 65'535;

class Grammar {
 public:
  Grammar() {
    program::SetUpCommandLineTool(app_, global_, "Clock of the 15 s timeout; topic: /clock",
                                  kFooter);
    app_.add_option("--phrases", global_.phrases,
                    "The table of phrases to list; default the one installed with this program")
        ->type_name("FILE");
    AddSay();
    AddPlay();
    AddVolume();
    app_.add_subcommand("stop", "End what plays and all that waits")->callback([this] {
      command_ = StopOptions{};
    });
    app_.add_subcommand("phrases", "Show the phrases of the table")->callback([this] {
      command_ = PhrasesOptions{};
    });
  }

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv) {
    if (auto end = program::Parse(app_, argc, argv, global_)) return *std::move(end);
    return CommandLine{global_, command_};
  }

 private:
  void AddSay() {
    CLI::App* command = app_.add_subcommand("say", "Speak a text, Chinese or English");
    command->add_option("TEXT", text_, "What to say")->required()->type_name("");
    AddNow(command);
    command->callback([this] {
      play_.text = text_;
      command_ = play_;
    });
  }

  void AddPlay() {
    CLI::App* command = app_.add_subcommand("play", "Play a phrase");
    command->add_option("ID", play_.play_id, "Its number; see musher-audio phrases")
        ->required()
        ->check(CLI::Range(0, kMostPlayId).description(""))
        ->type_name("");
    AddNow(command);
    command->callback([this] { command_ = play_; });
  }

  void AddNow(CLI::App* command) {
    command->add_flag("--now", play_.now, "Interrupt what plays, and do not wait");
  }

  void AddVolume() {
    CLI::App* command = app_.add_subcommand("volume", "Show or set the volume");
    command->add_option("PERCENT", volume_.percent, "0 to 100")
        ->check(CLI::Range(0, 100).description(""))
        ->type_name("");
    command->callback([this] { command_ = volume_; });
  }

  CLI::App app_{kDescription, "musher-audio"};
  GlobalOptions global_;
  std::string text_;
  PlayOptions play_;
  VolumeOptions volume_;
  CommandOptions command_;
};

}  // namespace

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv) {
  return Grammar().Parse(argc, argv);
}

}  // namespace musher::audio::tool
