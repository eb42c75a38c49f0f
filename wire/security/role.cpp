#include "musher/wire/security/role.hpp"

#include <algorithm>
#include <iterator>

namespace musher::transport::keys {

std::string_view RoleName(Role role) {
  switch (role) {
    case Role::kController:
      return "controller";
    case Role::kActuator:
      return "actuator";
    case Role::kOperator:
      return "operator";
    case Role::kObserver:
      break;
  }
  return "observer";
}

std::optional<Role> RoleFrom(std::string_view name) {
  const auto* const found = std::find_if(std::begin(kRoles), std::end(kRoles),
                                         [name](Role role) { return RoleName(role) == name; });
  if (found == std::end(kRoles)) return std::nullopt;
  return *found;
}

}  // namespace musher::transport::keys
