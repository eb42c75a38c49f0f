#pragma once
// The topics and services of one module, in its machine's namespace, kept as long as this, and the
// time it goes by. What cannot be opened is found in opened(), so that a list of them reads as one.
//
// Threads: loop thread only.

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/lifecycle/config.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

class Endpoints {
 public:
  // Both must outlive it.
  Endpoints(Node& node, const MachineConfig& config) : node_(node), config_(config) {}

  Node& node() { return node_; }

  // Answers a service. The reply may be given later, when what was asked for has come about.
  template <msg::Service S>
  void Serve(const std::string& name, typename Server<S>::Handler handler) {
    Keep(MakeServer<S>(node_, Resolve(name), std::move(handler)));
  }
  // Gives the subscription, which tells who speaks; null when it could not be opened.
  template <msg::Message M>
  Subscription* Hear(const std::string& name, std::function<void(const M&)> handler,
                     const Qos& qos = kDefaultQos) {
    return HearResolved<M>(Resolve(name), std::move(handler), qos);
  }
  // The same, where it matters which publisher said what, and that one has gone.
  template <msg::Message M>
  Subscription* HearEach(const std::string& name,
                         std::function<void(const M&, PeerId publisher)> handler,
                         std::function<void(PeerId publisher)> on_publisher_lost,
                         const Qos& qos = kDefaultQos) {
    SubscriptionEvents events;
    events.on_writer_lost = std::move(on_publisher_lost);
    return Keep(MakeSubscription<M>(
        node_, Resolve(name),
        [handler = std::move(handler)](const M& sample, const SampleInfo& info) {
          handler(sample, info.writer);
        },
        qos, std::move(events)));
  }
  // `topic` with its namespace.
  template <msg::Message M>
  Subscription* HearResolved(const std::string& topic, std::function<void(const M&)> handler,
                             const Qos& qos) {
    return Keep(MakeSubscription<M>(
        node_, topic,
        [handler = std::move(handler)](const M& sample, const SampleInfo&) { handler(sample); },
        qos));
  }
  // Gives what publishes one sample; it does nothing when the topic could not be opened.
  template <msg::Message M>
  std::function<void(const M&)> Tell(const std::string& name, const Qos& qos = kDefaultQos) {
    auto* publisher = Advertise<M>(name, qos);
    if (publisher == nullptr) return [](const M&) {};
    // What cannot be sent is followed by the next.
    return [publisher](const M& sample) { static_cast<void>(publisher->Publish(sample)); };
  }
  // A publisher, which also tells who listens; null when it could not be opened.
  template <msg::Message M>
  Publisher<M>* Advertise(const std::string& name, const Qos& qos = kDefaultQos) {
    return Keep(MakePublisher<M>(node_, Resolve(name), qos));
  }
  // To call somebody else's service; null when it could not be opened.
  template <msg::Service S>
  Client<S>* Ask(const std::string& name, std::function<void()> on_match_changed = {}) {
    return Keep(MakeClient<S>(node_, Resolve(name), std::move(on_match_changed)));
  }

  // The time that the machine's modules go by, see [controller] clock.
  Clock& clock() {
    if (clock_) return *clock_;
    auto made = Clock::Of(config_, node_);
    if (!made) opened_ = made.error();
    clock_ = made ? std::move(made).value() : Clock::Steady(node_.loop());
    return *clock_;
  }
  // Runs `work` every `period` of that time.
  void Every(Duration period, std::function<void()> work) {
    kept_.push_back(clock().Every(period, std::move(work)));
  }

  // Something of the module's own that stands on them, a handle of the clock's, say: gone before
  // the clock is.
  void Keep(std::shared_ptr<void> thing) { kept_.push_back(std::move(thing)); }

  // Why one of them could not be opened.
  const Result<>& opened() const { return opened_; }

 private:
  std::string Resolve(const std::string& name) const {
    return ResolveName(config_.name_space, name);
  }
  template <class T>
  T* Keep(Result<std::unique_ptr<T>> made) {
    if (!made) {
      opened_ = made.error();
      return nullptr;
    }
    const std::shared_ptr<T> kept = std::move(made).value();
    kept_.push_back(kept);
    return kept.get();
  }

  Node& node_;
  const MachineConfig& config_;
  Result<> opened_;
  std::unique_ptr<Clock> clock_;
  std::vector<std::shared_ptr<void>> kept_;  // gone before the clock, which timers need
};

}  // namespace musher::transport
