#include "musher/cli/doctor/read_facts.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <sstream>

#include "musher/base/files.hpp"
#include "musher/base/host.hpp"
#include "musher/base/own_folder.hpp"
#include "musher/base/program.hpp"
#include "musher/base/scheduling.hpp"
#include "musher/base/version.hpp"
#include "musher/cli/config/program_check.hpp"
#include "musher/cli/config/ros_check.hpp"
#include "musher/cli/doctor/dds_trial.hpp"
#include "musher/cli/doctor/host_facts.hpp"
#include "musher/cli/doctor/host_reach.hpp"
#include "musher/cli/doctor/lcm_facts.hpp"
#include "musher/cli/doctor/storage_facts.hpp"
#include "musher/cli/machine/link.hpp"
#include "musher/cli/machine/machine_files.hpp"
#include "musher/controller/ros2/other_vendors.hpp"
#include "musher/transport/dds/dds_node.hpp"
#include "musher/transport/security/check.hpp"
#include "musher/transport/udp_sockets.hpp"
#include "musher/wire/dds_options.hpp"

namespace musher::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kDdsTime = Milliseconds(3000);
constexpr Duration kDiskTime = Milliseconds(2000);
constexpr Duration kProgramTime = Milliseconds(2000);

void ReadNetwork(DoctorFacts& facts, const GlobalOptions& global) {
  transport::DdsOptions options;
  if (facts.config) options.profile = facts.config->transport;
  if (const auto profile = transport::Profile(options)) {
    facts.profile = profile.value();
  } else {
    facts.profile_error = profile.error().message;
  }
  if (const auto domain = transport::DomainId(options)) {
    facts.domain = domain.value();
  } else {
    facts.domain_error = domain.error().message;
  }
  const bool from_config = facts.config && !global.name_space_given;
  facts.name_space = from_config ? facts.config->name_space : global.name_space;
  facts.interfaces = transport::ReadInterfaces();
  facts.rmem_max = ReadNumber("/proc/sys/net/core/rmem_max");
  facts.wmem_max = ReadNumber("/proc/sys/net/core/wmem_max");
}

// Cyclone takes XML, the name of a file, or a list of files.
void ReadUri(DoctorFacts& facts) {
  const auto uri = facts.environment.find("CYCLONEDDS_URI");
  if (uri == facts.environment.end()) return;
  facts.uri_text = uri->second;
  if (uri->second.find('<') != std::string::npos) return;
  facts.uri_text.clear();
  std::istringstream files(uri->second);
  for (std::string file; std::getline(files, file, ',');) {
    if (file.starts_with("file://")) file.erase(0, 7);
    const std::string text = ReadFile(file);
    if (text.empty()) facts.uri_error = "it names the file " + file + ", which is missing or empty";
    facts.uri_text += text;
  }
}

void ReadKeys(DoctorFacts& facts) {
  if (!facts.config || facts.config->keys.empty()) return;
  std::vector<std::string> identities = {transport::kControllerIdentity};
  for (const ActuatorConfig& actuator : facts.config->actuators) {
    const bool needs_keys = !actuator.command.empty() && actuator.protocol == Protocol::kMusher;
    if (needs_keys) identities.push_back(actuator.name);
  }
  const transport::keys::KeyFolder folder(facts.config->keys);
  facts.keys_made = access(folder.IdentityCa().c_str(), F_OK) == 0;
  auto own = CheckOwnFolder(folder.path());
  if (own) own = CheckOwnFolder(folder.CaFolder());
  if (!own) facts.keys_untrusted = own.error().message;
  for (const std::string& path : {folder.path(), folder.CaFolder()}) {
    struct stat info {};
    if (stat(path.c_str(), &info) != 0) continue;
    facts.keys_of_another |= info.st_uid != geteuid() && info.st_uid != 0;
  }
  for (const std::string& identity : identities) {
    KeyFacts key;
    key.identity = identity;
    key.file = folder.Key(identity);
    struct stat info {};
    if (stat(key.file.c_str(), &info) == 0) key.mode = info.st_mode & 0777U;
    const auto until =
        transport::keys::Check(folder, identity, transport::keys::KeyUse::kByAnyProcess);
    if (until) {
      key.until = until.value();
    } else {
      key.error = until.error().message;
    }
    facts.keys.push_back(std::move(key));
  }
}

