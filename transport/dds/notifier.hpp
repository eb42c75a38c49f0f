#pragma once
// Turns Cyclone's callbacks into one visit on the loop. The callbacks run on Cyclone's threads (or
// on the loop's, inside a call of Cyclone), where nothing may be written, created or deleted; so
// they only request a visit.

#include <atomic>
#include <memory>
#include <utility>

#include "musher/transport/event_loop.hpp"

namespace musher::transport::dds {

class Notifier : public std::enable_shared_from_this<Notifier> {
 public:
  explicit Notifier(EventLoop& loop) : loop_(loop) {}
  virtual ~Notifier() = default;

  // Requests a visit unless one is under way. From any thread while the listener is set.
  void Notify() {
    if (requested_.exchange(true)) return;
    loop_.Post([weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->requested_ = false;
        self->Visit();
      }
    });
  }

 protected:
  // Handles what has happened since the last visit, on the loop.
  virtual void Visit() = 0;

  EventLoop& loop() const { return loop_; }

 private:
  EventLoop& loop_;
  std::atomic<bool> requested_ = false;
};

}  // namespace musher::transport::dds
