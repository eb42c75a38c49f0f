#pragma once
// What `musher doctor` knows about this computer. Facts only: checks.hpp decides what they mean.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/diagnostic.hpp"
#include "musher/base/network_profile.hpp"
#include "musher/base/time.hpp"
#include "musher/lifecycle/config/config.hpp"
#include "musher/transport/network.hpp"
#include "musher/transport/ros_environment.hpp"
#include "musher/transport/security/wall_time.hpp"

namespace musher::cli {

// Two processes that exchange samples over the network that the machine uses.
struct DdsTrial {
  std::string error;    // why there was none; empty: there was
  Duration meeting{};   // from the start of the processes until they were matched
  Duration exchange{};  // a sample there and back
};

// The kernel's clock discipline, by adjtimex.
struct ClockFacts {
  std::string error;  // it is not readable
  bool synchronised = false;
  Duration max_error{};
  std::string source;              // "tsc"
  std::int64_t wall_s = 0;         // since 1970
  std::int64_t newest_file_s = 0;  // the last write in the state folder; 0: none
};

struct FolderFacts {
  std::string path;
  std::string existing;  // the folder itself, or its nearest parent that exists
  std::string error;     // why it cannot be inspected
  bool is_folder = true;
  bool writable = false;
  bool in_memory = false;  // tmpfs
  std::int64_t free_bytes = 0;
  std::int64_t total_bytes = 0;
  std::int64_t free_inodes = -1;  // -1: the file system has no limit
  std::uint64_t device = 0;       // equal: the same file system
  std::string write_error{};      // why a test write fails; empty: it does not, or was not tried
  std::string untrusted{};        // how another user can change what is in it; empty: none can
};

// The lock by which the state folder has a running owner.
struct LockFacts {
  std::string path;
  std::string owner;         // the user that the file belongs to; empty: there is no file yet
  bool writable = true;      // or there is no file yet
  int held_by = 0;           // the process; 0: none, or not visible
  std::string belongs_to{};  // another machine that the folder belongs to; empty: none
};

// What commands and starts took in the last seven days, by the journal of the machine.
struct TimesFacts {
  std::string error;                       // why it is not known; empty: it is known
  std::size_t commands = 0;                // and starts, done or overdue
  std::vector<std::string> warnings = {};  // see TimeWarnings()
};

// A log that exists and that this user may not write.
struct LogFacts {
  std::string path;
  std::string owner;  // a user
};

struct Limits {
  std::uint64_t files = 0;  // RLIMIT_NOFILE
  std::uint64_t files_hard = 0;
  std::string tracer;  // "eu-stack" or "gdb"; empty: neither
  std::optional<int> ptrace_scope;
  bool may_trace = false;       // CAP_SYS_PTRACE
  std::uint64_t real_time = 0;  // highest priority, RLIMIT_RTPRIO
  bool may_real_time = false;   // CAP_SYS_NICE: any priority
  int lowest_nice = 0;          // RLIMIT_NICE, or that of this process
};

// Where core dumps go. The kernel pipes them to a program of the host, or writes a file.
struct CoreFacts {
  std::uint64_t limit = 0;  // bytes, RLIMIT_CORE
  std::uint64_t limit_hard = 0;
  std::string pattern;        // kernel.core_pattern; empty: not readable
  std::string obstacle = {};  // why its program or folder is not usable; empty: it is
};

struct CpuFacts {
  int cpus = 0;                 // that this process may use
  std::optional<double> quota;  // CPUs that its cgroup permits
  Duration throttled{};         // so far
};

struct KeyFacts {
  std::string identity;
  std::string error;  // empty: valid
  transport::keys::WallTime until{};
  std::string file;       // its private key
  unsigned int mode = 0;  // permissions of that file; 0: none
};

// A running controller in this domain and namespace.
struct ControllerFacts {
  std::string machine;
  std::string host;  // empty: this one
  int pid = 0;
  std::string version = {};      // of its program; empty: unknown
  std::string config_file = {};  // only on this host
  bool reachable = true;         // it answers in this environment
  bool stopped = false;          // by a signal, as SIGSTOP
};

// A process of the running machine on this host.
struct MemberFacts {
  std::string name;  // of an actuator; empty: the controller
  int pid = 0;
  std::vector<std::string> bound;  // see transport::BoundAddresses()
};

// Another host that runs processes of the machine.
struct OtherHostFacts {
  std::string name;
  std::string login;                      // "root@10.0.0.2"
  std::string trouble = {};               // why it did not answer, with what to do; empty: it did
  std::optional<Duration> clock_ahead{};  // of this computer's
  std::string architecture = {};          // "aarch64"
  std::string init = {};                  // its first process: "systemd"
  int systemd = 0;                        // its version; 0: there is none
  std::string musher = {};                // the version of `musher` there; empty: there is none
  std::int64_t free_bytes = -1;           // of its root; -1: not known
  std::int64_t run_bytes = -1;            // likewise of /run, where systemd keeps the units
  bool root = false;                      // the login is root
  int cgroups = 0;                        // their version, 1 or 2; 0: not known
  std::vector<std::string> keeps = {};    // of "memory", "cpu", "quota" (of CPU time)
  bool autogroups = false;                // the kernel weighs sessions, not processes
  std::vector<std::string> missing = {};  // "eyes: /opt/eyes is not there"
  std::vector<std::string> no_folders = {};  // "eyes: /opt/robot"
  std::vector<std::string> no_configs = {};  // "eyes: /opt/robot/robot.toml"
  std::vector<std::string> no_devices = {};  // "eyes: /dev/video0"
  std::vector<std::string> no_users = {};    // that an actuator is to run as
  std::vector<std::string> foreign = {};     // units of these names, of another machine
};

// The multicast group of a motion board on LCM.
struct LcmFacts {
  std::string actuator;
  std::string file;               // of its motion manager
  std::string group;              // "239.255.76.67"
  std::string network_interface;  // that the file names; empty: that of the route
  std::string error;              // why it cannot be reached; empty: it can
};

struct DoctorFacts {
  std::optional<MachineConfig> config;
  transport::Environment environment;
  TransportProfile profile = TransportProfile::kLocal;
  std::string profile_error;
  int domain = 0;
  std::string domain_error;
  std::string name_space;

