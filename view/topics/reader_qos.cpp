#include "musher/view/topics/reader_qos.hpp"

#include <algorithm>

namespace musher::view {

using transport::Qos;

Qos QosOf(const transport::DiscoveredEndpoint& endpoint) {
  Qos qos;
  qos.reliability = endpoint.reliability;
  qos.durability = endpoint.durability;
  if (!endpoint.partition.empty()) qos.partition = transport::kEveryPartition;
  return qos;
}

Qos QosMatchingAll(const std::vector<Qos>& offered) {
  const auto all = [&offered](auto holds) {
    return std::all_of(offered.begin(), offered.end(), holds);
  };
  Qos qos;
  qos.depth = 0;  // what the loop has not taken yet is not overwritten
  if (!all([](const Qos& one) { return one.reliability == Qos::Reliability::kReliable; })) {
    qos.reliability = Qos::Reliability::kBestEffort;
  }
  if (all([](const Qos& one) { return one.durability == Qos::Durability::kTransientLocal; })) {
    qos.durability = Qos::Durability::kTransientLocal;
  }
  if (!all([](const Qos& one) { return one.partition.empty(); })) {
    qos.partition = transport::kEveryPartition;
  }
  return qos;
}

Qos QosMatchingAll(const std::vector<Qos>& offered, const Qos& present) {
  Qos qos = QosMatchingAll(offered);
  if (present.reliability == Qos::Reliability::kBestEffort) qos.reliability = present.reliability;
  if (present.durability == Qos::Durability::kVolatile) qos.durability = present.durability;
  if (present.partition == transport::kEveryPartition) qos.partition = present.partition;
  return qos;
}

}  // namespace musher::view
