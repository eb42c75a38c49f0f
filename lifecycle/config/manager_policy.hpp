#pragma once
// What a manager outside the core reads from tables of its own under [policy], such as
// [policy.voice] of CyberDog's. The core keeps it, compares it and prints it, and uses none of it.

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace musher {

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

  // All keys of the tables, as `musher diff` compares them; none if all have their defaults.
  virtual std::vector<Key> Keys() const = 0;
};

// The same as a value of the config, which its copies share. Two are equal if their keys are.
class SharedManagerPolicy {
 public:
  SharedManagerPolicy() = default;
  explicit SharedManagerPolicy(std::shared_ptr<const ManagerPolicy> policy)
      : policy_(std::move(policy)) {}

  // Null: the program has no manager.
  const ManagerPolicy* get() const { return policy_.get(); }
  std::vector<ManagerPolicy::Key> Keys() const {
    return policy_ ? policy_->Keys() : std::vector<ManagerPolicy::Key>();
  }

  friend bool operator==(const SharedManagerPolicy& one, const SharedManagerPolicy& other) {
    return one.Keys() == other.Keys();
  }

 private:
  std::shared_ptr<const ManagerPolicy> policy_;
};

}  // namespace musher
