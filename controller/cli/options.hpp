#pragma once
// What a person can ask of `musher`, as values. command_line.hpp makes them from argv.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "musher/lifecycle/time.hpp"

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
  std::string keys;      // folder of keys; empty: none are used
  std::string identity;  // whose keys
};

struct CheckOptions {
  std::vector<std::string> files;
};
struct UpOptions {
  std::string file;  // or a root of upgrades
  bool detach = false;
  bool takeover = false;  // from a living controller
  bool adopt = false;     // actuators that run with another config, too
  // A supervisor may be starting it again after a crash: a TearDown that was begun is finished.
  bool restarted = false;
  // A controller that starts again: its connection to the front, and the front's pid or 0.
  struct Resume {
    int progress = -1;
    int front = 0;
  };
  std::optional<Resume> resume;
};
struct DownOptions {
  bool without_controller = false;  // end what runs, which none leads
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
  bool this_run = false;  // else it is remembered
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
  std::string journal;    // empty: ask the controller
  unsigned limit = 1000;  // 0: no limit
  bool csv = false;
  bool follow = false;             // then print what comes
  std::optional<std::string> why;  // explain this state instead; empty: the present one
};
struct ReplayOptions {
  std::string journal;
  std::string config;  // empty: the one that was recorded
  std::string since;   // empty: all
  std::optional<std::uint64_t> epoch;
};
struct BehaviorOptions {
  std::string name;
  std::uint32_t history = 10;  // changes
  bool watch = false;
  std::string send;  // a command; empty: it is only looked at
};
struct GraphOptions {
  std::string file;           // empty: of `behavior`
  std::string behavior;       // the application whose machine is drawn; empty: a config
  std::string what = "flow";  // or "actuators"
  std::string format;         // "dot", "mermaid" or "svg"
  std::string output;         // empty: standard output
};
struct SimulateOptions {
  std::string file;
  std::uint64_t seeds = 1000;
  std::optional<std::uint64_t> seed;  // tell this one scenario instead
  std::string only;                   // of its injected events: "3,7"; empty: all
  std::optional<double> bound_s;      // in which the machine has to come to rest
  std::string home;                   // where people bring it back to; empty: Active
  std::string svg;    // file for the picture of the failing scenario, or of the one told
  unsigned jobs = 0;  // threads; 0: as many as there are cores
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
  std::string root;  // empty: $MUSHER_OTA_ROOT, else that of the machine that runs
  std::string key;   // of a bundle that no root is there for
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
// What can be named on a command line: of the robot, or of the disk.
enum class Names {
  kNone,
  kStates,
  kActuators,
  kApplications,
  kCommands,  // of the application on the line
  kCapabilities,
  kConfigs,  // .toml files and folders
  kFiles,
  kFolders
};
// `musher complete WORD...`: what a shell offers for the last word. The installed scripts ask it.
struct CompleteOptions {
  struct Word {
    std::string text;
    std::string meaning;
  };
  std::vector<Word> words;  // that the grammar has there
  Names names = Names::kNone;
  std::string begin;   // of what is offered
  std::string prefix;  // that stands before it already: "--format="
  std::string config;  // whose names are meant; empty: those of the running machine
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
