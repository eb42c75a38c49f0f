#pragma once
// The ends of the simulated wire, plain records: writers, readers, and the channel between a
// matching pair. Each side of a channel learns of the other by itself, at its own time.

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

using Payload = std::shared_ptr<const msg::Bytes>;
struct Channel;

struct End {
  PeerId id = 0;
  PeerId participant = 0;
  ProcessId process = 0;
  HostId host = 0;
  Qos qos;
  bool open = true;  // false: dropped by its owner, or its process has crashed
  PeerTable peers;   // those it has learnt of
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
  bool writer_knows = false;  // of the reader, so it sends
  bool reader_knows = false;  // of the writer, so it accepts
  Time last_arrival;          // of a sample that kept its place
  std::deque<Payload> held;   // reliable samples that a blocked link keeps back
  std::deque<Payload> early;  // reliable samples that arrived before the reader knew

  bool& Knows(Side side) { return side == Side::kWriter ? writer_knows : reader_knows; }
  End& At(Side side) {
    if (side == Side::kWriter) return *writer;
    return *reader;
  }
};

constexpr Side Other(Side side) {
  return side == Side::kWriter ? Side::kReader : Side::kWriter;
}

}  // namespace musher::transport::sim
