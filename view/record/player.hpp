#pragma once
// Publishes what was recorded: each message at its time and with its topic's QoS, and /clock.
//
// Threads: loop thread only.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/messages/rosgraph_msgs/clock.hpp"
#include "musher/transport/node.hpp"
#include "musher/view/record/playback.hpp"

namespace musher::view {

struct PlayedChannel {
  std::string topic;  // "/chat", as recorded
  std::string type;   // of DDS
  transport::Qos qos;
};

struct PlayedMessage {
  std::size_t channel = 0;
  std::int64_t log_ns = 0;
  msg::Bytes data;
};

// A recording, in the order of its times.
class PlaySource {
 public:
  virtual ~PlaySource() = default;

  virtual const std::vector<PlayedChannel>& channels() const = 0;
  // nullopt: the end.
  virtual Result<std::optional<PlayedMessage>> Next() = 0;
  // Restarts at the beginning.
  virtual Result<> Rewind() = 0;
};

struct PlayOptions {
  double rate = 1.0;
  bool loop = false;
  bool clock = true;                       // publishes /clock instead of a recorded one
  Duration discovery = Milliseconds(500);  // before the first message, for subscribers to match
  TopicNames remapping;
  // While it returns true, commands (IsCommand) are not published, and are lost; may be empty.
  std::function<bool()> withholds_commands{};
};

class Player {
 public:
  using OnEnd = std::function<void(const Result<>&)>;

  // Makes the publishers and starts. `on_end` runs after the last message, or with the reason why
  // nothing more can be read or published.
  static Result<std::unique_ptr<Player>> Start(transport::Node& node, PlaySource& source,
                                               PlayOptions options, OnEnd on_end);

  std::uint64_t published() const { return published_; }
  // Waits until reliable subscribers have all; for a program that then exits.
  Result<> Flush(Duration timeout);

 private:
  Player(transport::Node& node, PlaySource& source, PlayOptions options, OnEnd on_end);

  Result<> MakeWriters();
  void Begin(Time when);
  void Go();
  bool Take();  // the next message; false: the recording has ended, or failed
  void End(const Result<>& result);

  transport::Node& node_;
  PlaySource& source_;
  PlayOptions options_;
  OnEnd on_end_;
  std::vector<std::unique_ptr<transport::RawWriter>> writers_;  // null: not played
  std::vector<bool> commands_;                                  // whether the channel is one
  std::unique_ptr<transport::Publisher<msg::Clock>> clock_;
  std::optional<PlaySchedule> schedule_;
  std::optional<PlayedMessage> next_;
  std::uint64_t published_ = 0;
  bool ended_ = false;
  bool any_ = false;  // message in this round
  transport::LoopHandlePtr tick_;
  transport::LoopHandlePtr timer_;
};

}  // namespace musher::view
