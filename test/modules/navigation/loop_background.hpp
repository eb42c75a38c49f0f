#pragma once
// A Background in virtual time: each work ends `takes` after it was given, on the loop.

#include <deque>
#include <memory>
#include <utility>

#include "musher/modules/navigation/server/background.hpp"
#include "musher/transport/event_loop.hpp"

namespace musher::navigation::testing {

class LoopBackground : public Background {
 public:
  LoopBackground(transport::EventLoop& loop, Duration takes) : loop_(loop), takes_(takes) {}

  void Do(std::function<std::function<void()>()> work) override {
    handles_.push_back(loop_.At(loop_.Now() + takes_, [work = std::move(work)] {
      if (const auto then = work()) then();
    }));
  }

 private:
  transport::EventLoop& loop_;
  const Duration takes_;
  std::deque<transport::LoopHandlePtr> handles_;
};

}  // namespace musher::navigation::testing
