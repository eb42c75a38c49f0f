#pragma once
// A node on Cyclone DDS, compatible with ROS 2 on the wire. This header needs no header of Cyclone.
//
// All nodes of a process in one domain share one participant, with the configuration of the first
// node.
//
// Threads: MakeDdsNode() and the node on the loop thread, or before the loop runs; the rest any.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/network_profile.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

// The identity of a process, and the folder with the keys that prove it (see transport/security/).
struct Credentials {
  std::string keys;      // absolute
  std::string identity;  // "controller", "operator", or an actuator's name

  friend bool operator==(const Credentials&, const Credentials&) = default;
};

// How soon a process requests and repeats what may have been lost in discovery (profile local; lan
// has one timing).
enum class DiscoveryTiming {
  kCombined,      // waits a little and combines
  kCombinedLong,  // waits long and combines: of a hundred processes that start together
  kAtOnce,        // for a program that exits after its reply
  kOnceKnown,     // at once, but lets a new process discover this one first
};

struct DdsOptions {
  // The domain's id; none: ROS_DOMAIN_ID, else 0.
  std::optional<int> domain_id = std::nullopt;
  // MUSHER_TRANSPORT=local|lan overrides it, and the user's own CYCLONEDDS_URI overrides both.
  TransportProfile profile = TransportProfile::kLocal;
  // The interfaces to other hosts, for the profile lan, at most kMostOuterInterfaces; none: see
  // ChooseInterfaces(). Processes of this host use the loopback in any case.
  std::vector<std::string> interfaces = {};
  // In the profile lan, the node sends only to addresses in the networks of its interfaces. If off,
  // Cyclone may choose an address in another network, and leaves the route to the kernel.
  bool own_networks_only = false;
  // The process is a controller: it has to reach the actuators of its host at any address.
  bool controller = false;
  // The lease: a process that is silent for longer counts as lost; none: the profile's.
  std::optional<Duration> lease = std::nullopt;
  // MUSHER_FAST_DISCOVERY in the environment replaces kCombined and kCombinedLong by kAtOnce. The
  // program that restarts a process while the others keep running sets it.
  DiscoveryTiming discovery = DiscoveryTiming::kCombined;
  // Receives its samples by unicast. By default a sample with several readers is sent once, by
  // multicast, and the kernel copies it to every process of the domain, whether it reads that topic
  // or not: good for small samples, expensive for pictures. For programs that read pictures;
  // MUSHER_UNICAST in the environment has the same effect.
  bool unicast = false;
  // With credentials the node discovers only participants whose certificate is of the same CA, and
  // may do only what its permissions permit; without credentials it discovers only participants
  // without. All nodes of a process in one domain have the same.
  std::optional<Credentials> credentials = std::nullopt;
  // The node's name in ROS 2 (`ros2 node list`), none: the program's name with its process id; and
  // its namespace ("" or "dog1"). A character that ROS 2 does not accept in a name becomes '_'.
  std::string node_name = {};
  std::string name_space = {};
  // For a node without a name: listed only among hidden nodes. For command lines, which exit after
  // their reply.
  bool hidden = false;
  // The ROS 2 distribution whose message layout lists the nodes; none: see ChosenDistro().
  std::optional<RosDistro> ros_distro = std::nullopt;
};

// The domain from `options` and the environment; an Error when it is not within 0 to 232.
Result<int> DomainId(const DdsOptions& options);

// The ROS 2 distribution whose message layouts are used: `configured`, else ROS_DISTRO, else Jazzy,
// whose layouts newer distributions use, too.
RosDistro ChosenDistro(std::optional<RosDistro> configured);

// The profile from `options` and the environment; an Error when the environment's is invalid.
Result<TransportProfile> Profile(const DdsOptions& options);
// Whether a node with these options may reach other hosts: its profile is kLan, or has an error.
bool ReachesOtherHosts(const DdsOptions& options = {});

// Joins the domain. Fails if the configuration is invalid or the network cannot be used, with
// Cyclone's reason; and if the credentials are invalid, with the file and its error. The loop must
// outlive the node.
Result<std::unique_ptr<Node>> MakeDdsNode(EventLoop& loop, const DdsOptions& options = {});

}  // namespace musher::transport
