#include "musher/transport/sim/discovery.hpp"

#include <algorithm>

#include "musher/transport/sim/delivery.hpp"

namespace musher::transport::sim {

namespace {

// DDS's rule: a writer must offer at least what a reader requests.
bool Compatible(const Qos& offered, const Qos& requested) {
  return (offered.reliability == Qos::Reliability::kReliable ||
          requested.reliability == Qos::Reliability::kBestEffort) &&
         (offered.durability == Qos::Durability::kTransientLocal ||
          requested.durability == Qos::Durability::kVolatile) &&
         (offered.partition == requested.partition || requested.partition == kEveryPartition);
}

bool SameProcess(const Channel& channel) {
  return channel.writer->process == channel.reader->process;
}

}  // namespace

void Discovery::SetDelay(Duration least, Duration most) {
  delay_min_ = least;
  delay_max_ = most;
}

void Discovery::Add(const std::string& topic, const std::string& type,
                    const std::shared_ptr<WriterEnd>& writer) {
  Topic& ends = topics_[{topic, type}];
  ends.writers.push_back(writer);
  for (const auto& reader : ends.readers) Match(writer, reader);
}

void Discovery::Add(const std::string& topic, const std::string& type,
                    const std::shared_ptr<ReaderEnd>& reader) {
  Topic& ends = topics_[{topic, type}];
  ends.readers.push_back(reader);
  for (const auto& writer : ends.writers) Match(writer, reader);
}

void Discovery::Match(const std::shared_ptr<WriterEnd>& writer,
                      const std::shared_ptr<ReaderEnd>& reader) {
  if (!writer->open || !reader->open || !Compatible(writer->qos, reader->qos)) return;
  auto channel = std::make_shared<Channel>();
  channel->writer = writer;
  channel->reader = reader;
  writer->channels.push_back(channel);
  reader->channels.push_back(channel);
  channels_.push_back(channel);
  Discover(channel, Side::kWriter);
  Discover(channel, Side::kReader);
}

std::pair<Duration, Duration> Discovery::DelayBetween(HostId a, HostId b) const {
  for (const HostId host : {a, b}) {
    if (const auto delay = delays_of_.find(host); delay != delays_of_.end()) return delay->second;
  }
  return {delay_min_, delay_max_};
}

void Discovery::Discover(const std::shared_ptr<Channel>& channel, Side side) {
  const End& learner = channel->At(side);
  const End& other = channel->At(Other(side));
  Time when = scheduler_.now();
  if (!SameProcess(*channel)) {
    Time& last = last_announcement_[{other.process, learner.process, side}];
    const auto [least, most] = DelayBetween(other.host, learner.host);
    when = std::max(when + random_.Between(least, most), last);
    last = when;
  }
  scheduler_.Add(learner.process, when, [this, channel, side] { Learn(channel, side); });
}

void Discovery::Learn(const std::shared_ptr<Channel>& channel, Side side) {
  End& learner = channel->At(side);
  const End& other = channel->At(Other(side));
  if (!learner.open || !other.open || channel->Knows(side) || Blocked(*channel, side)) return;
  if (AnEarlierOneIsUnknown(*channel, side)) return;  // LinkChanged() has announced both again
  channel->Knows(side) = true;
  learner.peers.Add(other.id, other.participant);
  if (side == Side::kWriter) {
    delivery_.SendHistory(channel);
    const auto writer = channel->writer;
    if (writer->callbacks.on_match_changed) writer->callbacks.on_match_changed();
  } else {
    delivery_.DeliverEarly(channel);
    const auto reader = channel->reader;
    if (reader->open && reader->callbacks.on_match_changed) reader->callbacks.on_match_changed();
  }
}

// An announcement that a blocked link has dropped is repeated before the later ones of its process.
bool Discovery::AnEarlierOneIsUnknown(const Channel& channel, Side side) const {
  const ProcessId announced = channel.At(Other(side)).process;
  const ProcessId learner = channel.At(side).process;
  for (const auto& earlier : channels_) {
    if (earlier.get() == &channel) return false;
    if (earlier->At(side).process == learner && earlier->At(Other(side)).process == announced &&
        earlier->At(side).open && earlier->At(Other(side)).open && !earlier->Knows(side))
      return true;
  }
  return false;
}

void Discovery::ForgetAt(Time when, const std::shared_ptr<Channel>& channel, Side side,
                         bool silent) {
  scheduler_.Add(channel->At(side).process, when, [this, channel, side, silent] {
    // A blocked link drops the notification of a deletion; the lease still expires.
    if (silent || !Blocked(*channel, side)) Forget(channel, side);
  });
}

void Discovery::Forget(const std::shared_ptr<Channel>& channel, Side side) {
  if (!channel->Knows(side)) return;
  channel->Knows(side) = false;
  const EndpointId other = channel->At(Other(side)).id;
  channel->At(side).peers.Remove(other);
  Remove(channel);
  if (side == Side::kWriter) {
    channel->held.clear();
    const auto writer = channel->writer;
    if (writer->callbacks.on_match_changed) writer->callbacks.on_match_changed();
    return;
  }
  const auto reader = channel->reader;
  if (reader->callbacks.on_writer_lost) reader->callbacks.on_writer_lost(other);
  if (reader->open && reader->callbacks.on_match_changed) reader->callbacks.on_match_changed();
}

void Discovery::Close(End& end, Time crash_noticed, bool crashed) {
  if (!end.open) return;
  end.open = false;
  for (auto& [name, topic] : topics_) {
    std::erase_if(topic.writers, [&](const auto& writer) { return writer.get() == &end; });
    std::erase_if(topic.readers, [&](const auto& reader) { return reader.get() == &end; });
  }
  const auto channels = end.channels;
  for (const auto& channel : channels) {
    const Side own = channel->writer.get() == &end ? Side::kWriter : Side::kReader;
    const Side other = Other(own);
    const End& peer = channel->At(other);
    channel->Knows(own) = false;
    end.peers.Remove(peer.id);
    if (!channel->Knows(other) || !peer.open) {
      channel->Knows(other) = false;
      Remove(channel);
      continue;
    }
    Time when = crash_noticed;
    if (!crashed) {
      const LinkFaults& link = links_.Faults(end.host, peer.host);
      when = scheduler_.now();
      if (!SameProcess(*channel)) when += random_.Between(link.delay_min, link.delay_max);
      when = std::max(when, channel->last_arrival);
    }
    ForgetAt(when, channel, other, crashed);
  }
}

void Discovery::Crash(ProcessId process) {
  const Time noticed = scheduler_.now() + random_.Between(lease_ / 2, lease_);
  std::vector<std::shared_ptr<End>> ends;
  for (auto& [name, topic] : topics_) {
    ends.insert(ends.end(), topic.writers.begin(), topic.writers.end());
    ends.insert(ends.end(), topic.readers.begin(), topic.readers.end());
  }
  for (const auto& end : ends) {
    if (end->process == process) Close(*end, noticed, true);
  }
}

void Discovery::LinkChanged(HostId from, HostId to) {
  if (links_.Blocked(from, to)) {
    const Time over = scheduler_.now() + random_.Between(lease_ / 2, lease_);
    const auto change = links_.Changes(from, to);
    scheduler_.Add(0, over, [this, from, to, change] {
      if (links_.Changes(from, to) == change) ExpireLeases(from, to);
    });
    return;
  }
  const auto channels = channels_;
  for (const auto& channel : channels) {
    for (const Side side : {Side::kWriter, Side::kReader}) {
      if (!ReceivesOver(*channel, side, from, to)) continue;
      if (!channel->At(Other(side)).open) {
        ForgetAt(scheduler_.now() + links_.Faults(from, to).delay_max, channel, side, false);
      } else if (!channel->Knows(side)) {
        Discover(channel, side);
      }
    }
    if (channel->writer->host == from && channel->reader->host == to) delivery_.SendHeld(channel);
  }
}

void Discovery::ExpireLeases(HostId from, HostId to) {
  const auto channels = channels_;
  for (const auto& channel : channels) {
    for (const Side side : {Side::kWriter, Side::kReader}) {
      if (ReceivesOver(*channel, side, from, to)) ForgetAt(scheduler_.now(), channel, side, true);
    }
  }
}

// Drops a channel that is no longer used. `channel` must not be an element of these lists.
void Discovery::Remove(const std::shared_ptr<Channel>& channel) {
  if (channel->writer_knows || channel->reader_knows) return;
  if (channel->writer->open && channel->reader->open) return;
  std::erase(channel->writer->channels, channel);
  std::erase(channel->reader->channels, channel);
  std::erase(channels_, channel);
}

bool Discovery::ReceivesOver(const Channel& channel, Side side, HostId from, HostId to) {
  const HostId writer = channel.writer->host;
  const HostId reader = channel.reader->host;
  return side == Side::kWriter ? reader == from && writer == to : writer == from && reader == to;
}

bool Discovery::Blocked(const Channel& channel, Side side) const {
  if (SameProcess(channel)) return false;
  const HostId writer = channel.writer->host;
  const HostId reader = channel.reader->host;
  return side == Side::kWriter ? links_.Blocked(reader, writer) : links_.Blocked(writer, reader);
}

}  // namespace musher::transport::sim
