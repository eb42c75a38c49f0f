#pragma once
// Sends goals to the action `fibonacci`, and reports what becomes of them.

#include <chrono>
#include <functional>
#include <string>
#include <utility>

#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/transport/endpoints.hpp"

namespace transport = musher::transport;
using musher::msg::Fibonacci;

class FibonacciClient {
 public:
  explicit FibonacciClient(std::function<void(const std::string& line)> report)
      : report_(std::move(report)) {}

  void Open(transport::Endpoints& topics) {
    client_ = topics.OpenActionClient<Fibonacci>("fibonacci");
  }
  void Send(int order, std::function<void(bool succeeded)> ended) {
    transport::GoalEvents<Fibonacci> events;
    events.on_feedback = [this](const Fibonacci::Feedback& feedback) {
      report_("up to " + std::to_string(feedback.sequence.back()));
    };
    events.on_end = [this,
                     ended = std::move(ended)](const transport::GoalOutcome<Fibonacci>& outcome) {
      const std::string why = outcome.reason.empty() ? "" : ": " + outcome.reason;
      report_(std::string(GoalEndName(outcome.end)) + why);
      ended(outcome.end == transport::GoalEnd::kSucceeded);
    };
    goal_ = client_->SendGoal({order}, std::chrono::seconds(2), std::move(events));
  }
  void Cancel() {
    client_->Cancel(goal_, std::chrono::seconds(2), [this](const auto& reply) {
      const bool accepted =
          reply && reply.value().return_code == musher::msg::CancelGoal::kErrorNone;
      if (!accepted) report_("it cannot be cancelled");
    });
  }

 private:
  std::function<void(const std::string&)> report_;
  transport::ActionClient<Fibonacci>* client_ = nullptr;
  transport::GoalId goal_{};
};
