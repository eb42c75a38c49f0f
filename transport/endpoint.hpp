#pragma once
// The interface of a transport: untyped writers and readers of samples. node.hpp and service.hpp
// build typed publishers, subscriptions, clients and servers on them, once for every transport.
//
// Threads: loop thread only, callbacks too.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "musher/base/result.hpp"
#include "musher/base/strong_number.hpp"
#include "musher/base/time.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::transport {

inline constexpr std::string_view kEveryPartition = "*";  // for readers

struct Qos {
  enum class Reliability { kReliable, kBestEffort };
  enum class Durability { kVolatile, kTransientLocal };

  Reliability reliability = Reliability::kReliable;
  Durability durability = Durability::kVolatile;
  int depth = 10;  // keep last; 0 = keep all
  // Writers and readers of a topic match in the same partition; "*" matches all. Empty: the default
  // one, as in ROS 2. The viewed text must outlive the endpoint.
  std::string_view partition = {};
  // Older samples are not delivered; zero: no limit. The simulation ignores it.
  Duration lifespan{};

  friend bool operator==(const Qos&, const Qos&) = default;
};

// ROS 2's profiles by their usual names (rmw_qos_profile_*).
inline constexpr Qos kDefaultQos{};  // topics and services
inline constexpr Qos kSensorDataQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 5};
inline constexpr Qos kSystemDefaultQos{Qos::Reliability::kReliable, Qos::Durability::kVolatile, 1};
inline constexpr Qos kLatchedQos{Qos::Reliability::kReliable, Qos::Durability::kTransientLocal, 1};
// For readers of a latched topic with many writers: keyless topics have one history for all
// writers.
inline constexpr Qos kLatchedFromManyQos{Qos::Reliability::kReliable,
                                         Qos::Durability::kTransientLocal, 0};

// Heartbeats of many writers: a lost one needs no retransmission.
inline constexpr Qos kHeartbeatQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 0};

// A writer or reader of another participant. 0: none.
using EndpointId = StrongNumber<struct EndpointKind>;
// Another participant, which keeps its id after its connection was lost. 0: none.
using ParticipantId = StrongNumber<struct ParticipantKind>;

// Another participant, by what it says of itself: that proves nothing.
struct PeerInfo {
  ParticipantId id = 0;
  std::int32_t pid = 0;      // of its process, on `host`; 0: not said
  std::string host;          // HostName() of its host; empty: not said
  std::uint16_t vendor = 0;  // of its DDS, as the OMG numbers them: 0x0110 is Cyclone
  std::string name;          // of Musher: of its user ("alice@dog1") or node ("/dog1/arm")
};

// A fault of another participant, reported each time that it occurs.
struct PeerFault {
  ParticipantId participant = 0;  // 0: not known
  std::string topic;              // on DDS: "rt/chat"
  std::string what;               // "sends samples that are no std_msgs::msg::dds_::String_"
};

struct SampleInfo {
  EndpointId writer = 0;          // of the sample
  ParticipantId participant = 0;  // of the writer
  // The partition of the sample, for readers of partition "*" only. With security on a participant
  // can only write in its own partition.
  std::optional<std::string_view> partition = std::nullopt;
  // When it was written, by the writer's wall clock: the same for every reader, also of a sample
  // that is delivered again. 0: not known. The simulation has one wall clock.
  std::int64_t written_ns = 0;
};

class RawWriter {
 public:
  virtual ~RawWriter() = default;

  // Sends one encoded sample without another copy. Fails if the transport refuses it (oversized,
  // history full).
  virtual Result<> Write(msg::Bytes bytes) = 0;
  // Sends a sample that only readers of `participant` need. While such a reader is not ready for
  // the sample, the samples for other participants are not delayed.
  virtual Result<> WriteFor(ParticipantId /*participant*/, msg::Bytes bytes) {
    return Write(std::move(bytes));
  }

  // Runs `work` once the transport delays no written sample: at once, unless it does. It may drop
  // the writer, and does not run after that.
  virtual void AfterWrites(std::function<void()> work) { work(); }  // NOLINT(*-value-param)

  // Blocks until every matched reliable reader has all samples: for a program that then exits.
  // Fails with a timeout if one has not.
  virtual Result<> Flush(Duration timeout) = 0;

  // The number of matched readers: of all participants, and of `participant`.
  virtual int MatchedReaders() const = 0;
  virtual int ReadersOf(ParticipantId participant) const = 0;
  bool HasReaderOf(ParticipantId participant) const { return ReadersOf(participant) > 0; }

  // An id of this writer, unique in the domain.
  virtual std::uint64_t UniqueId() const = 0;
};

class RawReader {
 public:
  virtual ~RawReader() = default;

  // The number of matched writers: of all participants, and of `participant`.
  virtual int MatchedWriters() const = 0;
  virtual int WritersOf(ParticipantId participant) const = 0;
  bool HasWriterOf(ParticipantId participant) const { return WritersOf(participant) > 0; }

  // The participants of the matched writers, each once.
  virtual std::vector<ParticipantId> WriterParticipants() const = 0;
};

// All run on the loop, never after their reader is dropped.
struct ReaderCallbacks {
  std::function<void(std::span<const std::byte>, const SampleInfo&)> on_sample;
  // A matched writer is lost (deleted, its process crashed, its host is unreachable).
  std::function<void(EndpointId writer)> on_writer_lost;
  std::function<void()> on_match_changed;
  // The type of a matched writer has the name of the topic's type, and another definition.
  std::function<void(ParticipantId participant, const std::string& type_hash)> on_type_differs = {};
};

struct WriterCallbacks {
  std::function<void()> on_match_changed;
};

}  // namespace musher::transport
