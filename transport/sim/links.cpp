#include "musher/transport/sim/links.hpp"

#include <algorithm>

namespace musher::transport::sim {

HostId Links::Host(const std::string& name) {
  const auto found = std::find(names_.begin(), names_.end(), name);
  if (found != names_.end()) return static_cast<HostId>(found - names_.begin());
  names_.push_back(name);
  offsets_.emplace_back();
  links_.resize(names_.size());
  for (auto& row : links_) row.resize(names_.size(), Link{default_faults_, false, 0});
  return static_cast<HostId>(names_.size() - 1);
}

void Links::SetFaults(const LinkFaults& faults) {
  default_faults_ = faults;
  for (auto& row : links_) {
    for (Link& link : row) link.faults = faults;
  }
}

void Links::SetBlocked(HostId from, HostId to, bool blocked) {
  Link& link = At(from, to);
  link.blocked = blocked;
  ++link.changes;
}

}  // namespace musher::transport::sim
