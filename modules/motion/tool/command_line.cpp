#include <CLI/CLI.hpp>
#include <cmath>
#include <map>

#include "musher/modules/motion/motion_source.hpp"
#include "musher/modules/motion/tool/options.hpp"

namespace musher::motion::tool {
namespace {

using program::Between;

constexpr const char* kDescription =
    "Moves the robot's body from the command line, through the topics and services of the motion "
    "manager.";

constexpr const char* kFooter = R"(
Examples:
  musher-motion result 111                      stand up
  musher-motion result 101                      lie down
  musher-motion result 212 --duration 1000      a pose, held for a second
  musher-motion servo --vx 0.3 --seconds 3      walk ahead for 3 s
  musher-motion walk --square 1.0               walk a square of 1 m, to the left
  musher-motion status                          what the body does
  musher-motion list                            what it can do

Exit codes: 0 done; 1 refused, failed or no reply (reason on stderr); 2 wrong usage;
130 interrupted. A walk that is interrupted is stopped.
Environment: MUSHER_NAMESPACE, ROS_DOMAIN_ID, MUSHER_TRANSPORT, MUSHER_KEYS, MUSHER_IDENTITY.)";

class Grammar {
 public:
  Grammar() {
    program::SetUpCommandLineTool(app_, global_, "Clock of --seconds and 20 Hz; topic: /clock",
                                  kFooter);
    AddGlobalOptions();
    AddResult();
    AddServo();
    AddWalk();
    app_.add_subcommand("status", "Show the body's present motion")->callback([this] {
      command_ = StatusOptions{};
    });
    app_.add_subcommand("list", "Show the motions of the table")->callback([this] {
      command_ = ListOptions{};
    });
  }

  std::variant<CommandLine, ParseEnd> Parse(int argc, const char* const* argv) {
    if (auto end = program::Parse(app_, argc, argv, global_)) return *std::move(end);
    return CommandLine{global_, command_};
  }

 private:
  void AddGlobalOptions() {
    app_.add_option("--motions", global_.motions,
                    "The motion id table; default the one installed with this program")
        ->type_name("FILE");
  }

  void AddSource(CLI::App* command, std::int32_t& source) {
    const std::map<std::string, std::int32_t> sources = {
        {"debug", kFromDebug}, {"app", kFromApp},           {"audio", kFromAudio},
        {"vis", kFromVision},  {"blutele", kFromBluetooth}, {"algo", kFromAlgorithm}};
    command
        ->add_option("--source", source,
                     "Source of the command: debug, app, audio, vis, blutele, algo")
        ->transform(CLI::CheckedTransformer(sources).description(""))
        ->type_name("NAME");
  }

  void AddResult() {
    CLI::App* command = app_.add_subcommand("result", "Do one motion and wait for its end");
    MotionArguments& arguments = result_.requested.arguments;
    command->add_option("ID", result_.requested.id, "A motion id; see musher-motion list")
        ->required()
        ->type_name("");
    command->add_option("--duration", arguments.duration_ms, "In ms, for motions that need one")
        ->type_name("MS");
    command->add_option("--vel", arguments.vel_des, "Speed: x y in m/s, yaw in rad/s")
        ->type_name("X Y YAW");
    command->add_option("--rpy", arguments.rpy_des, "Roll, pitch, yaw in rad")->type_name("R P Y");
    command->add_option("--pos", arguments.pos_des, "Position in m")->type_name("X Y Z");
    command->add_option("--step-height", arguments.step_height, "Front and rear, in m")
        ->type_name("F R");
    command->add_option("--value", arguments.value, "Its meaning depends on the motion")
        ->type_name("N");
    AddSource(command, result_.source);
    command->callback([this] { command_ = result_; });
  }

  void AddServo() {
    CLI::App* command = app_.add_subcommand("servo", "Walk for a time, by 20 frames a second");
    command->add_option("--id", servo_.id, "A servo motion; default 303, the slow trot")
        ->type_name("ID");
    command->add_option("--vx", servo_.speed[0], "Ahead, in m/s")
        ->type_name("M/S")
        ->check(Between(-10, 10));
    command->add_option("--vy", servo_.speed[1], "To the left, in m/s")
        ->type_name("M/S")
        ->check(Between(-10, 10));
    command->add_option("--yaw", servo_.speed[2], "To the left, in rad/s")
        ->type_name("RAD/S")
        ->check(Between(-10, 10));
    command->add_option("--seconds", servo_.seconds, "How long; default 1")
        ->check(Between(0.05, 3600))
        ->type_name("S");
    AddSource(command, servo_.source);
    command->callback([this] { command_ = servo_; });
  }

  void AddWalk() {
    CLI::App* command =
        app_.add_subcommand("walk", "Walk a square to the left, back to the beginning");
    command->add_option("--square", walk_.square_m, "Its side, in m; default 1")
        ->check(Between(0.1, 100))
        ->type_name("M");
    command->add_option("--speed", walk_.speed, "In m/s; default 0.3")
        ->check(Between(0.05, 1.6))
        ->type_name("M/S");
    AddSource(command, walk_.source);
    command->callback([this] { command_ = walk_; });
  }

  CLI::App app_{kDescription, "musher-motion"};
  GlobalOptions global_;
  ResultOptions result_;
  ServoOptions servo_;
  WalkOptions walk_;
  CommandOptions command_;
};

}  // namespace

std::variant<CommandLine, ParseEnd> ParseCommandLine(int argc, const char* const* argv) {
  return Grammar().Parse(argc, argv);
}

}  // namespace musher::motion::tool
