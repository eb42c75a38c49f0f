#pragma once
// How a library outside the core reads the tables of its manager under [policy].

#include "musher/base/toml/table_reader.hpp"
#include "musher/lifecycle/config/policy_config.hpp"

namespace musher::config_toml {

// Reads the manager's tables from `table`, which is [policy], and completes `policy`, whose own
// keys have been read: with what it has read, and with defaults that only the manager knows.
// Reports errors to `table`; throws nothing.
using ManagerPolicyReader = void (*)(TableReader& table, PolicyConfig& policy);

// From now on this program reads the tables of that manager, and refuses the tables of others; a
// program has one at most. Without a reader, such as in an actuator, they are only listed
// (PolicyConfig::unread_keys), and a controller warns of them.
//
// To be called before main(): an inline variable of the library's header does so. Returns true.
bool RegisterManagerPolicyReader(ManagerPolicyReader reader);

}  // namespace musher::config_toml
