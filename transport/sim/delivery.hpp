#pragma once
// Carries samples over the channels of a simulation, with the faults of the link.
//
// A reliable sample keeps its place behind the earlier ones, is late instead of lost, waits out a
// blocked link (the newest `depth` of the writer do) and a reader that has not learnt of the
// writer.

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

  // From a writer to the readers it knows.
  void Write(WriterEnd& writer, const Payload& payload);

  void SendHistory(const std::shared_ptr<Channel>& channel);   // to a late joiner
  void SendHeld(const std::shared_ptr<Channel>& channel);      // after a link is free again
  void DeliverEarly(const std::shared_ptr<Channel>& channel);  // once the reader knows the writer

 private:
  void Send(const std::shared_ptr<Channel>& channel, const Payload& payload);
  void ArriveAt(Time when, const std::shared_ptr<Channel>& channel, const Payload& payload);
  static void Arrive(Channel& channel, const Payload& payload);

  Scheduler& scheduler_;
  const Links& links_;
  Random& random_;
};

}  // namespace musher::transport::sim
