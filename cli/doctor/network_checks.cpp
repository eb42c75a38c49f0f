#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "musher/base/joined.hpp"
#include "musher/base/words.hpp"
#include "musher/cli/doctor/checks.hpp"
#include "musher/transport/dds/settings.hpp"

namespace musher::cli {
namespace {

using transport::InterfaceUse;
using transport::NetworkInterface;

// Cyclone's own send buffer, which the profiles do not change.
constexpr std::int64_t kSendBufferBytes = 64 << 10;
// A sample between two processes of an idle host takes less than a millisecond.
constexpr Duration kSlowExchange = Milliseconds(50);

std::string ValueOf(const DoctorFacts& facts, const char* name) {
  const auto found = facts.environment.find(name);
  return found == facts.environment.end() ? "" : found->second;
}

const char* ProfileName(const DoctorFacts& facts) {
  return facts.profile == TransportProfile::kLan ? "lan" : "local";
}

bool HasOwnSettings(const DoctorFacts& facts) {
  return transport::ReplacesProfile(facts.profile, ValueOf(facts, "CYCLONEDDS_URI"));
}

std::string NamesOf(const std::vector<NetworkInterface>& interfaces) {
  std::vector<std::string> names;
  names.reserve(interfaces.size());
  for (const NetworkInterface& one : interfaces) {
    names.push_back(one.name + (one.up ? "" : " (down)"));
  }
  return Joined(names, "none");
}

// The interfaces and addresses that Cyclone's settings name.
std::vector<std::string> NamedInterfaces(const std::string& xml) {
  static const std::regex element(
      R"re(<NetworkInterface\s[^>]*\b(?:name|address)\s*=\s*["']([^"']+)["']|<NetworkInterfaceAddress>\s*([^<\s]+)\s*<)re");
  std::vector<std::string> names;
  for (std::sregex_iterator i(xml.begin(), xml.end(), element), end; i != end; ++i) {
    const std::string name = (*i)[1].matched ? (*i)[1].str() : (*i)[2].str();
    if (name != "auto") names.push_back(name);
  }
  return names;
}

const NetworkInterface* FindInterface(const DoctorFacts& facts, const std::string& name) {
  for (const NetworkInterface& one : facts.interfaces) {
    const auto& addresses = one.addresses;
    const bool by_address = std::find(addresses.begin(), addresses.end(), name) != addresses.end();
    if (one.name == name || by_address) return &one;
  }
  return nullptr;
}

DoctorCheck CheckEnvironment(const DoctorFacts& facts) {
  DoctorCheck check{"DDS environment"};
  if (!facts.domain_error.empty() || !facts.profile_error.empty()) {
    const bool domain = !facts.domain_error.empty();
    check.health = CheckStatus::kError;
    check.reason = domain ? facts.domain_error : facts.profile_error;
    check.fix = domain ? "unset ROS_DOMAIN_ID" : "unset MUSHER_TRANSPORT";
    return check;
  }
  check.reason =
      fmt::format("domain {}, profile {}", facts.domain,
                  HasOwnSettings(facts) ? "replaced by CYCLONEDDS_URI" : ProfileName(facts));
  return check;
}

DoctorCheck CheckCycloneUri(const DoctorFacts& facts) {
  DoctorCheck check{"CYCLONEDDS_URI"};
  const std::string uri = ValueOf(facts, "CYCLONEDDS_URI");
  check.health = CheckStatus::kNotApplicable;
  check.reason = "not set";
  if (uri.empty()) return check;
  check.fix = "unset CYCLONEDDS_URI";
  check.health = CheckStatus::kError;
  check.reason = facts.uri_error;
  if (!facts.uri_error.empty()) return check;
  const std::vector<std::string> names = NamedInterfaces(facts.uri_text);
  for (const std::string& name : names) {
    const NetworkInterface* found = FindInterface(facts, name);
    if (found != nullptr && found->up) continue;
    check.reason =
        fmt::format("it names the interface {}, which {}; interfaces are {}", name,
                    found == nullptr ? "does not exist" : "is down", NamesOf(facts.interfaces));
    if (found != nullptr) check.fix = "sudo ip link set " + found->name + " up";
    return check;
  }
  // Cyclone reads such a text as far as it can, without an error.
  const std::string& xml = facts.uri_text;
  if (xml.find("</CycloneDDS>") == std::string::npos && xml.find("</>") == std::string::npos) {
    check.health = CheckStatus::kWarning;
    check.reason = "its <CycloneDDS> is not closed, so Cyclone may ignore settings";
    return check;
  }
  check.health = CheckStatus::kOk;
  check.fix.clear();
  check.reason = names.empty() ? "it names no interface: Cyclone chooses" : "on " + Joined(names);
  return check;
}

std::vector<std::string> ConfiguredInterfaces(const DoctorFacts& facts) {
  return facts.config ? facts.config->interfaces : std::vector<std::string>();
}

// "eth0 with 192.168.1.7 (an ethernet or wifi device that is up)", of those that are used, or not.
std::vector<std::string> DescribeUses(const DoctorFacts& facts,
                                      const std::vector<InterfaceUse>& uses, bool used) {
  std::vector<std::string> texts;
  for (const InterfaceUse& use : uses) {
    if (use.used != used) continue;
    const NetworkInterface* found = FindInterface(facts, use.name);
    const bool has_address = found != nullptr && !found->addresses.empty();
    texts.push_back(use.name + (used && has_address ? " with " + Joined(found->addresses) : "") +
                    " (" + use.reason + ")");
  }
  return texts;
}

// The interfaces to other hosts, of the profile lan.
void CheckOuterInterfaces(const DoctorFacts& facts, DoctorCheck& check) {
  const auto uses = transport::ChooseInterfaces(facts.interfaces, ConfiguredInterfaces(facts));
  const std::string unused = Joined(DescribeUses(facts, uses, false));
  if (std::ranges::none_of(uses, &InterfaceUse::used)) {
    const auto& all = facts.interfaces;
    const auto down = std::ranges::find_if(all, [](const auto& one) { return !one.up; });
    check.health = CheckStatus::kError;
    check.reason +=
        ", but no interface to other hosts: " + (uses.empty() ? "there is none" : unused);
    check.fix = down != all.end() ? "sudo ip link set " + down->name + " up"
                                  : "connect a network, or use profile = \"local\"";
    return;
  }
  check.reason += "; to other hosts " + Joined(DescribeUses(facts, uses, true));
  if (!unused.empty()) check.reason += "; not used: " + unused;
  for (const InterfaceUse& use : uses) {
    const NetworkInterface* found = FindInterface(facts, use.name);
    if (!use.used || found == nullptr || found->multicast) continue;
    check.health = CheckStatus::kError;
    check.reason +=
        "; " + use.name + " is without multicast: processes of other hosts are not discovered";
    check.fix = "sudo ip link set " + use.name + " multicast on";
  }
}

DoctorCheck CheckInterfaces(const DoctorFacts& facts) {
  DoctorCheck check{"network interface"};
  if (HasOwnSettings(facts)) return NotApplicable(check, "CYCLONEDDS_URI chooses it");
  const auto& all = facts.interfaces;
  const auto loopback = std::ranges::find_if(
      all, [](const auto& one) { return one.loopback && one.up && !one.addresses.empty(); });
  if (loopback == all.end()) {
    check.health = CheckStatus::kError;
    check.reason =
        "no loopback interface with an IPv4 address is up; interfaces are " + NamesOf(all);
    check.fix = "sudo ip link set lo up";
    return check;
  }
  check.reason = loopback->name + " with " + Joined(loopback->addresses);
  if (facts.profile == TransportProfile::kLan) {
    check.reason += " between processes of this host";
    CheckOuterInterfaces(facts, check);
  }
  return check;
}

// Cyclone keeps the interfaces, and their addresses, that it has found when a process started.
DoctorCheck CheckInterfacesInUse(const DoctorFacts& facts) {
  DoctorCheck check{"interfaces in use"};
  if (facts.profile != TransportProfile::kLan || HasOwnSettings(facts)) {
    return NotApplicable(check, "only of the profile lan");
  }
  if (facts.members.empty()) return NotApplicable(check, "no machine runs on this host");
  std::vector<std::string> stale;
  std::vector<std::string> fixes;
  for (const InterfaceUse& use :
       transport::ChooseInterfaces(facts.interfaces, ConfiguredInterfaces(facts))) {
    if (!use.used) continue;
    const std::string address = FindInterface(facts, use.name)->addresses.front();
    for (const MemberFacts& member : facts.members) {
      const auto has = [&](const std::string& one) {
        return std::ranges::count(member.bound, one) != 0;
      };
      // A process of another DDS, or of other settings, does not have the loopback like this.
      if (!has("127.0.0.1") || has(address)) continue;
      const bool controller = member.name.empty();
      stale.push_back(fmt::format("{} (pid {}) not {} with {}",
                                  controller ? "the controller" : member.name, member.pid, use.name,
                                  address));
      fixes.push_back(controller ? "musher up --detach --takeover " +
                                       (facts.config ? ShellWord(facts.config->file) : "FILE")
                                 : "musher restart " + member.name);
    }
  }
  check.reason = fmt::format("{} of this machine use them",
                             Counted(facts.members.size(), "process", "processes"));
  if (stale.empty()) return check;
  check.health = CheckStatus::kWarning;
  check.reason =
      "not all processes use an interface that is up; it has come, or got another "
      "address, after their start: " +
      Joined(stale) + "; they reach each other, and other hosts do not reach them until a restart";
  check.fix = fmt::format("{}", fmt::join(fixes, "; "));
  return check;
}

DoctorCheck CheckExchange(const DoctorFacts& facts) {
  DoctorCheck check{"DDS exchange"};
  if (!facts.domain_error.empty() || !facts.profile_error.empty())
    return NotApplicable(check, "not tried: the DDS environment is not valid");
  if (!facts.dds.error.empty()) {
    check.health = CheckStatus::kError;
    check.reason = facts.dds.error;
    check.fix = ValueOf(facts, "CYCLONEDDS_URI").empty()
                    ? "permit UDP, and multicast to 239.255.0.1, in the firewall of this host"
                    : "unset CYCLONEDDS_URI";
    return check;
  }
  const double exchange_ms = ToSeconds(facts.dds.exchange) * 1000;
  check.reason =
      fmt::format("two processes met after {} ms, a sample there and back takes {:.2f} ms",
                  ToMilliseconds(facts.dds.meeting), exchange_ms);
  if (facts.dds.exchange > kSlowExchange) {
    check.health = CheckStatus::kWarning;
    check.reason += fmt::format(", more than {} ms", ToMilliseconds(kSlowExchange));
    check.fix = "see what takes the CPU: top -H";
  }
  return check;
}

// The interface that probably leads to the board: the first one to other hosts; else the loopback,
// where a simulated board is.
std::string InterfaceToBoard(const DoctorFacts& facts, const LcmFacts& board) {
  if (!board.network_interface.empty()) return board.network_interface;
  for (const NetworkInterface& one : facts.interfaces) {
    if (!one.loopback && one.up && !one.addresses.empty()) return one.name;
  }
  return "lo";
}

// The multicast groups of LCM have no route by default; LCM's own programs then only print a page.
DoctorCheck CheckMotionBoard(const DoctorFacts& facts) {
  DoctorCheck check{"motion board"};
  if (facts.lcm.empty()) return NotApplicable(check, "no actuator has one on LCM");
  std::vector<std::string> reached;
  for (const LcmFacts& board : facts.lcm) {
    const std::string& name = board.network_interface;
    reached.push_back(board.group + (name.empty() ? "" : " by " + name));
    if (board.error.empty()) continue;
    check.health = CheckStatus::kError;
    const std::string device = InterfaceToBoard(facts, board);
    if (FindInterface(facts, device) == nullptr) {
      check.reason = fmt::format(
          "{}: there is no interface {}, which [board] interface names; "
          "interfaces are {}",
          board.actuator, device, NamesOf(facts.interfaces));
      check.fix = "set [board] interface in " + board.file;
      return check;
    }
    check.reason = fmt::format("{}: {}", board.actuator, board.error);
    check.reason = check.reason.substr(0, check.reason.find("; type: "));
    check.fix =
        fmt::format("sudo ip link set {0} up multicast on && sudo ip route add {1}/32 dev {0}",
                    device, board.group);
    return check;
  }
  check.reason = "a route leads to " + Joined(reached);
  return check;
}

DoctorCheck CheckBuffer(const char* key, const std::optional<std::int64_t>& found,
                        std::int64_t wanted, const char* loss) {
  DoctorCheck check{std::string("net.core.") + key};
  if (!found) return NotApplicable(check, "not readable here, as in some containers");
  check.reason = fmt::format("{} bytes; the transport requests {}", *found, wanted);
  if (*found >= wanted) return check;
  check.health = CheckStatus::kWarning;
  check.reason += loss;
  check.fix = fmt::format(
      "echo 'net.core.{} = {}' | sudo tee /etc/sysctl.d/60-musher-{}.conf && sudo sysctl --system",
      key, wanted, key);
  return check;
}

DoctorCheck CheckRos2(const DoctorFacts& facts) {
  DoctorCheck check{"ROS 2 environment"};
  check.health = CheckStatus::kNotApplicable;
  const std::string rmw = ValueOf(facts, "RMW_IMPLEMENTATION");
  const std::string distro = ValueOf(facts, "ROS_DISTRO");
  const bool nodes = facts.config && std::any_of(facts.config->actuators.begin(),
                                                 facts.config->actuators.end(), [](const auto& a) {
                                                   return a.protocol == Protocol::kRos2Lifecycle;
                                                 });
  check.reason = "ROS 2 is not set up in this shell";
  const bool set = !rmw.empty() || !distro.empty() ||
                   !ValueOf(facts, "ROS_LOCALHOST_ONLY").empty() ||
                   !ValueOf(facts, "ROS_AUTOMATIC_DISCOVERY_RANGE").empty();
  if (!facts.other_vendors.empty()) {
    check.health = CheckStatus::kWarning;
    check.reason = fmt::format("{}: {}", fmt::join(facts.other_vendors, "; "),
                               "its services, actions and parameters do not work with Cyclone DDS");
    check.fix = "export RMW_IMPLEMENTATION=rmw_cyclonedds_cpp (in the shell that starts it)";
    return check;
  }
  if (!set && !nodes) return check;
  std::vector<std::string> obstacles;
  obstacles.reserve(facts.ros.size());
  for (const Diagnostic& d : facts.ros) obstacles.push_back(d.message);
  if (obstacles.empty() && set) {
    obstacles = transport::RosObstacles(facts.profile, facts.environment, facts.environment);
  }
  if (obstacles.empty()) {
    check.health = CheckStatus::kOk;
    check.reason = "ROS 2 nodes of this shell discover the machine";
    return check;
  }
  check.health = CheckStatus::kWarning;
  check.reason = fmt::format("{}", fmt::join(obstacles, "; "));
  check.fix = facts.profile == TransportProfile::kLocal && ValueOf(facts, "CYCLONEDDS_URI").empty()
                  ? fmt::format(
                        "unset ROS_LOCALHOST_ONLY ROS_AUTOMATIC_DISCOVERY_RANGE; export "
                        "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp CYCLONEDDS_URI='{}'",
                        transport::kRosOnLoopback)
                  : "unset ROS_LOCALHOST_ONLY ROS_AUTOMATIC_DISCOVERY_RANGE; export "
                    "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp";
  return check;
}

}  // namespace

std::vector<DoctorCheck> CheckNetwork(const DoctorFacts& facts) {
  return {
      CheckEnvironment(facts),
      CheckCycloneUri(facts),
      CheckInterfaces(facts),
      CheckInterfacesInUse(facts),
      CheckExchange(facts),
      CheckMotionBoard(facts),
      CheckBuffer("rmem_max", facts.rmem_max, transport::dds::kReceiveBufferBytes,
                  ": bursts such as pictures overflow the buffer and are repeated"),
      CheckBuffer("wmem_max", facts.wmem_max, kSendBufferBytes, ": large samples are sent slowly"),
      CheckRos2(facts)};
}

}  // namespace musher::cli
