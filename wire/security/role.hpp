#pragma once
// The role of an identity, which its certificate names: what it may do on Musher's topics.

#include <optional>
#include <string_view>

namespace musher::transport::keys {

enum class Role {
  kController,  // leads the machine
  kActuator,    // is controlled
  kOperator,    // sends requests to the controller, for a person
  kObserver,    // reads the machine's status
};

std::string_view RoleName(Role role);
std::optional<Role> RoleFrom(std::string_view name);
inline constexpr Role kRoles[] = {Role::kController, Role::kActuator, Role::kOperator,
                                  Role::kObserver};

}  // namespace musher::transport::keys
