#pragma once
// The two XML documents of DDS Security's access control: governance and permissions.
//
// The governance is the same for the whole robot: every participant needs a certificate, discovery
// is protected, and a topic is open only to identities whose permissions name it. Each identity has
// permissions of its own. Their rules apply in order: first what the role may do on the topics of
// Musher and of the controller's extension, then a denial of everything else on them, then the
// rest, the modules' data, is open.
//
// Topics carry the name of their actuator, except the status and the heartbeat, which all actuators
// publish on one topic. There each writes in the partition of its name, and its permissions name
// that partition: so no actuator can publish in another's name.

#include <string>

#include "musher/transport/security/wall_time.hpp"
#include "musher/wire/security/extension_interfaces.hpp"
#include "musher/wire/security/role.hpp"

namespace musher::transport::keys {

// Whether participants without a certificate can read samples on the network.
enum class Protection { kSigned, kEncrypted };

std::string GovernanceXml(Protection protection);

struct Grant {
  std::string name;     // of the identity; an actuator has its name of the config
  std::string subject;  // of its certificate, as RFC 2253 writes it
  Role role = Role::kObserver;
  WallTime not_before;
  WallTime not_after;
};

// `extension`: of the controller; {}: none.
std::string PermissionsXml(const Grant& grant, const ExtensionInterfaces& extension);

}  // namespace musher::transport::keys
