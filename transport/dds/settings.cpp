#include "musher/transport/dds/settings.hpp"

#include <cstdlib>

#include "musher/transport/network.hpp"

namespace musher::transport::dds {

namespace {

std::string Element(const std::string& name, const std::string& value) {
  return "<" + name + ">" + value + "</" + name + ">";
}

std::string Millis(Duration duration) {
  return std::to_string(ToMilliseconds(duration)) + "ms";
}

// A process announces its liveliness several times in each lease.
std::string Discovery(Duration lease) {
  // "none": each process takes any free port, so that their number is not limited.
  return Element("Discovery", Element("ParticipantIndex", "none") +
                                  Element("LeaseDuration", Millis(lease)) +
                                  Element("SPDPInterval", Millis(lease / 4)));
}

// The receive buffer is the requested size: the kernel may grant less. The linger is how long a
// writer that is destroyed waits for readers that have not acknowledged everything.
std::string Buffers(const std::string& linger) {
  return "<SocketReceiveBufferSize max=\"" + std::to_string(kReceiveBufferBytes >> 20) + "MB\"/>" +
         Element("WriterLingerDuration", linger);
}

// No repetition waits longer than a second: what a stopped process has lost meanwhile arrives while
// it still refuses what may be late (base/break_watch.hpp), and a status that was lost before a
// hang delays the detection of the hang by no more.
//
// Loopback loses only what overflows a buffer. A loss between two processes that have just
// discovered each other is repaired by the next repetition, after 100 ms. With 400 ms the start of
// 16 actuators takes 0.73 s instead of 0.39 s, and of 24 actuators 1.1 s instead of 0.8 s; only the
// start of 48 takes some 15 % less with 400 ms. A repetition that is requested too early is not
// sent (Cyclone's writer does not count its sample as sent yet), so it is requested again after 50
// ms: the first request of a ROS 2 client is often lost like that. With 10 ms the start of 32
// processes sends up to twice as many packets. What a new process has announced is requested after
// 13 ms: it discovers this process within about 12 ms, and does not respond to an unknown one.
constexpr const char* kCombinedTiming =
    "<HeartbeatInterval min=\"20ms\" minsched=\"50ms\" max=\"1s\">100ms</HeartbeatInterval>"
    "<PreEmptiveAckDelay>13ms</PreEmptiveAckDelay>"
    "<NackDelay>10ms</NackDelay><AutoReschedNackDelay>50ms</AutoReschedNackDelay>"
    "<AckDelay>100ms</AckDelay>";
// When a hundred processes start at once on two cores, each is kept from its packets long enough
// for its buffer to overflow, and a repetition that is requested early is one packet more for all
// them: with the timing above the start of 100 takes 20 to 29 s, with this one 10 to 14 s. Delays
// of 300 to 400 ms instead of 13 and 100 ms gain nothing more, and delay an emergency stop from the
// command line, which takes 0.15 to 0.5 s with these (up to 1.3 s within seconds of the start).
constexpr const char* kCombinedLongTiming =
    "<HeartbeatInterval min=\"400ms\" minsched=\"500ms\" max=\"1s\">1s</HeartbeatInterval>"
    "<PreEmptiveAckDelay>13ms</PreEmptiveAckDelay>"
    "<NackDelay>100ms</NackDelay><AutoReschedNackDelay>1s</AutoReschedNackDelay>"
    "<AckDelay>100ms</AckDelay>";
// For a few processes that must not wait for a repetition. Cyclone requests what a new process has
// announced after 10 ms.
constexpr const char* kAtOnceTiming =
    "<HeartbeatInterval min=\"0ms\" minsched=\"5ms\" max=\"1s\">10ms</HeartbeatInterval>"
    "<NackDelay>5ms</NackDelay><AutoReschedNackDelay>10ms</AutoReschedNackDelay>"
    "<AckDelay>0ms</AckDelay>";
// An actuator that has just started discovers the controller some 20 ms after the controller
// discovers it, and drops a request that arrives before: with 10 ms the start of eight actuators
// takes 0.5 s in half of the starts, with 30 ms always 0.15 s, with 100 ms 0.28 s.
constexpr const char* kRequestAfter = "<PreEmptiveAckDelay>30ms</PreEmptiveAckDelay>";

std::string TimingXml(DiscoveryTiming timing) {
  switch (timing) {
    case DiscoveryTiming::kCombined:
      return kCombinedTiming;
    case DiscoveryTiming::kCombinedLong:
      return kCombinedLongTiming;
    case DiscoveryTiming::kAtOnce:
      return kAtOnceTiming;
    case DiscoveryTiming::kOnceKnown:
      break;
  }
  return std::string(kAtOnceTiming) + kRequestAfter;
}

// Discovery is by multicast, samples are sent by unicast.
std::string Multicast(bool unicast) {
  return unicast ? Element("AllowMulticast", "spdp") : "";
}

std::string LocalXml(Duration lease, DiscoveryTiming discovery, bool unicast) {
  return Element("General",
                 Multicast(unicast) + InterfacesXml({}) + Element("MaxMessageSize", "65500B")) +
         Discovery(lease) + Element("Internal", TimingXml(discovery) + Buffers("20ms"));
}

// Links that lose packets: losses are detected and repaired within tens of milliseconds. Cyclone
// prefers the loopback where both processes have it, so a link that is lost concerns other hosts
// only.
std::string LanXml(Duration lease, bool unicast, const std::vector<std::string>& outer,
                   bool own_networks_only) {
  const std::string route = own_networks_only ? Element("DontRoute", "true") : "";
  return Element("General", Multicast(unicast) + route + InterfacesXml(outer)) + Discovery(lease) +
         Element("Internal",
                 "<HeartbeatInterval min=\"2ms\" minsched=\"5ms\" max=\"1s\">10ms"
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
                        DiscoveryTiming discovery, bool unicast,
                        const std::vector<std::string>& outer, bool own_networks_only) {
  const std::string domain =
      profile == TransportProfile::kLocal
          ? LocalXml(lease.value_or(std::chrono::seconds(10)), discovery, unicast)
          : LanXml(lease.value_or(std::chrono::seconds(2)), unicast, outer, own_networks_only);
  return Element("CycloneDDS", Element("Domain", domain));
}

}  // namespace musher::transport::dds
