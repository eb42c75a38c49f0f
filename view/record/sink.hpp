#pragma once
// Where a recorder puts what it receives: a file, a ring of files, or a test.

#include <cstddef>
#include <cstdint>
#include <string>

#include "musher/messages/cdr.hpp"

namespace musher::view {

struct RecordedChannel {
  std::string topic;        // "/chat"
  std::string type;         // of DDS
  std::string offered_qos;  // see qos_text.hpp
  bool latched = false;     // its last sample is still true later
};

// Threads: loop thread only; nothing here waits for a disk.
class Sink {
 public:
  virtual ~Sink() = default;

  // The channel's id, which Write() takes.
  virtual std::size_t AddChannel(const RecordedChannel& channel) = 0;
  // `log_ns`: when it was received, since 1970. False: there is no room, the sample is lost.
  virtual bool Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) = 0;
};

}  // namespace musher::view
