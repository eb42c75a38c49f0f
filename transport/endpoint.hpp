#pragma once
// What a transport has to offer: untyped writers and readers of samples. Typed publishers,
// subscriptions, clients and servers are built on these in node.hpp, once for every transport.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "musher/lifecycle/result.hpp"
#include "musher/lifecycle/time.hpp"
#include "musher/messages/cdr.hpp"

namespace musher::transport {

inline constexpr std::string_view kEveryPartition = "*";  // for readers

struct Qos {
  enum class Reliability { kReliable, kBestEffort };
  enum class Durability { kVolatile, kTransientLocal };

  Reliability reliability = Reliability::kReliable;
  Durability durability = Durability::kVolatile;
  int depth = 10;  // keep last so many; 0 = keep all
  // Writers and readers of a topic meet in the same partition; "*" is every one. Empty: the default
  // one, and ROS 2's. What it views outlives the endpoint.
  std::string_view partition = {};
  // What is older is not delivered any more; zero: no such limit. Not in the simulation.
  Duration lifespan{};

  friend bool operator==(const Qos&, const Qos&) = default;
};

// ROS 2's profiles by their usual names (rmw_qos_profile_*).
inline constexpr Qos kDefaultQos{};  // topics and services
inline constexpr Qos kSensorDataQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 5};
inline constexpr Qos kSystemDefaultQos{Qos::Reliability::kReliable, Qos::Durability::kVolatile, 1};
inline constexpr Qos kLatchedQos{Qos::Reliability::kReliable, Qos::Durability::kTransientLocal, 1};
// The reader's side of a latched topic with many writers: keyless topics have one history for all.
inline constexpr Qos kLatchedFromManyQos{Qos::Reliability::kReliable,
                                         Qos::Durability::kTransientLocal, 0};

// Signs of life from many: one that is lost is followed by the next.
inline constexpr Qos kHeartbeatQos{Qos::Reliability::kBestEffort, Qos::Durability::kVolatile, 0};

// A writer or reader of another participant, or that participant itself, which keeps its number
// when it was out of reach meanwhile. 0 is nobody.
using PeerId = std::uint64_t;

struct SampleInfo {
  PeerId writer = 0;       // of the sample
  PeerId participant = 0;  // that the writer belongs to
  // The partition it was written in, for readers of partition "*" only. With security on nobody
  // writes in one that is not his own.
  std::optional<std::string_view> partition = std::nullopt;
};

class RawWriter {
 public:
  virtual ~RawWriter() = default;

  // Sends one encoded sample, which is not copied again. Fails when the transport refuses it
  // (oversized, history full).
  virtual Result<> Write(msg::Bytes bytes) = 0;

  // Blocks until every matched reliable reader has all that was written: for a program that ends
  // after it. Timeout when one has not by then.
  virtual Result<> Flush(Duration timeout) = 0;

  // How many readers are matched, and how many of them belong to `participant`.
  virtual int MatchedReaders() const = 0;
  virtual int ReadersOf(PeerId participant) const = 0;
  bool HasReaderOf(PeerId participant) const { return ReadersOf(participant) > 0; }

  // A number for this writer that no other in the domain has.
  virtual std::uint64_t UniqueId() const = 0;
};

class RawReader {
 public:
  virtual ~RawReader() = default;

  // How many writers are matched, and how many of them belong to `participant`.
  virtual int MatchedWriters() const = 0;
  virtual int WritersOf(PeerId participant) const = 0;
  bool HasWriterOf(PeerId participant) const { return WritersOf(participant) > 0; }

  // The participants of the matched writers, each once.
  virtual std::vector<PeerId> WriterParticipants() const = 0;
};

// All run on the loop. A reader's callbacks never run after the reader is gone.
struct ReaderCallbacks {
  std::function<void(std::span<const std::byte>, const SampleInfo&)> on_sample;
  // A writer has gone (deleted, its process died, its host is unreachable). It was matched before.
  std::function<void(PeerId writer)> on_writer_lost;
  std::function<void()> on_match_changed;
};

struct WriterCallbacks {
  std::function<void()> on_match_changed;
};

}  // namespace musher::transport
