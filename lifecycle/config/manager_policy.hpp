#pragma once
// What a manager outside the core reads from tables of its own under [policy], such as
// [policy.voice] of CyberDog's. The core keeps it, compares it and prints it, and uses none of it.

#include <memory>
#include <string>
#include <vector>

namespace musher {

// Immutable; the copies of a config share it.
class ManagerPolicy {
 public:
  struct Key {
    std::string table;  // "policy.voice"
    std::string name;
    std::vector<std::string> values;  // one, or the members of a set
    bool is_set = false;              // their order has no meaning

    friend bool operator==(const Key&, const Key&) = default;
  };

  virtual ~ManagerPolicy() = default;

  // All keys of the tables that differ from their defaults, as `musher diff` compares them. Two of
  // the same manager are equal if these are.
  virtual std::vector<Key> Keys() const = 0;
};

// Null: the program has no manager, or the config none of its tables.
using ManagerPolicyPtr = std::shared_ptr<const ManagerPolicy>;

}  // namespace musher