// "musher 1.2.3" of the program that the process runs, also if its file was replaced meanwhile.
std::string VersionOfProcess(pid_t pid) {
  const std::string program = "/proc/" + std::to_string(pid) + "/exe";
  std::error_code error;
  const std::string name = fs::read_symlink(program, error).filename().string();
  if (error || !name.starts_with("musher")) return "";  // a program that links the library
  ProgramSpec spec;
  spec.argv = {program, "--version"};
  const auto run = RunProgram(spec, "", kProgramTime);
  if (!run || !run.value().status.ok()) return "";
  std::istringstream words(run.value().output);
  std::string version;
  words >> version >> version;
  return version;
}

void ReadMembers(DoctorFacts& facts, const msg::MachineStatus& status) {
  const auto add = [&facts](const std::string& name, const std::string& host, pid_t pid) {
    if (pid == 0 || host != HostId()) return;
    if (auto bound = transport::BoundAddresses(pid)) {
      facts.members.push_back({name, pid, std::move(*bound)});
    }
  };
  add("", status.host, status.pid);
  for (const auto& actuator : status.actuators) add(actuator.name, actuator.host, actuator.pid);
}

void ReadControllers(DoctorFacts& facts, const GlobalOptions& given) {
  const bool no_dds = !facts.domain_error.empty() || !facts.profile_error.empty();
  if (no_dds || !facts.dds.error.empty()) {
    facts.controllers_error = "not known without DDS";
    return;
  }
  GlobalOptions global = given;
  global.name_space = facts.name_space;
  if (global.keys.empty() && facts.config) global.keys = facts.config->keys;
  const auto beyond =
      facts.config ? InOtherNetwork({facts.config->name, facts.config->state_dir, "", {}, false})
                   : FindInOtherNetwork(global);
  if (beyond) facts.in_other_network = beyond->Text();
  const auto link = Link::Open(global);
  if (!link) {
    facts.controllers_error = link.error().message;
    return;
  }
  if (!link.value()->FollowStatus({})) return;
  const auto note_others = [&](const std::vector<std::string>& others) {
    for (const std::string& other : others) {
      if (std::ranges::count(facts.other_vendors, other) == 0) facts.other_vendors.push_back(other);
    }
  };
  note_others(DescribeOtherVendors(link.value()->node(), link.value()->node().Peers()));
  const bool here = link.value()->LeaderHere() != 0;
  const bool elsewhere = facts.profile == TransportProfile::kLan || !facts.uri_text.empty();
  if (!here && !elsewhere) return;
  link.value()->RunUntil([&] { return link.value()->status().has_value(); },
                         here ? link.value()->discovery_of_one_here() : link.value()->discovery());
  const auto& status = link.value()->status();
  if (!status) {
    const pid_t leader = link.value()->LeaderHere();
    if (leader == 0) return;
    const bool stopped = RunStateOf(leader) == ProcessRunState::kStopped;
    facts.controllers.push_back({"", "", leader, {}, {}, false, stopped});
    return;
  }
  ReadMembers(facts, *status);
  note_others(status->other_vendors);
  ControllerFacts controller{status->machine, status->host == HostId() ? "" : status->host,
                             status->pid};
  if (controller.host.empty()) {
    controller.version = VersionOfProcess(status->pid);
    controller.config_file = status->config_file;
  }
  facts.controllers.push_back(std::move(controller));
}

}  // namespace

DoctorFacts ReadFacts(std::optional<MachineConfig> config, const GlobalOptions& global) {
  DoctorFacts facts;
  facts.config = std::move(config);
  facts.environment = transport::OwnEnvironment();
  facts.version = Version();
  facts.now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
  ReadNetwork(facts, global);
  ReadUri(facts);
  if (facts.domain_error.empty() && facts.profile_error.empty()) {
    facts.dds = TryDds(facts.profile, kDdsTime);
  }
  facts.clock = ReadClock();
  if (facts.config) {
    facts.lcm = ReadLcm(*facts.config);
    ReadStorage(facts, kDiskTime);
    facts.programs = CheckPrograms(*facts.config, kProgramTime, Severity::kError);
    facts.ros = CheckRos(*facts.config, facts.environment);
    facts.hosts = ReadOwnHost(*facts.config);
    for (OtherHostFacts& host : ReadOtherHosts(*facts.config)) {
      facts.hosts.push_back(std::move(host));
    }
  }
  facts.limits = ReadLimits();
  facts.core = ReadCore();
  facts.cpu = ReadCpu();
  ReadKeys(facts);
  ReadControllers(facts, global);
  return facts;
}

}  // namespace musher::cli
