#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "musher/base/files.hpp"
#include "musher/base/program.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/cli/doctor/host_facts.hpp"
#include "musher/cli/doctor/host_reach.hpp"
#include "musher/cli/doctor/in_child.hpp"
#include "musher/cli/doctor/lcm_facts.hpp"
#include "musher/cli/render/doctor.hpp"
#include "musher/test/cli/robot.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::cli::doctor_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr std::int64_t kNow = 1'790'000'000;

// A computer without a fault, with a robot that needs keys.
DoctorFacts Healthy() {
  DoctorFacts facts;
  facts.config = RobotConfig();
  facts.config->keys = "/etc/keys";
  facts.interfaces = {{"lo", true, true, false, {"127.0.0.1"}},
                      {"eth0", true, false, true, {"192.168.1.7"}}};
  facts.rmem_max = facts.wmem_max = 8 << 20;
  facts.dds = {"", Milliseconds(20), Milliseconds(1)};
  facts.clock = {"", true, Milliseconds(5), "tsc", kNow, kNow - 10};
  facts.state_dir =
      FolderFacts{"/state", "/state", "", true, true, false, 4ll << 30, 9ll << 30, 9999};
  facts.log_dirs = {*facts.state_dir};
  facts.log_dirs[0].path = facts.log_dirs[0].existing = "/state/logs";
  facts.lock = LockFacts{"/state/controller.lock", "dog", true, 0};
  facts.limits = {1024, 4096, "gdb", 0, false};
  facts.core = {1 << 20, 1 << 20, "core"};
  facts.cpu = {4, std::nullopt, {}};
  facts.times = {"", 120};
  facts.version = "1.2.3";
  facts.now = transport::keys::WallTime(std::chrono::seconds(kNow));
  facts.keys = {{"controller", "", facts.now + std::chrono::days(300), "/etc/keys/c.key", 0600}};
  return facts;
}

DoctorCheck Check(const DoctorFacts& facts, const std::string& name) {
  const auto all = Diagnose(facts);
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& check) { return check.name == name; });
  if (found != all.end()) return *found;
  ADD_FAILURE() << "no check '" << name << "'";
  return {};
}

struct Planted {
  const char* test;
  const char* check;
  CheckStatus health;
  const char* reason;
  const char* fix;
  void (*plant)(DoctorFacts&);
};

void Uri(DoctorFacts& facts, const std::string& xml) {
  facts.environment["CYCLONEDDS_URI"] = facts.uri_text = xml;
}

