#pragma once
// Serves the action `fibonacci`: one more number of the sequence every 100 ms.

#include <chrono>
#include <cstdint>
#include <list>
#include <utility>
#include <vector>

#include "musher/messages/example_interfaces/fibonacci.hpp"
#include "musher/transport/endpoints.hpp"

namespace transport = musher::transport;
using musher::msg::Fibonacci;

class FibonacciServer {
 public:
  void Open(transport::Endpoints& topics) {
    transport::ActionHandlers<Fibonacci> handlers;
    handlers.accept = [](const Fibonacci::Goal& goal, transport::ParticipantId) {
      return goal.order >= 1 && goal.order <= 46;  // the next number exceeds 32 bits
    };
    handlers.start = [this](Goal goal) {
      goal.Execute();
      jobs_.push_back({goal, {0, 1}});
    };
    handlers.cancel = [this](Goal goal) {
      std::erase_if(jobs_, [&goal](const Job& job) { return job.goal.id() == goal.id(); });
      goal.Canceled({});
    };
    topics.ServeAction<Fibonacci>("fibonacci", std::move(handlers));
    topics.Every(std::chrono::milliseconds(100), [this] { Step(); });
  }

 private:
  using Goal = transport::ServerGoal<Fibonacci>;
  struct Job {
    Goal goal;
    std::vector<std::int32_t> sequence;
  };

  void Step() {
    for (auto job = jobs_.begin(); job != jobs_.end();) {
      auto& sequence = job->sequence;
      const bool done = static_cast<int>(sequence.size()) > job->goal.goal().order;
      if (done) {
        job->goal.Succeed({sequence});
        job = jobs_.erase(job);
      } else {
        sequence.push_back(sequence[sequence.size() - 2] + sequence.back());
        job->goal.PublishFeedback({sequence});
        ++job;
      }
    }
  }

  std::list<Job> jobs_;
};
