#include "musher/transport/dds/settings.hpp"

#include <cstdlib>

namespace musher::transport::dds {

namespace {

std::string Element(const std::string& name, const std::string& value) {
  return "<" + name + ">" + value + "</" + name + ">";
}

std::string Millis(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + "ms";
}

// A process says that it lives several times in each lease.
std::string Discovery(Duration lease) {
  // "none": each process takes any free port, so that there is no limit to their number.
  return Element("Discovery", Element("ParticipantIndex", "none") +
                                  Element("LeaseDuration", Millis(lease)) +
                                  Element("SPDPInterval", Millis(lease / 4)));
}

// The receive buffer is a wish: the kernel gives what it allows. A writer that goes waits only so
// long for readers that have not acknowledged everything.
std::string Buffers(const std::string& linger) {
  return "<SocketReceiveBufferSize max=\"4MB\"/>" + Element("WriterLingerDuration", linger);
}

// Loopback loses nothing but what overflows a buffer. When a hundred processes start at once,
// answers that come slowly and together are what lets discovery settle. The first repetition comes
// after 400 ms: what was lost between two processes that have just met delays a start by that much;
// with 200 ms a start of a hundred takes half as long again. A repetition that was asked for too
// early is not sent (Cyclone's writer does not count its sample as sent yet), so it is asked for
// again, soon: a ROS 2 client's first request is often lost like that, and its own next heartbeat
// is 100 ms away. What a new process has announced is asked for after 13 ms: it hears of us within
// some 12, and does not answer one that it does not know.
constexpr const char* kDefaultDiscoveryTiming =
    "<HeartbeatInterval min=\"100ms\" minsched=\"200ms\" max=\"8s\">400ms</HeartbeatInterval>"
    "<PreEmptiveAckDelay>13ms</PreEmptiveAckDelay>"
    "<NackDelay>10ms</NackDelay><AutoReschedNackDelay>10ms</AutoReschedNackDelay>"
    "<AckDelay>100ms</AckDelay>";
// Of a few processes that must not wait for a repetition.
constexpr const char* kFastDiscoveryTiming =
    "<HeartbeatInterval min=\"0ms\" minsched=\"5ms\" max=\"8s\">10ms</HeartbeatInterval>"
    "<NackDelay>5ms</NackDelay><AutoReschedNackDelay>10ms</AutoReschedNackDelay>"
    "<AckDelay>0ms</AckDelay>";

// Processes are met by multicast, samples come by unicast.
std::string Multicast(bool unicast) {
  return unicast ? Element("AllowMulticast", "spdp") : "";
}

std::string LocalXml(Duration lease, bool fast_discovery, bool unicast) {
  return Element("General",
                 Multicast(unicast) +
                     Element("Interfaces", "<NetworkInterface name=\"lo\" multicast=\"true\"/>") +
                     Element("MaxMessageSize", "65500B")) +
         Discovery(lease) +
         Element("Internal", (fast_discovery ? kFastDiscoveryTiming : kDefaultDiscoveryTiming) +
                                 Buffers("20ms"));
}

// Links that lose packets: losses are noticed and repaired within tens of milliseconds.
std::string LanXml(Duration lease, bool unicast) {
  return (unicast ? Element("General", Multicast(true)) : "") + Discovery(lease) +
         Element("Internal",
                 "<HeartbeatInterval min=\"2ms\" minsched=\"5ms\" max=\"8s\">10ms"
                 "</HeartbeatInterval>" +
                     Element("NackDelay", "10ms") + Element("AutoReschedNackDelay", "100ms") +
                     Buffers("200ms"));
}

}  // namespace

Result<TransportProfile> ChosenProfile(TransportProfile configured) {
  const char* chosen = std::getenv("MUSHER_TRANSPORT");
  if (chosen == nullptr || *chosen == '\0') return configured;
  const std::string profile = chosen;
  if (profile == "local") return TransportProfile::kLocal;
  if (profile == "lan") return TransportProfile::kLan;
  return Error{kCodeParametersInvalid,
               "MUSHER_TRANSPORT is \"" + profile + "\": expected \"local\" or \"lan\""};
}

std::string SettingsXml(TransportProfile profile, std::optional<Duration> lease,
                        bool fast_discovery, bool unicast) {
  const std::string domain =
      profile == TransportProfile::kLocal
          ? LocalXml(lease.value_or(std::chrono::seconds(10)), fast_discovery, unicast)
          : LanXml(lease.value_or(std::chrono::seconds(2)), unicast);
  return Element("CycloneDDS", Element("Domain", domain));
}

}  // namespace musher::transport::dds