const Planted kPlanted[] = {
    {"ABadDomain", "DDS environment", CheckStatus::kError, "ROS_DOMAIN_ID is 999",
     "unset ROS_DOMAIN_ID", [](DoctorFacts& f) { f.domain_error = "ROS_DOMAIN_ID is 999"; }},
    {"ABadProfile", "DDS environment", CheckStatus::kError, "MUSHER_TRANSPORT is wan",
     "unset MUSHER_TRANSPORT", [](DoctorFacts& f) { f.profile_error = "MUSHER_TRANSPORT is wan"; }},
    {"AnUnknownInterfaceInTheUri", "CYCLONEDDS_URI", CheckStatus::kError,
     "names the interface eth7, which does not exist; interfaces are lo, eth0",
     "unset CYCLONEDDS_URI",
     [](DoctorFacts& f) { Uri(f, "<Interfaces><NetworkInterface name=\"eth7\"/></Interfaces>"); }},
    {"AnInterfaceOfTheUriThatIsDown", "CYCLONEDDS_URI", CheckStatus::kError, "is down",
     "sudo ip link set eth0 up",
     [](DoctorFacts& f) {
       f.interfaces[1].up = false;
       Uri(f, "<NetworkInterfaceAddress>192.168.1.7</NetworkInterfaceAddress>");
     }},
    {"AMissingFileOfTheUri", "CYCLONEDDS_URI", CheckStatus::kError, "missing or empty",
     "unset CYCLONEDDS_URI",
     [](DoctorFacts& f) {
       f.environment["CYCLONEDDS_URI"] = "file:///x.xml";
       f.uri_error = "it names the file /x.xml, which is missing or empty";
     }},
    {"ATruncatedUri", "CYCLONEDDS_URI", CheckStatus::kWarning, "not closed", "unset CYCLONEDDS_URI",
     [](DoctorFacts& f) { Uri(f, "<CycloneDDS><Domain>"); }},
    {"NoLoopback", "network interface", CheckStatus::kError, "no loopback interface",
     "ip link set lo up", [](DoctorFacts& f) { f.interfaces.erase(f.interfaces.begin()); }},
    {"NoNetworkForLan", "network interface", CheckStatus::kError,
     "but no interface to other hosts: eth0 (it is down)", "ip link set eth0 up",
     [](DoctorFacts& f) {
       f.profile = TransportProfile::kLan;
       f.interfaces[1].up = false;
     }},
    {"NoMulticastForLan", "network interface", CheckStatus::kError, "; eth0 is without multicast",
     "ip link set eth0 multicast on",
     [](DoctorFacts& f) {
       f.profile = TransportProfile::kLan;
       f.interfaces[1].multicast = false;
     }},
    {"NoRouteToAMotionBoardOnLcm", "motion board", CheckStatus::kError,
     "legs: no network route leads to the multicast group 239.255.76.67",
     "sudo ip link set eth0 up multicast on && sudo ip route add 239.255.76.67/32 dev eth0",
     [](DoctorFacts& f) {
       f.lcm = {{"legs", "/motion.toml", "239.255.76.67", "",
                 "no network route leads to the multicast group 239.255.76.67; type: sudo ip …"}};
     }},
    {"NoInterfaceToAMotionBoard", "motion board", CheckStatus::kError,
     "legs: there is no interface eth7, which [board] interface names; interfaces are lo, eth0",
     "set [board] interface in /motion.toml",
     [](DoctorFacts& f) {
       f.lcm = {{"legs", "/motion.toml", "239.255.76.67", "eth7",
                 "this computer has no network interface 'eth7'"}};
     }},
    {"AnInterfaceThatCameAfterTheStart", "interfaces in use", CheckStatus::kWarning,
     "the controller (pid 7) not eth0 with 192.168.1.7, legs (pid 8) not eth0",
     "musher up --detach --takeover ",
     [](DoctorFacts& f) {
       f.profile = TransportProfile::kLan;
       f.members = {{"", 7, {"127.0.0.1"}},
                    {"legs", 8, {"127.0.0.1", "192.168.1.2"}},
                    {"eyes", 9, {"127.0.0.1", "192.168.1.7"}},
                    {"lidar", 10, {}}};
     }},
    {"NoDds", "DDS exchange", CheckStatus::kError, "was not discovered", "firewall",
     [](DoctorFacts& f) { f.dds.error = "the other process was not discovered"; }},
    {"SlowDds", "DDS exchange", CheckStatus::kWarning, "takes 120.00 ms, more than 50 ms", "top -H",
     [](DoctorFacts& f) { f.dds.exchange = Milliseconds(120); }},
    {"ASmallReceiveBuffer", "net.core.rmem_max", CheckStatus::kWarning,
     "212992 bytes; the transport requests 4194304", "sysctl --system",
     [](DoctorFacts& f) { f.rmem_max = 212992; }},
    {"ASmallSendBuffer", "net.core.wmem_max", CheckStatus::kWarning, "4096 bytes",
     "sysctl --system", [](DoctorFacts& f) { f.wmem_max = 4096; }},
    {"RosOnLocalhost", "ROS 2 environment", CheckStatus::kWarning, "ROS_LOCALHOST_ONLY is 1",
     "unset ROS_LOCALHOST_ONLY", [](DoctorFacts& f) { f.environment["ROS_LOCALHOST_ONLY"] = "1"; }},
    {"AnotherRmw", "ROS 2 environment", CheckStatus::kWarning, "rmw_fastrtps_cpp",
     "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp",
     [](DoctorFacts& f) { f.environment["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"; }},
    {"ANodeOnFastDds", "ROS 2 environment", CheckStatus::kWarning,
     "process 812 of host dog1 runs Fast DDS", "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp",
     [](DoctorFacts& f) { f.other_vendors = {"process 812 of host dog1 runs Fast DDS"}; }},
    {"AClockOf1970", "clock", CheckStatus::kError, "1970-01-01 00:01:40",
     "timedatectl set-ntp true", [](DoctorFacts& f) { f.clock.wall_s = 100; }},
    {"AClockThatWasSetBack", "clock", CheckStatus::kWarning, "3600 s from now", "timedatectl",
     [](DoctorFacts& f) { f.clock.newest_file_s = f.clock.wall_s + 3600; }},
    {"AFileOfAYearBeyondTheCalendar", "clock", CheckStatus::kWarning,
     "a file of @9223372036854775807, ", "timedatectl",
     [](DoctorFacts& f) { f.clock.newest_file_s = std::numeric_limits<std::int64_t>::max(); }},
    {"AClockWithoutNtp", "clock", CheckStatus::kWarning, "not synchronised",
     "timedatectl set-ntp true", [](DoctorFacts& f) { f.clock.synchronised = false; }},
    {"ACoarseClock", "steady clock", CheckStatus::kWarning, "jiffies", "available_clocksource",
     [](DoctorFacts& f) { f.clock.source = "jiffies"; }},
    {"AnUnwritableStateFolder", "state folder", CheckStatus::kError,
     "/ is not writable for this user, and", "sudo install -d -o",
     [](DoctorFacts& f) {
       f.state_dir->existing = "/";
       f.state_dir->writable = false;
     }},
    {"AHungDisk", "state folder", CheckStatus::kError, "did not answer within", "a local disk",
     [](DoctorFacts& f) { f.state_dir->error = "the disk did not answer within 2000 ms"; }},
    {"AStateFolderThatCannotBeWritten", "state folder", CheckStatus::kError,
     "writing to /state fails, 4 KiB free: No space left", "du -xh /state",
     [](DoctorFacts& f) {
       f.state_dir->free_bytes = 4 << 10;
       f.state_dir->write_error = "No space left on device";
     }},
    {"AStateFolderThatAnotherUserCanChange", "state folder", CheckStatus::kError,
     "belongs to user 1001", "chown -R",
     [](DoctorFacts& f) { f.state_dir->untrusted = "/state belongs to user 1001"; }},
    {"AFileForAStateFolder", "state folder", CheckStatus::kError, "is not a folder",
     "another state_dir", [](DoctorFacts& f) { f.state_dir->is_folder = false; }},
    {"AFullDisk", "disk", CheckStatus::kError, "5 of 9216 MiB free", "du -xh /state",
     [](DoctorFacts& f) { f.state_dir->free_bytes = 5 << 20; }},
    {"LittleDisk", "disk", CheckStatus::kWarning, "100 of 9216 MiB free", "du -xh",
     [](DoctorFacts& f) { f.state_dir->free_bytes = 100 << 20; }},
    {"LessDiskThanTheLogsMayTake", "disk", CheckStatus::kWarning, "logs_size_mb permit 564",
     "lower logs_size_mb", [](DoctorFacts& f) { f.state_dir->free_bytes = 400 << 20; }},
    {"NoInodes", "disk", CheckStatus::kWarning, "only 3 more files", "du -xh",
     [](DoctorFacts& f) { f.state_dir->free_inodes = 3; }},
    {"AStateFolderInMemory", "disk", CheckStatus::kWarning, "tmpfs", "set state_dir",
     [](DoctorFacts& f) { f.state_dir->in_memory = true; }},
    {"FewFiles", "open files", CheckStatus::kError, "64 permitted, 272 needed", "ulimit -n 272",
     [](DoctorFacts& f) { f.limits.files = 64; }},
    {"FewFilesByTheHardLimit", "open files", CheckStatus::kError, "64 permitted",
     "limits.d/musher.conf", [](DoctorFacts& f) { f.limits.files = f.limits.files_hard = 64; }},
    {"ARealTimePriorityThatIsNotPermitted", "real-time priority", CheckStatus::kError,
     "none permitted, legs requests 80 (chrt): its process cannot start", "LimitRTPRIO=80",
     [](DoctorFacts& f) {
       f.config->actuators[0].command = {"chrt", "-f", "80", "legs"};
     }},
    {"ARealTimePriorityAboveTheLimit", "real-time priority", CheckStatus::kError,
     "up to 50 permitted, legs requests 60", "rtprio 60",
     [](DoctorFacts& f) {
       f.limits.real_time = 50;
       f.config->actuators[0].command = {"/usr/bin/chrt", "--rr", "60", "legs"};
     }},
    {"NoCoreDumps", "core dumps", CheckStatus::kWarning,
     "the limit is 0 bytes; they would go to the program /usr/bin/apport", "ulimit -c unlimited",
     [](DoctorFacts& f) {
       f.core = {0, 1, "|/usr/bin/apport %p %s"};
     }},
    {"NoCoreDumpsByTheHardLimit", "core dumps", CheckStatus::kWarning,
     "to the working directory of the process, as core", "limits.d/musher-core.conf",
     [](DoctorFacts& f) { f.core.limit = f.core.limit_hard = 0; }},
    {"NoProgramForCoreDumps", "core dumps", CheckStatus::kWarning,
     "to the program /x/apport, at most 1048576 bytes: it does not exist",
     "core_pattern=core.%e.%p",
     [](DoctorFacts& f) {
       f.core.pattern = "|/x/apport %p";
       f.core.obstacle = "it does not exist";
     }},
    {"NoFolderForCoreDumps", "core dumps", CheckStatus::kWarning,
     "to /var/cores/%e.%p, at most 1048576 bytes: the folder does not exist",
     "sudo install -d -m 1777 /var/cores",
     [](DoctorFacts& f) {
       f.core.pattern = "/var/cores/%e.%p";
       f.core.obstacle = "the folder does not exist";
     }},
    {"ALockOfAnotherUser", "lock file", CheckStatus::kError,
     "/state/controller.lock belongs to root: this user cannot start the machine",
     "sudo chown -R \"$USER\" /state",
     [](DoctorFacts& f) {
       f.lock->owner = "root";
       f.lock->writable = false;
     }},
    {"AStateFolderOfAnotherMachine", "lock file", CheckStatus::kError,
     "/state belongs to another machine, cat of /cat.toml", "a name or a state_dir of its own",
     [](DoctorFacts& f) { f.lock->belongs_to = "cat of /cat.toml"; }},
    {"AnUnwritableLogFolder", "log folder", CheckStatus::kError,
     "/state/logs is not writable for this user", "sudo chown \"$USER\" /state/logs",
     [](DoctorFacts& f) { f.log_dirs[0].writable = false; }},
    {"AFileForALogFolder", "log folder", CheckStatus::kError, "/state/logs is not a folder",
     "mv /state/logs", [](DoctorFacts& f) { f.log_dirs[0].is_folder = false; }},
    {"AHungDiskOfTheLog", "log folder", CheckStatus::kError, "did not answer", "set log in",
     [](DoctorFacts& f) { f.log_dirs[0].error = "the disk did not answer within 2000 ms"; }},
    {"AFullDiskOfTheLog", "log folder", CheckStatus::kError, "/logs: 5 of 9216 MiB free",
     "du -xh /state/logs",
     [](DoctorFacts& f) {
       f.log_dirs[0].device = 7;
       f.log_dirs[0].free_bytes = 5 << 20;
     }},
    {"LogsOfAnotherUser", "log folder", CheckStatus::kError,
     "/state/logs/legs.log belongs to root: what its process prints is lost (and 1 more)",
     "sudo chown -R \"$USER\" /state/logs",
     [](DoctorFacts& f) {
       f.unwritable_logs = {{"/state/logs/legs.log", "root"}, {"/state/logs/eyes.log", "root"}};
     }},
    {"NoTracer", "backtraces", CheckStatus::kWarning, "neither eu-stack nor gdb",
     "install elfutils", [](DoctorFacts& f) { f.limits.tracer.clear(); }},
    {"NoPermissionToTrace", "backtraces", CheckStatus::kWarning, "ptrace_scope is 1",
     "sysctl -w kernel.yama.ptrace_scope=0", [](DoctorFacts& f) { f.limits.ptrace_scope = 1; }},
    {"ACpuQuota", "CPU", CheckStatus::kWarning, "limited to 0.5 by the cgroup", "CPUQuota",
     [](DoctorFacts& f) { f.cpu.quota = 0.5; }},
    {"AMissingCertificate", "keys", CheckStatus::kError, "legs: there is no certificate",
     "musher keys add legs --force --keys /etc/keys",
     [](DoctorFacts& f) {
       f.keys.push_back({"legs", "there is no certificate", {}, "", 0});
     }},
    {"NoKeysAtAll", "keys", CheckStatus::kError, "controller: there is no certificate",
     "musher keys init dog.toml",
     [](DoctorFacts& f) {
       f.keys[0].error = "there is no certificate";
       f.keys_made = false;
     }},
    {"AReadableKey", "keys", CheckStatus::kError, "has the permissions 644",
     "chmod 600 /etc/keys/c.key", [](DoctorFacts& f) { f.keys[0].mode = 0644; }},
    {"AKeyThatOthersReadAndThereforeIsNotUsed", "keys", CheckStatus::kError,
     "has the permissions 640", "chmod 600 /etc/keys/c.key",
     [](DoctorFacts& f) {
       f.keys[0].mode = 0640;
       f.keys[0].error = "/etc/keys/c.key is readable by others";
     }},
    {"AKeyFolderThatAnotherUserCanChange", "keys", CheckStatus::kError,
     "/etc/keys belongs to user 1001, who could",
     "sudo chown -R -h \"$USER\" /etc/keys && chmod -R go-w /etc/keys && musher keys init dog.toml "
     "--force",
     [](DoctorFacts& f) {
       f.keys_of_another = true;
       f.keys_untrusted = "/etc/keys belongs to user 1001, who could replace files in it";
       f.keys[0].error = f.keys_untrusted;
     }},
    {"AKeyFolderOfOursThatOthersCanWrite", "keys", CheckStatus::kError,
     "/etc/keys is writable for its group", "chmod -R go-w /etc/keys && musher keys init",
     [](DoctorFacts& f) {
       f.keys_untrusted = "/etc/keys is writable for its group, who could replace files in it";
     }},
    {"ACertificateThatExpiresSoon", "keys", CheckStatus::kWarning, "within 30 days",
     "musher keys add controller", [](DoctorFacts& f) { f.keys[0].until = f.now; }},
    {"AMissingProgram", "programs", CheckStatus::kError, "dog.toml:3:1: error: no such program",
     "musher check dog.toml",
     [](DoctorFacts& f) {
       f.programs = {{"dog.toml", 3, 1, Severity::kError, "no such program"}};
     }},
    {"AProgramThatNothingStops", "programs", CheckStatus::kWarning,
     "dog.toml:3:1: warning: no [emergency_stop]", "musher check dog.toml",
     [](DoctorFacts& f) {
       f.programs = {{"dog.toml", 3, 1, Severity::kWarning, "no [emergency_stop]"}};
     }},
    {"CommandsThatWereOverdue", "time limits", CheckStatus::kWarning,
     "legs: Active was overdue in 3 of 120 commands, its limit is 5000 ms (and 1 more)",
     "musher times dog.toml --since 7d",
     [](DoctorFacts& f) {
       f.times.warnings = {"legs: Active was overdue in 3 of 120 commands, its limit is 5000 ms",
                           "eyes: Active takes 2.1 times as long since 2026-11-20 08:00"};
     }},
    {"AnotherMachineInTheNamespace", "machine", CheckStatus::kError,
     "cat (pid 7) runs already in the default namespace of domain 0: dog cannot start there",
     "musher down",
     [](DoctorFacts& f) {
       f.controllers = {{"cat", "", 7, "", ""}};
     }},
    {"AControllerThatDoesNotAnswer", "machine", CheckStatus::kWarning, "process 7 leads a machine",
     "CYCLONEDDS_URI, --transport and --keys",
     [](DoctorFacts& f) {
       f.controllers = {{"", "", 7, {}, {}, false}};
     }},
    {"AControllerThatIsStopped", "machine", CheckStatus::kWarning, "and is stopped", "kill -CONT 7",
     [](DoctorFacts& f) {
       f.controllers = {{"", "", 7, {}, {}, false, true}};
     }},
    {"AMachineInAnotherNetworkNamespace", "machine", CheckStatus::kWarning,
     "process 7 leads dog in another network", "in that network namespace",
     [](DoctorFacts& f) {
       f.in_other_network = "process 7 leads dog in another network namespace of this host";
     }},
    {"AControllerOfAnotherVersion", "version", CheckStatus::kWarning,
     "the controller (pid 7) is musher 1.2.2, this program is 1.2.3",
     "musher up --detach --takeover /dog.toml",
     [](DoctorFacts& f) {
       f.controllers = {{"dog", "", 7, "1.2.2", "/dog.toml"}};
     }},
};

class PlantedFault : public ::testing::TestWithParam<Planted> {};

TEST_P(PlantedFault, IsFoundWithItsNumbersAndAFix) {
  DoctorFacts facts = Healthy();
  GetParam().plant(facts);
  const DoctorCheck check = Check(facts, GetParam().check);
  EXPECT_EQ(check.health, GetParam().health);
  EXPECT_THAT(check.reason, HasSubstr(GetParam().reason));
  EXPECT_THAT(check.fix, HasSubstr(GetParam().fix));
}

INSTANTIATE_TEST_SUITE_P(Each, PlantedFault, ::testing::ValuesIn(kPlanted),
                         [](const auto& planted) { return std::string(planted.param.test); });

TEST(Diagnose, AComputerWithoutAFaultHasNothingToFix) {
  const auto checks = Diagnose(Healthy());
  ASSERT_FALSE(checks.empty());
  for (const DoctorCheck& check : checks) {
    EXPECT_LE(check.health, CheckStatus::kOk) << check.name << ": " << check.reason;
    EXPECT_EQ(check.fix, "") << check.name;
    EXPECT_NE(check.reason, "") << check.name;
  }
}

TEST(Diagnose, NamesTheInterfacesOfTheProfileLanThatAreUsedAndWhyTheOthersAreNot) {
  DoctorFacts facts = Healthy();
  facts.profile = TransportProfile::kLan;
  facts.interfaces.push_back({"wlan0", false, false, true, {}});
  facts.interfaces.push_back({"docker0", true, false, true, {"172.17.0.1"}, true, "bridge"});
  facts.interfaces.push_back({"tun0", true, false, false, {"10.8.0.2"}, false, "tun"});
  const DoctorCheck chosen = Check(facts, "network interface");
  EXPECT_EQ(chosen.health, CheckStatus::kOk);
  EXPECT_EQ(chosen.fix, "");
  EXPECT_EQ(chosen.reason,
            "lo with 127.0.0.1 between processes of this host; to other hosts eth0 with "
            "192.168.1.7 (an ethernet or wifi device that is up); not used: wlan0 (it is down), "
            "docker0 (it is virtual (bridge); [transport] interfaces can name it), tun0 (it is "
            "virtual (tun); [transport] interfaces can name it)");
  facts.config->interfaces = {"tun0", "eth0"};
  facts.interfaces.back().multicast = true;
  const DoctorCheck named = Check(facts, "network interface");
  EXPECT_EQ(named.health, CheckStatus::kOk);
  EXPECT_THAT(named.reason,
              HasSubstr("; to other hosts tun0 with 10.8.0.2 ([transport] interfaces names it), "
                        "eth0 with 192.168.1.7 ([transport] interfaces names it); not used: wlan0 "
                        "([transport] interfaces does not name it), docker0 "));
}

TEST(Diagnose, WhatIsNotKnownOrNotUsedDoesNotCount) {
  DoctorFacts facts = Healthy();
  facts.config.reset();
  facts.state_dir.reset();
  facts.log_dirs.clear();
  facts.lock.reset();
  facts.core.pattern.clear();
  facts.keys.clear();
  facts.rmem_max.reset();
  facts.clock.error = "adjtimex: Operation not permitted";
  for (const char* name :
       {"state folder", "disk", "lock file", "log folder", "core dumps", "keys", "programs",
        "time limits", "net.core.rmem_max", "clock", "CYCLONEDDS_URI", "ROS 2 environment"}) {
    EXPECT_EQ(Check(facts, name).health, CheckStatus::kNotApplicable) << name;
  }
  EXPECT_EQ(Worst(Diagnose(facts)), CheckStatus::kOk);
}

TEST(Diagnose, SaysWhyTimesAreNotKnown) {
  DoctorFacts facts = Healthy();
  EXPECT_THAT(Check(facts, "time limits").reason,
              HasSubstr("120 commands and starts in the last 7 days"));
  facts.times = {"", 0};
  EXPECT_EQ(Check(facts, "time limits").health, CheckStatus::kNotApplicable);
  facts.times = {"the disk did not answer within 2000 ms"};
  const DoctorCheck unread = Check(facts, "time limits");
  EXPECT_EQ(unread.health, CheckStatus::kNotApplicable);
  EXPECT_EQ(unread.reason, "the disk did not answer within 2000 ms");
}

TEST(Diagnose, NamesOneCauseOnlyWhereTheEnvironmentIsInvalid) {
  DoctorFacts facts = Healthy();
  facts.domain_error = "ROS_DOMAIN_ID is 999";
  EXPECT_EQ(Check(facts, "DDS exchange").health, CheckStatus::kNotApplicable);
}

// In a network of its own, in which nothing is up: as a computer is on its first day with a robot.
TEST(DoctorLcm, CuresMulticastWithoutARouteByItsCommand) {
  TempFolder folder;
  MachineConfig config = RobotConfig();
  config.actuators[0].command = {"/usr/bin/musher-motion-manager", "motion.toml"};
  config.actuators[0].cwd = folder / "";
  std::ofstream(folder / "motion.toml") << "[board]\nkind = \"lcm\"\n";
  std::ofstream(folder / "topic.toml") << "[board]\nkind = \"topic\"\n";
  const std::string skipped =
      std::async(std::launch::async, [&]() -> std::string {
        if (unshare(CLONE_NEWNET) != 0) return "a network namespace needs root";
        if (std::system("ip link set lo up") != 0) return "the command ip is missing";
        const auto diagnose = [&] {
          DoctorFacts facts = Healthy();
          facts.interfaces = transport::ReadInterfaces();
          facts.lcm = ReadLcm(config);
          return Check(facts, "motion board");
        };
        const DoctorCheck before = diagnose();
        EXPECT_EQ(before.health, CheckStatus::kError);
        EXPECT_EQ(before.fix,
                  "sudo ip link set lo up multicast on && sudo ip route add "
                  "239.255.76.67/32 dev lo");
        std::string cure = before.fix;
        for (std::size_t at = 0; (at = cure.find("sudo ")) != std::string::npos;) cure.erase(at, 5);
        EXPECT_EQ(std::system(cure.c_str()), 0) << cure;
        const DoctorCheck after = diagnose();
        EXPECT_EQ(after.health, CheckStatus::kOk) << after.reason;
        EXPECT_EQ(after.reason, "a route leads to 239.255.76.67");
        config.actuators[0].command[1] = "topic.toml";
        EXPECT_EQ(diagnose().health, CheckStatus::kNotApplicable);
        return "";
      }).get();
  if (!skipped.empty()) GTEST_SKIP() << skipped;
}

TEST(Diagnose, TheMachineItselfMayRun) {
  DoctorFacts facts = Healthy();
  facts.controllers = {{"dog", "", 7, "1.2.3", "/dog.toml"}};
  EXPECT_EQ(Worst(Diagnose(facts)), CheckStatus::kOk);
}

TEST(Diagnose, ARealTimePriorityNeedsAPermissionOnlyWhereItIsRequested) {
  DoctorFacts facts = Healthy();
  EXPECT_THAT(Check(facts, "real-time priority").reason,
              HasSubstr("none permitted, none requested by a command (chrt)"));
  facts.config->actuators[0].command = {"chrt", "--idle", "0", "legs"};
  EXPECT_EQ(Check(facts, "real-time priority").health, CheckStatus::kOk);
  facts.config->actuators[0].command = {"chrt", "80", "legs"};
  facts.limits.may_real_time = true;
  EXPECT_THAT(Check(facts, "real-time priority").reason,
              HasSubstr("up to 99 permitted, legs requests 80 (chrt)"));
  EXPECT_EQ(Check(facts, "real-time priority").health, CheckStatus::kOk);
}

TEST(Diagnose, AFullDiskOfLogsAndStateHasOneCause) {
  DoctorFacts facts = Healthy();
  facts.state_dir->free_bytes = facts.log_dirs[0].free_bytes = 5 << 20;
  EXPECT_EQ(Check(facts, "disk").health, CheckStatus::kError);
  EXPECT_EQ(Check(facts, "log folder").health, CheckStatus::kOk);
}

TEST(Diagnose, AnUnsynchronisedClockMattersBetweenHostsOnly) {
  DoctorFacts facts = Healthy();
  facts.keys.clear();
  facts.clock.synchronised = false;
  EXPECT_EQ(Check(facts, "clock").health, CheckStatus::kOk);
}

TEST(DoctorText, HasTheFixBelowItsCheck) {
  const std::vector<DoctorCheck> checks = {{"clock", CheckStatus::kOk, "synchronised", ""},
                                           {"disk", CheckStatus::kError, "full\x1b[2J", "rm x"}};
  EXPECT_EQ(DoctorText(checks, false),
            "CHECK  RESULT  REASON\n"
            "clock  ok      synchronised\n"
            "disk   error   full [2J\n"
            "       fix:    rm x\n"
            "1 error, 0 warnings\n");
  EXPECT_EQ(DoctorJson({checks[0]}),
            R"({"result":"ok","checks":[{"check":"clock","result":"ok","reason":"synchronised",)"
            R"("fix":null}]})");
}

TEST(StateFolder, ThatIsADanglingLinkIsAnError) {
  const TempFolder folder;
  std::filesystem::create_symlink("/gone", folder / "state");
  std::int64_t newest_file_s = 0;
  const FolderFacts facts =
      ReadFolder(folder / "state/robot", std::chrono::minutes(1), newest_file_s);
  EXPECT_EQ(facts.error, (folder / "state") + " is a link to /gone, which does not exist");
}

TEST(InChild, ReturnsWhatTheFunctionReturns) {
  auto child = InChild::Start([] { return std::string(100'000, 'x'); });
  ASSERT_TRUE(child);
  const auto text = child.value().Await(std::chrono::steady_clock::now() + std::chrono::minutes(1));
  ASSERT_TRUE(text) << text.error().message;
  EXPECT_EQ(text.value().size(), 100'000U);
}

TEST(InChild, IsGivenUpAtItsDeadline) {
  auto child = InChild::Start([]() -> std::string {
    for (;;) pause();
  });
  ASSERT_TRUE(child);
  const auto text = child.value().Await(std::chrono::steady_clock::now() + Milliseconds(20));
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, kCodeTimeout);
}

TEST(InChild, ThatCrashesIsReported) {
  auto child = InChild::Start([]() -> std::string { _exit((kill(getpid(), SIGKILL), 1)); });
  ASSERT_TRUE(child);
  const auto text = child.value().Await(std::chrono::steady_clock::now() + std::chrono::minutes(1));
  ASSERT_FALSE(text);
  EXPECT_THAT(text.error().message, HasSubstr("crashed"));
}

// --- other hosts ---

// A host without a fault.
OtherHostFacts Vision() {
  OtherHostFacts host{"vision", "root@10.0.0.2"};
  host.clock_ahead = Milliseconds(-12);
  host.architecture = "aarch64";
  host.init = "systemd";
  host.systemd = 252;
  host.musher = "1.2.3";
  host.free_bytes = 9ll << 30;
  host.root = true;
  return host;
}

DoctorCheck CheckVision(const OtherHostFacts& host) {
  DoctorFacts facts = Healthy();
  facts.hosts = {host};
  return Check(facts, "host vision");
}

TEST(DoctorOfAnotherHost, ShowsWhatItFound) {
  const DoctorCheck check = CheckVision(Vision());
  EXPECT_EQ(check.health, CheckStatus::kOk);
  EXPECT_EQ(check.reason, "root@10.0.0.2, aarch64, systemd 252, its clock is 12 ms behind");
}

TEST(DoctorOfAnotherHost, NamesEachFaultWithItsHostAndWhatToDo) {
  struct Fault {
    void (*plant)(OtherHostFacts&);
    CheckStatus health;
    const char* reason;
    const char* fix;
  };
  const Fault faults[] = {
      {[](auto& host) { host.init = "sh"; }, CheckStatus::kError, "its first process is sh",
       "systemd"},
      {[](auto& host) { host.systemd = 247; }, CheckStatus::kError, "systemd 247 is too old",
       "upgrade"},
      {[](auto& host) { host.missing = {"eyes: program not found there: /opt/eyes"}; },
       CheckStatus::kError, "eyes: program not found there: /opt/eyes", "copy the programs"},
      {[](auto& host) { host.no_folders = {"eyes: /opt/robot"}; }, CheckStatus::kError,
       "the working directory is not there for eyes: /opt/robot", "correct `cwd`"},
      {[](auto& host) { host.no_configs = {"eyes: /opt/robot.toml"}; }, CheckStatus::kWarning,
       "the config is not there for eyes: /opt/robot.toml", "env.MUSHER_CONFIG"},
      {[](auto& host) { host.no_devices = {"eyes: /dev/video9"}; }, CheckStatus::kWarning,
       "it has no such device for eyes: /dev/video9", "plug it in before the start"},
      {[](auto& host) { host.no_users = {"robot"}; }, CheckStatus::kError, "it has no user robot",
       "ssh root@10.0.0.2 useradd --system robot"},
      {[](auto& host) { host.foreign = {"musher-dog-eyes.service"}; }, CheckStatus::kError,
       "musher-dog-eyes.service already, for another machine", "systemctl stop musher-dog-eyes"},
      {[](auto& host) { host.free_bytes = 7 << 20; }, CheckStatus::kError,
       "its disk has 7 MiB left", "journalctl --vacuum-size"},
      {[](auto& host) { host.run_bytes = 4 << 10; }, CheckStatus::kError,
       "its /run, where systemd keeps units, has 4 KiB left", "shows what fills it"},
      {[](auto& host) { host.musher = "1.1.0"; }, CheckStatus::kWarning,
       "it has musher 1.1.0, this program is 1.2.3", "the same version"},
      {[](auto& host) { host.clock_ahead = std::chrono::hours(3); }, CheckStatus::kWarning,
       "its clock is 10800.0 s ahead", "timedatectl"},
  };
  for (const Fault& fault : faults) {
    OtherHostFacts host = Vision();
    fault.plant(host);
    const DoctorCheck check = CheckVision(host);
    EXPECT_EQ(check.health, fault.health) << check.reason;
    EXPECT_THAT(check.reason, HasSubstr("host vision (root@10.0.0.2): "));
    EXPECT_THAT(check.reason, HasSubstr(fault.reason));
    EXPECT_THAT(check.fix, HasSubstr(fault.fix));
  }
  OtherHostFacts off{"vision", "root@10.0.0.2", "host vision (root@10.0.0.2): off; switch it on"};
  EXPECT_EQ(CheckVision(off).reason, off.trouble);
  EXPECT_EQ(CheckVision(off).health, CheckStatus::kError);
}

TEST(DoctorOfAnotherHost, NamesTheLimitsThatItsKernelDoesNotKeep) {
  struct Kernel {
    int cgroups;
    std::vector<std::string> keeps;
    bool autogroups;
    ProcessLimits limits;
    CheckStatus health;
    const char* reason;
    const char* fix;
  };
  ProcessLimits memory;
  memory.memory_max_bytes = 64 << 20;
  ProcessLimits cpus;
  cpus.cpus = 0.5;
  ProcessLimits nice;
  nice.nice = 5;
  ProcessLimits sandbox;
  sandbox.sandbox = Sandbox::kReadOnly;
  ProcessLimits devices;
  devices.devices = {"/dev/video0"};
  ProcessLimits strict;
  strict.sandbox = Sandbox::kStrict;
  const Kernel kernels[] = {
      {2,
       {"cpu", "quota"},
       false,
       memory,
       CheckStatus::kError,
       "does not keep `memory_max_mb` of eyes: its cgroups have no memory controller",
       "cgroup_enable=memory"},
      {2,
       {"memory"},
       false,
       cpus,
       CheckStatus::kError,
       "does not keep `cpus` of eyes: its cgroups have no cpu controller",
       "remove the key"},
      {1,
       {"memory", "cpu"},
       false,
       cpus,
       CheckStatus::kError,
       "without CONFIG_CFS_BANDWIDTH",
       "remove the key"},
      {1,
       {"memory"},
       false,
       memory,
       CheckStatus::kWarning,
       "cgroups of version 1: eyes is ended",
       "systemd.unified_cgroup_hierarchy=1"},
      {2,
       {"memory"},
       true,
       nice,
       CheckStatus::kWarning,
       "does not keep `nice` of eyes",
       "ssh root@10.0.0.2 sysctl kernel.sched_autogroup_enabled=0"},
      {2,
       {"devices"},
       false,
       sandbox,
       CheckStatus::kError,
       "does not keep `sandbox` of eyes: it permits no mount namespaces",
       "remove the key"},
      {2,
       {"mounts"},
       false,
       devices,
       CheckStatus::kError,
       "does not keep the devices from eyes: its cgroups have no devices controller",
       "CONFIG_CGROUP_BPF"},
      {1, {"mounts"}, false, strict, CheckStatus::kError, "no devices controller", ""},
      {1, {"devices", "mounts"}, false, strict, CheckStatus::kOk, "", ""},
      {2, {"mounts"}, false, sandbox, CheckStatus::kOk, "", ""},
      {2, {"cpu"}, true, nice, CheckStatus::kOk, "", ""},
      {2, {"memory"}, false, nice, CheckStatus::kOk, "", ""},
      {0, {}, true, memory, CheckStatus::kOk, "", ""},
      {2, {}, true, ProcessLimits(), CheckStatus::kOk, "", ""},
  };
  for (const Kernel& kernel : kernels) {
    OtherHostFacts host = Vision();
    host.cgroups = kernel.cgroups;
    host.keeps = kernel.keeps;
    host.autogroups = kernel.autogroups;
    DoctorFacts facts = Healthy();
    ActuatorConfig eyes;
    eyes.name = "eyes";
    eyes.host = "vision";
    eyes.limits = kernel.limits;
    facts.config.emplace().actuators.push_back(eyes);
    facts.hosts = {host};
    const DoctorCheck check = Check(facts, "host vision");
    EXPECT_EQ(check.health, kernel.health) << check.reason;
    EXPECT_THAT(check.reason, HasSubstr(kernel.reason));
    EXPECT_THAT(check.fix, HasSubstr(kernel.fix));
  }
}

// `units = "always"`, of a host without a fault.
OtherHostFacts ThisHost() {
  OtherHostFacts host = Vision();
  host.name.clear();
  host.login.clear();
  host.cgroups = 2;
  host.keeps = {"cpu", "quota", "memory", "devices", "mounts"};
  return host;
}

DoctorCheck CheckUnits(const OtherHostFacts& host, const ProcessLimits& limits = {}) {
  DoctorFacts facts = Healthy();
  ActuatorConfig eyes;
  eyes.name = "eyes";
  eyes.command = {"eyes"};
  eyes.limits = limits;
  facts.config.emplace().actuators.push_back(eyes);
  facts.config->own_units = true;
  facts.hosts = {host};
  return Check(facts, "units");
}

TEST(DoctorOfUnitsOfThisHost, SaysThatProcessesAreUnits) {
  EXPECT_EQ(CheckUnits(ThisHost()).health, CheckStatus::kOk);
  EXPECT_EQ(CheckUnits(ThisHost()).reason, "processes of this host are units of systemd 252");
}

TEST(DoctorOfUnitsOfThisHost, NamesEachLimitThatIsNotKeptWithWhatToDo) {
  ProcessLimits limits;
  limits.memory_max_bytes = 64 << 20;
  limits.user = "robot";
  OtherHostFacts none = ThisHost();
  none.trouble = "systemd does not run on this host; remove `units`";
  EXPECT_EQ(CheckUnits(none).health, CheckStatus::kError);
  EXPECT_EQ(CheckUnits(none).reason, "controller.units: " + none.trouble);
  OtherHostFacts old = ThisHost();
  old.systemd = 245;
  EXPECT_THAT(CheckUnits(old).reason, HasSubstr("systemd 245 is too old"));
  OtherHostFacts small = ThisHost();
  small.keeps = {"cpu"};
  EXPECT_EQ(CheckUnits(small, limits).health, CheckStatus::kError);
  EXPECT_THAT(CheckUnits(small, limits).reason,
              HasSubstr("this host: its kernel does not keep `memory_max_mb` of eyes"));
  OtherHostFacts empty = ThisHost();
  empty.no_users = {"robot"};
  EXPECT_EQ(CheckUnits(empty, limits).fix, "useradd --system robot");
  OtherHostFacts of_user = ThisHost();
  of_user.root = false;
  EXPECT_THAT(CheckUnits(of_user, limits).reason,
              HasSubstr("the systemd of a user does not keep `user` of eyes"));
  EXPECT_THAT(CheckUnits(of_user, limits).fix, HasSubstr("as root"));
  EXPECT_EQ(CheckUnits(of_user).reason,
            "processes of this host are units of systemd 252, that of this user");
  OtherHostFacts taken = ThisHost();
  taken.foreign = {"musher-dog-eyes.service"};
  EXPECT_EQ(CheckUnits(taken).fix,
            "give one of the machines another name, or run `systemctl stop "
            "musher-dog-eyes.service`");
}

TEST(DoctorOfAnotherHost, ReadsWhatItsScriptPrints) {
  OtherHostFacts host;
  TakeHostLines({"arch aarch64", "init systemd", "systemd 252", "free 1024", "run 2", "user 0",
                 "cgroups 2 cpuset memory", "autogroups 1", "version musher 1.2.3",
                 "missing eyes: program not found there: x", "nofolder eyes: /a b",
                 "noconfig eyes: /c", "nodevice eyes: /dev/d", "nouser robot",
                 "unit musher-dog-eyes.service MUSHER_MACHINE_ID=theirs",
                 "unit musher-dog-ears.service A=b MUSHER_MACHINE_ID=ours"},
                "ours", host);
  EXPECT_EQ(host.architecture, "aarch64");
  EXPECT_EQ(host.systemd, 252);
  EXPECT_EQ(host.free_bytes, 1 << 20);
  EXPECT_EQ(host.run_bytes, 2 << 10);
  EXPECT_TRUE(host.root);
  EXPECT_EQ(host.cgroups, 2);
  EXPECT_EQ(host.keeps, (std::vector<std::string>{"cpuset", "memory"}));
  EXPECT_TRUE(host.autogroups);
  EXPECT_EQ(host.musher, "1.2.3");
  EXPECT_EQ(host.missing, std::vector<std::string>{"eyes: program not found there: x"});
  EXPECT_EQ(host.no_folders, std::vector<std::string>{"eyes: /a b"});
  EXPECT_EQ(host.no_configs, std::vector<std::string>{"eyes: /c"});
  EXPECT_EQ(host.no_devices, std::vector<std::string>{"eyes: /dev/d"});
  EXPECT_EQ(host.no_users, std::vector<std::string>{"robot"});
  EXPECT_EQ(host.foreign, std::vector<std::string>{"musher-dog-eyes.service"});
}

// What the script finds, run on this computer for a machine whose eyes run on host vision.
class HostFacts : public ::testing::Test {
 protected:
  HostFacts() {
    config_.name = "dog";
    config_.file = folder_ / "robot.toml";
    ActuatorConfig eyes;
    eyes.name = "eyes";
    eyes.host = "vision";
    eyes.command = {"/bin/sh"};
    config_.actuators.push_back(eyes);
  }

  ActuatorConfig& eyes() { return config_.actuators[0]; }
  OtherHostFacts Look() const {
    ProgramSpec spec;
    spec.argv = {"sh", "-s"};
    const auto ran = RunProgram(spec, HostFactsScript(config_, "vision"));
    EXPECT_TRUE(ran && ran.value().status.ok());
    std::vector<std::string> lines;
    std::istringstream output(ran ? ran.value().output : "");
    for (std::string line; std::getline(output, line);) lines.push_back(line);
    OtherHostFacts host;
    TakeHostLines(lines, "", host);
    return host;
  }

  const TempFolder folder_;
  MachineConfig config_;
};

// A start with a folder that is missing is skipped by systemd, and a device that is misspelt stays
// closed: neither is named there.
TEST_F(HostFacts, NameFoldersConfigsAndDevicesThatAreMissing) {
  if (geteuid() != 0) GTEST_SKIP() << "a login that is not root may not see them";
  eyes().cwd = folder_ / "a folder";
  eyes().limits.devices = {"/dev/null", "/dev/no-such-device"};
  const OtherHostFacts without = Look();
  EXPECT_THAT(without.missing, IsEmpty());
  EXPECT_THAT(without.no_folders, ElementsAre("eyes: " + (folder_ / "a folder")));
  EXPECT_THAT(without.no_configs, ElementsAre("eyes: " + (folder_ / "robot.toml")));
  EXPECT_THAT(without.no_devices, ElementsAre("eyes: /dev/no-such-device"));
  std::filesystem::create_directory(folder_ / "a folder");
  eyes().env["MUSHER_CONFIG"] = folder_ / "other.toml";
  std::ofstream(folder_ / "other.toml") << "# as it was copied";
  const OtherHostFacts with = Look();
  EXPECT_THAT(with.no_folders, IsEmpty());
  EXPECT_THAT(with.no_configs, IsEmpty());
}

TEST_F(HostFacts, NameAProgramForAnotherProcessorAndOneThatIsMissing) {
  std::string program = ReadFile("/bin/sh");
  program.resize(64);
  program[18] ^= 1;  // for which processor it is
  std::ofstream(folder_ / "eyes") << program;
  std::filesystem::permissions(folder_ / "eyes", std::filesystem::perms::owner_all);
  eyes().command = {folder_ / "eyes"};
  EXPECT_THAT(Look().missing,
              ElementsAre(HasSubstr(folder_ / "eyes is built for another processor than this ")));
  eyes().command = {"/opt/no-such-program"};
  EXPECT_THAT(Look().missing, ElementsAre("eyes: program not found there: /opt/no-such-program"));
}

}  // namespace musher::cli::doctor_test
