#pragma once
// Delivers samples over the channels of a simulation, with the link's faults.
//
// Reliable samples stay in order, are delayed instead of lost, and wait for a blocked link (the
// newest `depth` of the writer) and for a reader that has not discovered the writer.

#include <memory>

#include "musher/transport/sim/channel.hpp"
#include "musher/transport/sim/links.hpp"
#include "musher/transport/sim/random.hpp"
#include "musher/transport/sim/scheduler.hpp"

namespace musher::transport::sim {

class Delivery {
 public:
  Delivery(Scheduler& scheduler, const Links& links, Random& random)
      : scheduler_(scheduler), links_(links), random_(random) {}

  // Sends a sample from a writer to its discovered readers.
  void Write(WriterEnd& writer, const Payload& payload);

  void SendHistory(const std::shared_ptr<Channel>& channel);  // to a late joiner
  void SendHeld(const std::shared_ptr<Channel>& channel);     // after the link is unblocked
  void DeliverEarly(
      const std::shared_ptr<Channel>& channel);  // once the reader discovers the writer

 private:
  void Send(const std::shared_ptr<Channel>& channel, const Payload& payload);
  void ArriveAt(Time when, const std::shared_ptr<Channel>& channel, const Payload& payload);
  static void Arrive(Channel& channel, const Payload& payload);

  Scheduler& scheduler_;
  const Links& links_;
  Random& random_;
};

}  // namespace musher::transport::sim
