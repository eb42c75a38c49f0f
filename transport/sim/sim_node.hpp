#pragma once
// A node on the simulated network.

#include <memory>
#include <string>

#include "musher/transport/node.hpp"
#include "musher/transport/sim/network.hpp"
#include "musher/transport/sim/sim_loop.hpp"

namespace musher::transport::sim {

class SimNode : public Node {
 public:
  SimNode(Network& network, HostId host);
  SimNode(const SimNode&) = delete;
  SimNode& operator=(const SimNode&) = delete;
  ~SimNode() override { network_.scheduler_.Kill(process_); }

  EventLoop& loop() override { return loop_; }
  ParticipantId participant() const override { return participant_; }
  Result<std::unique_ptr<RawWriter>> MakeRawWriter(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   WriterCallbacks callbacks) override;
  Result<std::unique_ptr<RawReader>> MakeRawReader(const std::string& topic,
                                                   const std::string& type, const Qos& qos,
                                                   ReaderCallbacks callbacks) override;

  ProcessId process() const { return process_; }

 private:
  void FillIn(End& end, const Qos& qos) const;

  Network& network_;
  HostId host_;
  ProcessId process_;
  ParticipantId participant_;
  SimLoop loop_;
};

}  // namespace musher::transport::sim
