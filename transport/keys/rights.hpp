#pragma once
// Who may do what: the two documents by which DDS Security's access control decides, as XML.
//
// The governance is the same for all of a robot: everybody needs a certificate, discovery is
// protected, and every topic is open only to those whose permissions name it. The permissions are
// one's own. Their rules are judged in order: first what the role may do on Musher's own topics,
// then that nothing else may be done on them, then that the rest, the modules' data, is free.
//
// Topics carry the name of the actuator that they are for, except its status and its beat, which
// all actuators publish on one topic. There each writes in a partition of its own name, and its
// permissions name that partition: so nobody speaks in another's name.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace musher::transport::keys {

enum class Role {
  kController,  // leads the machine
  kActuator,    // is led
  kOperator,    // asks the controller, for a person
  kObserver,    // reads how the machine is
};

using WallTime = std::chrono::sys_seconds;
std::string IsoTime(WallTime time);  // "2026-01-31T12:00:00Z"

std::string_view RoleName(Role role);
std::optional<Role> RoleFrom(std::string_view name);
inline constexpr Role kRoles[] = {Role::kController, Role::kActuator, Role::kOperator,
                                  Role::kObserver};

// Whether samples can be read on the network by those without a certificate.
enum class Protection { kSigned, kEncrypted };

std::string GovernanceXml(Protection protection);

struct Grant {
  std::string name;     // of the identity; an actuator's is that of the config
  std::string subject;  // of its certificate, as RFC 2253 writes it
  Role role = Role::kObserver;
  WallTime not_before;
  WallTime not_after;
};

std::string PermissionsXml(const Grant& grant);

}  // namespace musher::transport::keys
