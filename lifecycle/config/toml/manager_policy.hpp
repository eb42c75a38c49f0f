#pragma once
// How a library outside the core reads the tables of its manager under [policy].

#include "musher/base/toml/table_reader.hpp"
#include "musher/lifecycle/config/policy_config.hpp"

namespace musher::config_toml {

// Reads the manager's tables from `table`, which is [policy], and completes `policy`, whose own
// keys have been read: with what it has read, and with defaults that only the manager knows.
// Reports errors to `table`; throws nothing.
using ManagerPolicyReader = void (*)(TableReader& table, PolicyConfig& policy);

// From now on this program reads the tables of that manager; those of another one are errors. A
// program without a reader, such as an actuator, skips tables of [policy] that it does not know:
// the controller has checked them. To be called before a config is read; an inline variable of the
// library's header does so, whose value it returns.
bool ReadManagerPolicyBy(ManagerPolicyReader reader);

}  // namespace musher::config_toml
