#include "musher/controller/ros2/other_vendors.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace musher {
namespace {

constexpr std::uint16_t kCyclone = 0x0110;
constexpr Duration kVendorPeriod = std::chrono::seconds(5);
constexpr std::size_t kMost = 8;  // any number of participants may come, again and again
constexpr Duration kReportPeriod = std::chrono::hours(1);

bool IsOther(const transport::PeerInfo& peer) {
  return peer.vendor != kCyclone;
}

std::string Describe(const transport::Node& node, const transport::PeerInfo& peer) {
  std::string who = peer.pid == 0 ? "a process" : "process " + std::to_string(peer.pid);
  if (!peer.host.empty()) who += " of host " + peer.host.substr(0, 64);
  const std::string name = node.RosNodeOf(peer.id);
  if (!name.empty()) who += " (" + name + ")";
  return who + " runs " + VendorName(peer.vendor);
}

}  // namespace

std::string VendorName(std::uint16_t vendor) {
  switch (vendor) {
    case kCyclone:
      return "Cyclone DDS";
    case 0x010f:
      return "Fast DDS";
    case 0x0101:
      return "RTI Connext";
    case 0x0103:
      return "OpenDDS";
    default:
      break;
  }
  char id[8];
  std::snprintf(id, sizeof(id), "%02x.%02x", vendor >> 8U, vendor & 0xffU);
  return std::string("another DDS (vendor ") + id + ")";
}

std::vector<std::string> DescribeOtherVendors(const transport::Node& node,
                                              const std::vector<transport::PeerInfo>& peers) {
  std::vector<std::string> others;
  for (const transport::PeerInfo& peer : peers) {
    if (IsOther(peer) && others.size() < kMost) others.push_back(Describe(node, peer));
  }
  std::sort(others.begin(), others.end());
  return others;
}

OtherVendors::OtherVendors(transport::Node& node, OnChange on_change, OnNew on_new)
    : node_(node), on_change_(std::move(on_change)), on_new_(std::move(on_new)) {
  Look();
}

void OtherVendors::Look() {
  const std::vector<transport::PeerInfo> peers = node_.Peers();
  // A node that is respawned is another participant each time.
  std::erase_if(seen_, [&](transport::ParticipantId id) {
    return std::ranges::count(peers, id, &transport::PeerInfo::id) == 0;
  });
  for (const transport::PeerInfo& peer : peers) {
    if (!IsOther(peer) || seen_.contains(peer.id) || !MayReport()) continue;
    seen_.insert(peer.id);
    on_new_(Describe(node_, peer));
  }
  std::vector<std::string> now = DescribeOtherVendors(node_, peers);
  if (now != last_) on_change_(now);
  last_ = std::move(now);
  timer_ = node_.loop().At(node_.loop().Now() + kVendorPeriod, [this] { Look(); });
}

// Whether a peer may be reported now. A peer that has to wait is reported later, if it still exists
// then.
bool OtherVendors::MayReport() {
  const Time now = node_.loop().Now();
  while (!reported_.empty() && now - reported_.front() >= kReportPeriod) reported_.pop_front();
  if (reported_.size() >= kMost) return false;
  reported_.push_back(now);
  return true;
}

}  // namespace musher