  std::vector<transport::NetworkInterface> interfaces;
  std::optional<std::int64_t> rmem_max;  // bytes
  std::optional<std::int64_t> wmem_max;
  DdsTrial dds;
  std::vector<LcmFacts> lcm;
  ClockFacts clock;
  std::optional<FolderFacts> state_dir;  // none without a config
  std::vector<FolderFacts> log_dirs;     // of the actuators, and of the controller
  std::optional<LockFacts> lock;         // none without a config
  std::vector<LogFacts> unwritable_logs;
  TimesFacts times{"no journal was read"};
  Limits limits;
  CoreFacts core;
  CpuFacts cpu;
  std::vector<KeyFacts> keys;    // of the identities that the machine needs on this host
  bool keys_made = true;         // the folder has what all identities share
  std::string keys_untrusted;    // how another user can change what is in it; empty: none can
  bool keys_of_another = false;  // the folder belongs to a user who is neither this one nor root
  std::vector<Diagnostic> programs;  // CheckPrograms(); one that is missing here is an error
  std::vector<Diagnostic> ros;       // CheckRos()
  std::vector<ControllerFacts> controllers;
  std::string controllers_error;
  std::string in_other_network;  // MachineInOtherNetwork::Text(); empty: none is known
  std::vector<MemberFacts> members;
  std::vector<OtherHostFacts> hosts;       // that run actuators of the config as units
  std::vector<std::string> other_vendors;  // participants of another DDS than Cyclone
  std::string uri_text;                    // of CYCLONEDDS_URI, also of the file that it names
  std::string uri_error;
  std::string version;  // of this program
  transport::keys::WallTime now{};
};

}  // namespace musher::cli
