#include "musher/transport/ros_environment.hpp"

#include <unistd.h>

#include "musher/transport/network.hpp"

namespace musher::transport {

namespace {

constexpr const char* kUri = "CYCLONEDDS_URI";
constexpr const char* kRmw = "RMW_IMPLEMENTATION";
constexpr const char* kCyclone = "rmw_cyclonedds_cpp";
constexpr const char* kDomain = "ROS_DOMAIN_ID";
constexpr const char* kRange = "ROS_AUTOMATIC_DISCOVERY_RANGE";
constexpr const char* kLocalhostOnly = "ROS_LOCALHOST_ONLY";

// What is set to nothing is not set, for ROS 2 and for Cyclone.
std::string ValueOf(const Environment& environment, const std::string& name) {
  const auto found = environment.find(name);
  return found == environment.end() ? "" : found->second;
}

std::string DomainOf(const Environment& environment) {
  const std::string domain = ValueOf(environment, kDomain);
  return domain.empty() ? "0" : domain;
}

}  // namespace

const char* const kRosOnLoopback =
    "<CycloneDDS><Domain id=\"any\"><General><Interfaces><NetworkInterface name=\"lo\" "
    "multicast=\"true\"/></Interfaces></General><Discovery><ParticipantIndex>none"
    "</ParticipantIndex></Discovery></Domain></CycloneDDS>";

Environment OwnEnvironment() {
  Environment environment;
  for (char** each = environ; each != nullptr && *each != nullptr; ++each) {
    const std::string_view variable = *each;
    const std::size_t equals = variable.find('=');
    if (equals == std::string_view::npos) continue;
    environment.emplace(variable.substr(0, equals), variable.substr(equals + 1));
  }
  return environment;
}

std::string RosOnInterfaces(const std::vector<std::string>& outer) {
  std::string settings = kRosOnLoopback;
  const std::string loopback = InterfacesXml({});
  return settings.replace(settings.find(loopback), loopback.size(), InterfacesXml(outer));
}

bool ReplacesProfile(TransportProfile profile, std::string_view uri) {
  if (uri.empty()) return false;
  if (profile == TransportProfile::kLocal) return uri != kRosOnLoopback;
  // With whatever interfaces there were when it was made.
  const std::string_view loopback = kRosOnLoopback;
  const std::size_t names = loopback.find("</Interfaces>");
  return uri == loopback || !uri.starts_with(loopback.substr(0, names)) ||
         !uri.ends_with(loopback.substr(names));
}

Environment RosEnvironment(TransportProfile profile, const Environment& environment,
                           const std::vector<std::string>& outer) {
  Environment added;
  if (ValueOf(environment, kRmw).empty()) added[kRmw] = kCyclone;
  if (ValueOf(environment, kUri).empty()) {
    added[kUri] = profile == TransportProfile::kLocal ? kRosOnLoopback : RosOnInterfaces(outer);
  }
  return added;
}

std::string MissingProgramHint(std::string_view program) {
  if (program != "ros2") return "";
  return " (set up ROS 2 in this shell first: . /opt/ros/<distribution>/setup.sh)";
}

std::vector<std::string> RosObstacles(TransportProfile profile, const Environment& machine,
                                      const Environment& node) {
  std::vector<std::string> obstacles;
  const std::string rmw = ValueOf(node, kRmw);
  if (rmw != kCyclone) {
    obstacles.push_back((rmw.empty() ? std::string(kRmw) + " is not set: most ROS 2 distributions "
                                                           "then take Fast DDS"
                                     : std::string(kRmw) + " is " + rmw) +
                        ", whose services Musher cannot call; set it to " + kCyclone);
  }
  if (DomainOf(node) != DomainOf(machine)) {
    obstacles.push_back(std::string(kDomain) + " is " + DomainOf(node) +
                        ", but the machine is in domain " + DomainOf(machine) +
                        "; use the same one");
  }
  if (const std::string only = ValueOf(node, kLocalhostOnly); !only.empty() && only != "0") {
    obstacles.push_back(std::string(kLocalhostOnly) + " is " + only +
                        ": ROS 2 then finds only processes on fixed ports, and Musher's have none; "
                        "unset it");
  }
  if (const std::string range = ValueOf(node, kRange); range == "LOCALHOST" || range == "OFF") {
    obstacles.push_back(std::string(kRange) + " is " + range +
                        ": ROS 2 then finds no processes by multicast; unset it or set SUBNET");
  }
  const std::string uri = ValueOf(node, kUri);
  // Nothing is known of settings of the person's own, and the text of a file is not read.
  const bool own_settings = ReplacesProfile(profile, ValueOf(machine, kUri));
  if (profile == TransportProfile::kLocal && !own_settings && !uri.starts_with("file:") &&
      uri.find("\"lo\"") == std::string::npos) {
    obstacles.push_back(std::string(kUri) +
                        (uri.empty() ? " is not set" : " does not name the interface lo") +
                        ": a machine of the profile local is found on multicast over lo only; set "
                        "it to " +
                        kRosOnLoopback + " or use [transport] profile = \"lan\"");
  }
  return obstacles;
}

}  // namespace musher::transport
