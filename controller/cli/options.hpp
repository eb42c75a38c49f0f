#pragma once
// The options of `musher`'s commands as values. command_line.hpp makes them from argv.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/base/time.hpp"

namespace musher::cli {

enum class ColourWhen { kAuto, kAlways, kNever };

struct GlobalOptions {
  bool json = false;
  std::string name_space;                // without outer '/'
  bool name_space_given = false;         // by --namespace, not by the environment
  std::optional<int> domain;             // none: ROS_DOMAIN_ID, else 0
  std::optional<std::string> transport;  // "local" or "lan"; none: MUSHER_TRANSPORT, else local
  std::optional<Duration> timeout;       // for the controller's answer; none: the command's own
  ColourWhen colour = ColourWhen::kAuto;
  std::string keys;      // folder with credentials; empty: none are used
  std::string identity;  // whose credentials
};

struct CheckOptions {
  std::vector<std::string> files;
};
struct UpOptions {
  std::string file;  // or an upgrade root
  bool detach = false;
  bool takeover = false;  // replace a running controller
  bool adopt = false;     // take control of actuators that run with another config, too
  // A supervisor may restart it after a crash: complete a TearDown that was under way.
  bool restarted = false;
  // For a controller that restarts itself: its connection to the launcher, and the launcher's pid
  // or 0.
  struct Resume {
    int progress = -1;
    int launcher = 0;
  };
  std::optional<Resume> resume;
};
struct DownOptions {
  bool without_controller = false;  // stop the actuators that run without a controller
};
struct StatusOptions {
  bool watch = false;
};
struct SetOptions {
  std::string state;
  std::string actuator;  // empty: the whole machine
};
struct RestartOptions {
  std::string actuator;
};
struct EstopOptions {
  std::vector<std::string> reason;  // words
  bool release = false;
};
struct CapabilitiesOptions {
  std::string name;  // empty: all
};
struct WakeOptions {};
struct KeepOptions {
  std::string state;
  std::int64_t seconds = 0;
  bool end = false;
};
struct LowPowerOptions {
  bool on = false;
  bool this_run = false;  // else it is saved
};
struct PowerOffOptions {};
struct RebootOptions {};
struct PlanOptions {
  std::string state;
  std::string actuator;
};
struct HistoryOptions {
  std::string since;      // empty: all
  std::string until;      // empty: all
  std::string actuator;   // empty: of all, and of the machine
  std::string journal;    // empty: query the controller
  unsigned limit = 1000;  // 0: no limit
  bool csv = false;
  bool follow = false;             // then print new entries
  std::optional<std::string> why;  // explain this state instead; empty: the current one
};
struct ReplayOptions {
  std::string journal;
  std::string config;  // empty: the recorded one
  std::string since;   // empty: all
  std::optional<std::uint64_t> epoch;
};
struct BehaviorOptions {
  std::string name;
  std::uint32_t history = 10;  // changes
  bool watch = false;
  std::string send;  // a command; empty: only show the state machine
};
struct GraphOptions {
  std::string file;           // empty: draw `behavior`
  std::string behavior;       // the application whose state machine is drawn; empty: a config
  std::string what = "flow";  // or "actuators"
  std::string format;         // "dot", "mermaid" or "svg"
  std::string output;         // empty: standard output
};
struct SimulateOptions {
  std::string file;
  std::uint64_t seeds = 1000;
  std::optional<std::uint64_t> seed;  // show only the run of this seed
  std::string only;                   // inject only these of its events: "3,7"; empty: all
  std::optional<double> bound_s;      // within which the machine must reach a stable state
  std::string home;                   // the state that operators recover it to; empty: Active
  std::string svg;                    // file for the drawing of the failing or shown run
  unsigned jobs = 0;                  // threads; 0: one per core
};
struct KeysInitOptions {
  std::string where;  // a state config with [security], or a folder
  int days = 730;
  bool signed_only = false;
  bool force = false;
};
struct KeysAddOptions {
  std::string name;
  std::string role = "actuator";
  int days = 730;
  bool force = false;
};
struct KeysRevokeOptions {
  std::string name;
};
struct KeysListOptions {};
struct OtaKeygenOptions {
  std::string name;  // of the two files, without .key and .pub
};
struct OtaBundleOptions {
  std::string folder;
  std::string version;
  std::string min_version;  // may be empty
  std::string robot;        // empty: the machine's name, from the config
  std::string config = "robot.toml";
  std::string key;  // file of the private key
  std::string out;
};
struct OtaInitOptions {
  std::string root;
  std::string bundle;
  std::string key;  // file of the public key
  std::string config = "robot.toml";
};
struct OtaVerifyOptions {
  std::string bundle;
  std::string root;  // empty: $MUSHER_OTA_ROOT, else that of the running machine
  std::string key;   // for a bundle without a root
};
struct OtaInstallOptions {
  std::string bundle;
  std::string root;
  bool allow_downgrade = false;
};
struct OtaStatusOptions {
  std::string root;
};
struct OtaRollbackOptions {
  std::string root;
};
struct CompletionOptions {
  std::string shell;  // "bash" or "zsh"
};
// What an argument can name: part of the robot, or a file.
enum class Names {
  kNone,
  kStates,
  kActuators,
  kApplications,
  kCommands,  // of the application on the command line
  kCapabilities,
  kConfigs,  // .toml files and folders
  kFiles,
  kFolders
};
// `musher complete WORD...`: the completions of the last word. The installed scripts call it.
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
};

using CommandOptions =
    std::variant<CheckOptions, UpOptions, DownOptions, StatusOptions, SetOptions, RestartOptions,
                 EstopOptions, CapabilitiesOptions, WakeOptions, KeepOptions, LowPowerOptions,
                 PowerOffOptions, RebootOptions, PlanOptions, HistoryOptions, ReplayOptions,
                 BehaviorOptions, GraphOptions, SimulateOptions, KeysInitOptions, KeysAddOptions,
                 KeysRevokeOptions, KeysListOptions, OtaKeygenOptions, OtaBundleOptions,
                 OtaInitOptions, OtaVerifyOptions, OtaInstallOptions, OtaStatusOptions,
                 OtaRollbackOptions, CompletionOptions, CompleteOptions>;

struct CommandLine {
  GlobalOptions global;
  CommandOptions command;
};

}  // namespace musher::cli
