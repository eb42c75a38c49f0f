#include "musher/behavior/tree/port.hpp"

namespace musher::tree::internal {

void FailRead(const std::string& port, const Entry* entry) {
  if (entry == nullptr) throw PortError("port '" + port + "' is not set");
  if (entry->value.empty()) {
    throw PortError("port '" + port + "': the blackboard has no value of '" + entry->key + "'");
  }
  throw PortError("port '" + port + "': the value of '" + entry->key + "' is " +
                  entry->value.Shown() + ", which is not of the port's type");
}

void FailWrite(const std::string& port, const Entry& entry, const Error& error) {
  throw PortError("port '" + port + "', entry '" + entry.key + "': " + error.message);
}

}  // namespace musher::tree::internal
