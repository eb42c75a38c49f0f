#pragma once
// The endpoints of the simulated transport, plain records: writers, readers, and the channel
// between a matching pair. Each side of a channel discovers the other independently, at its own
// time.

#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "musher/messages/cdr.hpp"
#include "musher/transport/endpoint.hpp"
#include "musher/transport/peer_table.hpp"
#include "musher/transport/sim/links.hpp"
#include "musher/transport/sim/scheduler.hpp"

namespace musher::transport::sim {

struct Written {
  msg::Bytes bytes;
  Time at{};
};
using Payload = std::shared_ptr<const Written>;
struct Channel;

struct End {
  EndpointId id = 0;
  ParticipantId participant = 0;
  ProcessId process = 0;
  HostId host = 0;
  Qos qos;
  bool open = true;  // false: dropped by its owner, or its process has crashed
  PeerTable peers;   // the discovered ones
  std::vector<std::shared_ptr<Channel>> channels;
};

struct WriterEnd : End {
  WriterCallbacks callbacks;
  std::deque<Payload> history;  // for late joiners; empty when volatile
};

struct ReaderEnd : End {
  ReaderCallbacks callbacks;
};

enum class Side { kWriter, kReader };

struct Channel {
  std::shared_ptr<WriterEnd> writer;
  std::shared_ptr<ReaderEnd> reader;
  bool writer_knows = false;  // has discovered the reader, so it sends
  bool reader_knows = false;  // has discovered the writer, so it accepts
  Time last_arrival;          // of a sample in order
  std::deque<Payload> held;   // reliable samples held by a blocked link
  std::deque<Payload> early;  // reliable samples that arrived before the reader's discovery

  bool& Knows(Side side) { return side == Side::kWriter ? writer_knows : reader_knows; }
  End& At(Side side) const {
    if (side == Side::kWriter) return *writer;
    return *reader;
  }
};

constexpr Side Other(Side side) {
  return side == Side::kWriter ? Side::kReader : Side::kWriter;
}

}  // namespace musher::transport::sim
