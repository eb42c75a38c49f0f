#pragma once
// Answers GET /metrics of one machine: subscribes to what its controller and actuators publish, and
// reads the controller's history at each scrape, so that an answer has everything that happened.
//
// It costs nothing until the first scrape. Each scrape waits for the history, and the first one for
// the status of the controller, for kTimeout together at most; then it is answered with what is
// known, and the history is read by the next one.
//
// Threads: loop thread only, callbacks too.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "musher/lifecycle/machine/machine_identity.hpp"
#include "musher/messages/musher_msgs/machine_services.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"
#include "musher/view/metrics/robot_metrics.hpp"
#include "musher/wire/journal_cursor.hpp"

namespace musher::view {

class MetricsWatch {
 public:
  static constexpr Duration kTimeout = std::chrono::seconds(1);

  struct Options {
    std::string name_space;
    bool with_keys = false;          // the machine has [security]: each actuator has a partition
    std::int64_t began_wall_ns = 0;  // when musher-view began; earlier history does not count
    std::string host;                // HostId(); processes of other hosts can't be examined
    std::function<std::optional<ProcessUsage>(pid_t)> usage_of;  // empty: UsageOf()
    std::function<MachineIdentity()> machine;                    // that is shown; empty: any
  };
  using Respond = std::function<void(Result<std::string>)>;

  // The node must outlive it.
  MetricsWatch(transport::Node& node, Options options);

  // `respond` runs once, maybe before this returns; never if the watch is dropped first. Its text
  // is to be sent as ContentTypeOf(format). Fails if DDS refuses the subscriptions.
  void Scrape(MetricsFormat format, Respond respond);

  // For what only musher-view knows: its clients.
  RobotMetrics& metrics() { return metrics_; }

 private:
  struct WaitingScrape {
    MetricsFormat format;
    Respond respond;
  };

  Result<> Subscribe();
  void OnStatus(const msg::MachineStatus& status, transport::EndpointId writer);
  void OnWriterLost(transport::EndpointId writer);
  void ReadHistory();
  void OnHistory(const Result<msg::GetHistory::Response>& history);
  void Answer(bool complete);
  void ExamineProcesses();

  transport::Node& node_;
  const Options options_;
  RobotMetrics metrics_;
  std::optional<msg::MachineStatus> status_;
  transport::EndpointId leader_ = 0;  // the writer of that status; 0: lost
  JournalCursor cursor_;
  std::uint64_t requests_ = 0;            // for the history
  std::optional<std::uint64_t> reading_;  // the request that the scrape waits for
  Time answer_by_;
  std::vector<WaitingScrape> waiting_;
  transport::LoopHandlePtr timeout_;
  std::unique_ptr<transport::Client<msg::GetHistory>> get_history_;
  std::unique_ptr<transport::Subscription> heartbeats_;
  std::unique_ptr<transport::Subscription> statuses_;  // last: null until the first scrape
};

}  // namespace musher::view
