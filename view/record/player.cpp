#include "musher/view/record/player.hpp"

#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/transport/clock.hpp"

namespace musher::view {
namespace {

constexpr Duration kClockPeriod = Milliseconds(10);
constexpr int kMessagesPerTurn = 64;  // then the loop does other work

}  // namespace

Player::Player(transport::Node& node, PlaySource& source, PlayOptions options, OnEnd on_end)
    : node_(node), source_(source), options_(std::move(options)), on_end_(std::move(on_end)) {}

Result<std::unique_ptr<Player>> Player::Start(transport::Node& node, PlaySource& source,
                                              PlayOptions options, OnEnd on_end) {
  std::unique_ptr<Player> player(new Player(node, source, std::move(options), std::move(on_end)));
  if (auto made = player->MakeWriters(); !made) return made.error();
  player->Begin(node.loop().Now() + player->options_.discovery);
  return player;
}

Result<> Player::MakeWriters() {
  for (const PlayedChannel& channel : source_.channels()) {
    const std::string name = options_.remapping.NameOf(channel.topic);
    commands_.push_back(IsCommand(name, channel.type));
    if (options_.clock && name == std::string("/") + transport::kClockTopic) {
      writers_.emplace_back();
      continue;
    }
    auto writer = node_.MakeRawWriter("rt" + name, channel.type, channel.qos, {});
    if (!writer) return Error{writer.error().code, name + ": " + writer.error().message};
    writers_.push_back(std::move(writer).value());
  }
  if (!options_.clock) return Ok();
  auto clock = transport::MakePublisher<msg::Clock>(node_, transport::kClockTopic);
  if (!clock) return clock.error();
  clock_ = std::move(clock).value();
  return Ok();
}

void Player::Begin(Time when) {
  any_ = false;
  timer_ = node_.loop().At(when, [this, when] {
    if (!Take()) return;
    schedule_.emplace(when, next_->log_ns, options_.rate);
    if (clock_) {
      const auto publish = [this] {
        const std::chrono::nanoseconds time(schedule_->At(node_.loop().Now()));
        static_cast<void>(clock_->Publish({msg::ToStamp(time)}));
      };
      publish();
      tick_ = node_.loop().Every(kClockPeriod, publish);
    }
    Go();
  });
}

void Player::Go() {
  for (int i = 0; i < kMessagesPerTurn; ++i) {
    const Time due = schedule_->DueAt(next_->log_ns);
    if (due > node_.loop().Now()) {
      timer_ = node_.loop().At(due, [this] { Go(); });
      return;
    }
    const bool withheld =
        commands_[next_->channel] && options_.withholds_commands && options_.withholds_commands();
    if (auto& writer = writers_[next_->channel]; writer && !withheld) {
      if (auto written = writer->Write(std::move(next_->data)); !written) return End(written);
      ++published_;
    }
    if (!Take()) return;
  }
  timer_ = node_.loop().At(node_.loop().Now(), [this] { Go(); });
}

bool Player::Take() {
  auto next = source_.Next();
  if (!next) {
    End(next.error());
    return false;
  }
  next_ = std::move(next).value();
  if (next_) {
    any_ = true;
    return true;
  }
  if (!options_.loop || !any_) {
    End(Ok());
    return false;
  }
  tick_.reset();
  if (auto rewound = source_.Rewind(); !rewound) {
    End(rewound);
  } else {
    Begin(node_.loop().Now());
  }
  return false;
}

void Player::End(const Result<>& result) {
  if (std::exchange(ended_, true)) return;
  tick_.reset();
  on_end_(result);
}

Result<> Player::Flush(Duration timeout) {
  for (const auto& writer : writers_) {
    if (!writer) continue;
    if (auto flushed = writer->Flush(timeout); !flushed) return flushed;
  }
  return Ok();
}

}  // namespace musher::view
