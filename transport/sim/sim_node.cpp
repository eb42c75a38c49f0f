#include "musher/transport/sim/sim_node.hpp"

#include <utility>

namespace musher::transport::sim {

namespace {

class SimWriter : public RawWriter {
 public:
  SimWriter(const Network& network, std::string topic, Discovery& discovery, Delivery& delivery,
            std::shared_ptr<WriterEnd> end)
      : network_(network),
        topic_(std::move(topic)),
        discovery_(discovery),
        delivery_(delivery),
        end_(std::move(end)) {}
  SimWriter(const SimWriter&) = delete;
  SimWriter& operator=(const SimWriter&) = delete;
  ~SimWriter() override { discovery_.Close(*end_); }

  Result<> Write(msg::Bytes bytes) override {
    if (!end_->open) return Error{kCodeNetError, "the process has crashed"};
    if (network_.on_write) network_.on_write(end_->participant, topic_, bytes);
    delivery_.Write(*end_,
                    std::make_shared<const Written>(Written{std::move(bytes), network_.now()}));
    return Ok();
  }
  // Virtual time cannot pass in here, and written samples arrive without a flush.
  Result<> Flush(Duration) override { return Ok(); }
  int MatchedReaders() const override { return end_->peers.size(); }
  int ReadersOf(ParticipantId participant) const override {
    return end_->peers.CountOf(participant);
  }
  std::uint64_t UniqueId() const override { return end_->id.value(); }

 private:
  const Network& network_;
  const std::string topic_;
  Discovery& discovery_;
  Delivery& delivery_;
  std::shared_ptr<WriterEnd> end_;
};

class SimReader : public RawReader {
 public:
  SimReader(Discovery& discovery, std::shared_ptr<ReaderEnd> end)
      : discovery_(discovery), end_(std::move(end)) {}
  SimReader(const SimReader&) = delete;
  SimReader& operator=(const SimReader&) = delete;
  ~SimReader() override { discovery_.Close(*end_); }

  int MatchedWriters() const override { return end_->peers.size(); }
  int WritersOf(ParticipantId participant) const override {
    return end_->peers.CountOf(participant);
  }
  std::vector<ParticipantId> WriterParticipants() const override {
    return end_->peers.Participants();
  }

 private:
  Discovery& discovery_;
  std::shared_ptr<ReaderEnd> end_;
};

}  // namespace

SimNode::SimNode(Network& network, HostId host)
    : network_(network),
      host_(host),
      process_(network.scheduler_.AddProcess()),
      participant_(network.next_id_++),
      loop_(network.scheduler_, process_, network.links_, host) {}

Result<std::unique_ptr<RawWriter>> SimNode::MakeRawWriter(const std::string& topic,
                                                          const std::string& type, const Qos& qos,
                                                          WriterCallbacks callbacks) {
  auto end = std::make_shared<WriterEnd>();
  FillIn(*end, qos);
  end->callbacks = std::move(callbacks);
  if (end->open) network_.discovery_.Add(topic, type, end);
  return std::unique_ptr<RawWriter>(std::make_unique<SimWriter>(
      network_, topic, network_.discovery_, network_.delivery_, std::move(end)));
}

Result<std::unique_ptr<RawReader>> SimNode::MakeRawReader(const std::string& topic,
                                                          const std::string& type, const Qos& qos,
                                                          ReaderCallbacks callbacks) {
  auto end = std::make_shared<ReaderEnd>();
  FillIn(*end, qos);
  end->callbacks = std::move(callbacks);
  if (end->open) network_.discovery_.Add(topic, type, end);
  return std::unique_ptr<RawReader>(
      std::make_unique<SimReader>(network_.discovery_, std::move(end)));
}

void SimNode::FillIn(End& end, const Qos& qos) const {
  end.id = EndpointId(network_.next_id_++);
  end.participant = participant_;
  end.process = process_;
  end.host = host_;
  end.qos = qos;
  end.open = network_.scheduler_.Alive(process_);
}

}  // namespace musher::transport::sim
