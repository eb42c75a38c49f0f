#pragma once
// A node on Cyclone DDS: speaks ROS 2's wire. Nothing of Cyclone is needed to include this.
//
// The nodes of a process that are in the same domain are one participant, with the configuration of
// the first.

#include <memory>
#include <optional>
#include <string>

#include "musher/lifecycle/config.hpp"
#include "musher/transport/node.hpp"

namespace musher::transport {

// Who a process is, and the folder with the keys that prove it (see transport/keys/).
struct Credentials {
  std::string keys;      // absolute
  std::string identity;  // "controller", "operator", or an actuator's name

  friend bool operator==(const Credentials&, const Credentials&) = default;
};

struct DdsOptions {
  // Of the domain; none: that of ROS_DOMAIN_ID, else 0.
  std::optional<int> domain_id = std::nullopt;
  // MUSHER_TRANSPORT=local|lan overrides it, and the user's own CYCLONEDDS_URI overrides both.
  TransportProfile profile = TransportProfile::kLocal;
  // After how long a silent process is taken for lost; none: the profile's.
  std::optional<Duration> lease = std::nullopt;
  // Repeats at once what a process that it has just met may have missed. For those of which a robot
  // has few, controllers and command lines; a hundred actuators that start together settle sooner
  // when they are patient. MUSHER_FAST_DISCOVERY in the environment says the same: a controller
  // sets it for a process that it starts again while the others stay.
  bool fast_discovery = false;
  // Gets the samples that it reads sent to itself alone. By default a sample that several processes
  // read goes out once, by multicast, and the kernel copies it to every process of the domain,
  // whether it reads that topic or not: right for what is small, dear for pictures. For programs
  // that read pictures; MUSHER_UNICAST in the environment says the same.
  bool unicast = false;
  // With them the node meets only those whose certificate is of the same CA, and may do only what
  // its permissions say; without them only those without. All nodes of a process that are in one
  // domain have the same.
  std::optional<Credentials> credentials = std::nullopt;
  // As what ROS 2 lists the node (`ros2 node list`): its name, none: that of the program with its
  // process id, and its namespace ("" or "dog1"). What ROS 2 does not accept in a name becomes '_'.
  std::string node_name = {};
  std::string name_space = {};
  // Without a name: is listed only to those who ask for hidden nodes. For command lines, which end
  // when they have been answered.
  bool hidden = false;
  // Whose message layout ROS 2 is told of the nodes in; none: see ChosenDistro().
  std::optional<RosDistro> ros_distro = std::nullopt;
};

// What the config says of a process that is `identity`, with `node_name` as its node in the
// machine's namespace.
DdsOptions OptionsFor(const MachineConfig& config, const std::string& identity,
                      const std::string& node_name);

// Those of `identity` where the config has keys.
std::optional<Credentials> CredentialsFor(const MachineConfig& config, const std::string& identity);
inline constexpr const char* kControllerIdentity = "controller";

// The ROS 2 node of a controller, in the namespace of its machine: its services are `/musher/…`.
inline constexpr const char* kControllerNode = "musher";

// The domain that `options` and the environment give; an Error when it is not one of 0 to 232.
Result<int> DomainId(const DdsOptions& options);

// The ROS 2 distribution whose message layouts are spoken: `configured`, else that of ROS_DISTRO,
// else Jazzy, whose layouts newer ones have, too.
RosDistro ChosenDistro(std::optional<RosDistro> configured);

// The profile that `options` and the environment give; an Error when the environment's is none.
Result<TransportProfile> Profile(const DdsOptions& options);

// Joins the domain. Fails when the configuration is bad or the network can't be used, with
// Cyclone's reason; and when the credentials are, with the file and what is wrong with it. The loop
// must outlive the node.
Result<std::unique_ptr<Node>> MakeDdsNode(EventLoop& loop, const DdsOptions& options = {});

}  // namespace musher::transport
