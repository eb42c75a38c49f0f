#include <CLI/CLI.hpp>

#include "musher/modules/camera/tool/options.hpp"

namespace musher::camera::tool {
namespace {

using program::Between;

constexpr const char* kDescription = "Shows and saves the robot's pictures from the command line.";

constexpr const char* kFooter = R"(
Examples:
  musher-camera list                             which pictures come, how large and how often
  musher-camera shot image_rgb now.png           one picture into a file
  musher-camera strip image_rgb walk.png --every 2 --count 8
                                                 what was seen over time, side by side
  musher-camera strip image_left race.jpg --beside image_rgb --beside image_right \
      --changes race/behavior_state --on-demand --count 40
                                                 three cameras in each state of an application
  musher-camera watch image_rgb                  rate, age and loss, each second

Topics are relative to the namespace. A picture's age is by the clock that its stamp is of:
--clock topic where the robot is in a simulated world.
Exit codes: 0 done; 1 nothing came, or a file cannot be written (reason on stderr); 2 wrong usage;
130 interrupted with nothing to show. A strip that is interrupted is written as far as it is.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

CLI::Validator PictureFile() {
  return {[](std::string& file) {
            for (const char* ending : {".png", ".jpg", ".jpeg", ".bmp"}) {
              if (file.size() > std::string(ending).size() && file.ends_with(ending)) return "";
            }
            return "a picture's file ends with .png, .jpg or .bmp";
          },
          ""};
}

constexpr double kLongestS = 86'400;

class Grammar {
 public:
  Grammar() {
    program::SetUpCommandLineTool(app_, global_, "Clock of the pictures' stamps; topic: /clock",
                                  kFooter);
    AddList();
    AddShot();
    AddStrip();
    AddWatch();
  }

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv) {
    if (auto end = program::Parse(app_, argc, argv, global_)) return *std::move(end);
    return CommandLine{global_, command_};
  }

 private:
  void AddList() {
    CLI::App* command = app_.add_subcommand("list", "List the topics with pictures");
    command->add_option("TOPICS", list_.topics, "Topics; default those of a CyberDog")
        ->type_name("");
    AddSeconds(command, "--seconds", list_.seconds, "How long to look; default 2");
    command->callback([this] { command_ = list_; });
  }

  void AddShot() {
    CLI::App* command = app_.add_subcommand("shot", "Save the next picture");
    AddTopicAndFile(command, shot_.topic, shot_.file);
    AddSeconds(command, "--timeout", shot_.timeout_s, "How long to wait for it; default 10");
    command->callback([this] { command_ = shot_; });
  }

  void AddStrip() {
    CLI::App* command = app_.add_subcommand("strip", "Save pictures over time, side by side");
    AddTopicAndFile(command, strip_.topic, strip_.file);
    AddSeconds(command, "--every", strip_.every_s, "From one to the next; default 2");
    CLI::Option* changes = command->add_option(
        "--changes", strip_.changes,
        "One --every seconds after each change of this topic's text (std_msgs/String), "
        "with the text under it");
    changes->type_name("TOPIC");
    command
        ->add_option("--beside", strip_.beside,
                     "Another camera, whose picture of that moment is beside it; repeatable")
        ->type_name("TOPIC");
    command
        ->add_flag("--on-demand", strip_.on_demand,
                   "With --changes: subscribe to the pictures only until a change has its own")
        ->needs(changes);
    command->add_option("--count", strip_.count, "How many; default 8")
        ->check(Between(1, 200))
        ->type_name("N");
    command->add_option("--columns", strip_.columns, "How many side by side; default up to 8")
        ->check(Between(1, 50))
        ->type_name("N");
    command->add_option("--width", strip_.width_px, "Of each in pixels; default 320")
        ->check(Between(32, 2048))
        ->type_name("PX");
    AddSeconds(command, "--timeout", strip_.timeout_s,
               "Without a picture, after which it is written as it is; default 30");
    command->callback([this] { command_ = strip_; });
  }

  void AddWatch() {
    CLI::App* command = app_.add_subcommand("watch", "Show rate, age and loss");
    command->add_option("TOPIC", watch_.topic, "Of the pictures")->required()->type_name("");
    AddSeconds(command, "--seconds", watch_.seconds, "How long; default until Ctrl-C");
    AddSeconds(command, "--timeout", watch_.timeout_s, "How long to wait for one; default 10");
    command->callback([this] { command_ = watch_; });
  }

  static void AddTopicAndFile(CLI::App* command, std::string& topic, std::string& file) {
    command->add_option("TOPIC", topic, "Of the pictures")->required()->type_name("");
    command->add_option("FILE", file, "A .png, .jpg or .bmp")
        ->required()
        ->check(PictureFile())
        ->type_name("");
  }

  static void AddSeconds(CLI::App* command, const std::string& name, double& seconds,
                         const std::string& help) {
    command->add_option(name, seconds, help)->check(Between(0.01, kLongestS))->type_name("S");
  }

  CLI::App app_{kDescription, "musher-camera"};
  ToolOptions global_;
  ListOptions list_;
  ShotOptions shot_;
  StripOptions strip_;
  WatchOptions watch_;
  CommandOptions command_;
};

}  // namespace

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv) {
  return Grammar().Parse(argc, argv);
}

}  // namespace musher::camera::tool
