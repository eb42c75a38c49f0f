#pragma once
// The role of an identity, which its certificate names, and how its data is protected.

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace musher::transport::keys {

enum class Role {
  kController,  // leads the machine
  kActuator,    // is controlled
  kOperator,    // sends requests to the controller, for a person
  kObserver,    // reads the machine's status
};

using WallTime = std::chrono::sys_seconds;
std::string IsoTime(WallTime time);  // "2026-01-31T12:00:00Z"

std::string_view RoleName(Role role);
std::optional<Role> RoleFrom(std::string_view name);
inline constexpr Role kRoles[] = {Role::kController, Role::kActuator, Role::kOperator,
                                  Role::kObserver};

// Whether participants without a certificate can read samples on the network.
enum class Protection { kSigned, kEncrypted };

}  // namespace musher::transport::keys
