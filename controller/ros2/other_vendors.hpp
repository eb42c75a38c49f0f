#pragma once
// The participants of the domain whose DDS is not Cyclone. Topics work with them; services and
// actions do not, because each DDS has its own form of them: a node that does not answer looks like
// a broken one. So the machine's status names them, with the cure.
//
// Threads: loop thread only.

#include <deque>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "musher/transport/node.hpp"

namespace musher {

// "Fast DDS"; a vendor id without a name: "another DDS (vendor 01.42)".
std::string VendorName(std::uint16_t vendor);

// A text for each of `peers` with another vendor, sorted: "process 812 of host dog1 runs Fast DDS".
// `node` knows the ROS 2 nodes of the peers.
std::vector<std::string> DescribeOtherVendors(const transport::Node& node,
                                              const std::vector<transport::PeerInfo>& peers);
// What to do about them.
inline constexpr const char* kOtherVendorCure =
    "its topics work, its services, actions and parameters do not; start it with "
    "RMW_IMPLEMENTATION=rmw_cyclonedds_cpp";

// Looks every few seconds: a participant needs seconds to be discovered.
class OtherVendors {
 public:
  // `on_change` gets all of them; `on_new` each one when it is seen for the first time, at most 8
  // in an hour.
  using OnChange = std::function<void(std::vector<std::string>)>;
  using OnNew = std::function<void(const std::string&)>;
  OtherVendors(transport::Node& node, OnChange on_change, OnNew on_new);

 private:
  void Look();
  bool MayReport();

  transport::Node& node_;
  const OnChange on_change_;
  const OnNew on_new_;
  std::vector<std::string> last_;
  std::set<transport::ParticipantId> seen_;  // of those that exist
  std::deque<Time> reported_;                // to on_new_, in the last hour
  transport::LoopHandlePtr timer_;
};

}  // namespace musher
