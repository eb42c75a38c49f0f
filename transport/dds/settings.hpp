#pragma once
// Cyclone's configuration for the two network profiles.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "musher/base/network_profile.hpp"
#include "musher/base/result.hpp"
#include "musher/transport/dds/dds_node.hpp"

namespace musher::transport::dds {

// What both profiles request for receiving; the kernel may grant less (net.core.rmem_max).
inline constexpr std::int64_t kReceiveBufferBytes = 4 << 20;

// The profile to use: MUSHER_TRANSPORT's, else `configured`.
Result<TransportProfile> ChosenProfile(TransportProfile configured);

// The XML for a profile. `lease`: a process that is silent for longer is lost; none: 10 s local, 2
// s lan. For `unicast` and `own_networks_only` see DdsOptions. `outer`: interfaces to other hosts,
// beside the loopback.
std::string SettingsXml(TransportProfile profile, std::optional<Duration> lease,
                        DiscoveryTiming discovery = DiscoveryTiming::kCombined,
                        bool unicast = false, const std::vector<std::string>& outer = {},
                        bool own_networks_only = false);

}  // namespace musher::transport::dds
