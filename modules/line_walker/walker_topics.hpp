#pragma once
// The line walker on the network: commands and odometry in, the status and frames of a servo motion
// out. The lines are subscribed to only during a walk and a self-check. Runs on any transport.
//
// Threads: the loop's.

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/base/log.hpp"
#include "musher/base/rate_limited_log.hpp"
#include "musher/messages/protocol/motion.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/line_walker/line_walker.hpp"
#include "musher/modules/line_walker/walker_config.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/endpoints.hpp"
#include "musher/transport/loop_breaks.hpp"
#include "musher/transport/publisher_turns.hpp"

namespace musher::line_walker {

struct Dependencies {
  transport::Node& node;
  transport::Clock& clock;
  std::string name_space;
  std::function<void(LogLevel level, const std::string& line)> log;
};

class WalkerTopics {
 public:
  static Result<std::unique_ptr<WalkerTopics>> Make(const Dependencies& dependencies,
                                                    const WalkerConfig& config);

  // Whether START is accepted. A walk ends with false, at once; `why` is logged.
  void Permit(bool permitted, const std::string& why);
  // The world was restarted, or its time has jumped for another reason, `why`: a walk ends.
  void OnTimeJump(const std::string& why) { EndWalk(why); }

  // Subscribes to the lines for a check. Fails when that is not possible.
  Result<> SetChecked(bool checked);
  // A motion manager subscribes to the frames, and one detector of each view publishes its lines;
  // only while checked.
  Result<> Check() const;

  const LineWalker& walker() const { return walker_; }

 private:
  // While it walks or is checked.
  struct Lines {
    explicit Lines(const Dependencies& dependencies)
        : endpoints(dependencies.node, dependencies.name_space) {}

    transport::Subscription* left = nullptr;
    transport::Subscription* right = nullptr;
    transport::Subscription* front = nullptr;
    std::array<transport::PublisherTurns, 3> publishers;  // by View
    transport::Endpoints endpoints;
  };

  WalkerTopics(const Dependencies& dependencies, WalkerConfig config);
  Result<> Open();
  void OnCommand(const std::string& word);
  void OnStart();
  // After a break in which this process could not run, the body has stood, or was carried: a walk
  // ends, and the next one does not continue it.
  void CheckBreak();
  void StopAfterBreak();
  void EndWalk(const std::string& why);
  // No STOP can come any more, and the walk ends: without a publisher of commands for
  // kLongestAlone, or without the next heartbeat of a publisher that sends them.
  void StopIfAlone();
  Result<> Subscribe();
  transport::Subscription* SubscribeTo(const std::string& topic, View view);
  void OnLines(const std::string& topic, View view, const msg::YellowLines& lines,
               transport::EndpointId publisher);
  void Tick();
  void Publish(const LineWalker::Step& step);
  void PublishStatus();
  // After the end of a walk.
  void Conclude();
  void Log(LogLevel level, const std::string& line) const { dependencies_.log(level, line); }

  const Dependencies dependencies_;
  const WalkerConfig config_;
  RateLimitedLog warnings_;
  LineWalker walker_;
  bool permitted_ = false;
  std::string not_permitted_ = "it is not in Active";
  bool checked_ = false;
  transport::Subscription* command_ = nullptr;
  std::optional<Time> alone_since_;   // in a walk
  std::optional<Time> heartbeat_at_;  // the last of this walk
  transport::LoopBreaks breaks_;
  transport::LoopHandlePtr break_checks_;
  transport::Publisher<msg::String>* status_ = nullptr;
  transport::Publisher<msg::MotionServoCmd>* servo_ = nullptr;
  transport::LoopHandlePtr ticks_;  // during a walk
  transport::LoopHandlePtr status_timer_;
  std::unique_ptr<Lines> lines_;
  transport::Endpoints endpoints_;  // last: its callbacks use the rest
};

}  // namespace musher::line_walker
