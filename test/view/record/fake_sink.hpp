#pragma once
// A sink that keeps everything in memory.

#include <vector>

#include "musher/view/record/sink.hpp"

namespace musher::view {

struct FakeSink : Sink {
  struct Sample {
    std::size_t channel;
    std::int64_t log_ns;
    msg::Bytes data;
  };

  std::size_t AddChannel(const RecordedChannel& channel) override {
    channels.push_back(channel);
    return channels.size() - 1;
  }
  bool Write(std::size_t channel, std::int64_t log_ns, msg::Bytes data) override {
    if (full) return false;
    samples.push_back({channel, log_ns, std::move(data)});
    return true;
  }

  std::vector<RecordedChannel> channels;
  std::vector<Sample> samples;
  bool full = false;
};

}  // namespace musher::view
