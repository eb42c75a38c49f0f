#include "musher/transport/sim/delivery.hpp"

#include <algorithm>
#include <utility>

namespace musher::transport::sim {

namespace {

constexpr int kMostLosses = 100;  // of one sample, so that a simulation with total loss ends

bool Reliable(const Channel& channel) {
  return channel.reader->qos.reliability == Qos::Reliability::kReliable;
}

// Adds to a writer's history, which keeps the newest `depth` (0: all).
void Keep(std::deque<Payload>& kept, const Payload& payload, int depth) {
  kept.push_back(payload);
  if (depth > 0 && kept.size() > static_cast<std::size_t>(depth)) kept.pop_front();
}

}  // namespace

void Delivery::Write(WriterEnd& writer, const Payload& payload) {
  if (writer.qos.durability == Qos::Durability::kTransientLocal) {
    Keep(writer.history, payload, writer.qos.depth);
  }
  for (const auto& channel : writer.channels) {
    if (channel->writer_knows) Send(channel, payload);
  }
}

void Delivery::SendHistory(const std::shared_ptr<Channel>& channel) {
  if (channel->reader->qos.durability != Qos::Durability::kTransientLocal) return;
  for (const Payload& payload : channel->writer->history) Send(channel, payload);
}

void Delivery::SendHeld(const std::shared_ptr<Channel>& channel) {
  for (const Payload& payload : std::exchange(channel->held, {})) Send(channel, payload);
}

void Delivery::DeliverEarly(const std::shared_ptr<Channel>& channel) {
  for (const Payload& payload : std::exchange(channel->early, {})) Arrive(*channel, payload);
}

void Delivery::Send(const std::shared_ptr<Channel>& channel, const Payload& payload) {
  const WriterEnd& writer = *channel->writer;
  const ReaderEnd& reader = *channel->reader;
  if (writer.process == reader.process) {
    ArriveAt(scheduler_.now(), channel, payload);
    return;
  }
  const bool reliable = Reliable(*channel);
  if (links_.Blocked(writer.host, reader.host)) {
    if (reliable) Keep(channel->held, payload, writer.qos.depth);
    return;
  }
  const LinkFaults& faults = links_.Faults(writer.host, reader.host);
  if (random_.Bernoulli(reliable ? faults.reliable_loss : faults.loss)) return;

  Time arrival = scheduler_.now() + random_.Between(faults.delay_min, faults.delay_max);
  for (int i = 0; reliable && i < kMostLosses && random_.Bernoulli(faults.loss); ++i) {
    arrival += faults.retransmission;
  }
  if (random_.Bernoulli(faults.reordering)) {
    arrival += random_.Between(Duration::zero(), faults.reordering_delay);
  } else {
    arrival = std::max(arrival, channel->last_arrival);
    channel->last_arrival = arrival;
  }
  ArriveAt(arrival, channel, payload);
  if (random_.Bernoulli(faults.duplication)) {
    ArriveAt(arrival + random_.Between(faults.delay_min, faults.delay_max), channel, payload);
  }
}

void Delivery::ArriveAt(Time when, const std::shared_ptr<Channel>& channel,
                        const Payload& payload) {
  scheduler_.Add(channel->reader->process, when, [channel, payload] { Arrive(*channel, payload); });
}

void Delivery::Arrive(Channel& channel, const Payload& payload) {
  const std::shared_ptr<ReaderEnd> reader = channel.reader;
  if (!reader->open) return;
  if (!channel.reader_knows) {
    if (channel.writer->open && Reliable(channel)) channel.early.push_back(payload);
    return;
  }
  if (reader->callbacks.on_sample) {
    SampleInfo info{channel.writer->id, channel.writer->participant};
    info.written_ns = Duration(payload->at.time_since_epoch()).count();
    if (reader->qos.partition == kEveryPartition) info.partition = channel.writer->qos.partition;
    reader->callbacks.on_sample(payload->bytes, info);
  }
}

}  // namespace musher::transport::sim
