#pragma once
// The topics, services and clock of one module, in its machine's namespace, kept as long as this
// object. After the first that cannot be opened, which opened() explains, no other is opened, so
// that callers check only once. As the last member of a class it ends its callbacks before the
// members that they use. What it returns is valid as long as it: a timer or driver that publishes
// must not run after it.
//
// Threads: loop thread only.

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/base/network_profile.hpp"
#include "musher/transport/action.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::transport {

class Endpoints {
 public:
  // `node` must outlive it. A module that has a clock of its own leaves out `clock`.
  Endpoints(Node& node, std::string name_space, ClockSource clock = ClockSource::kSteady)
      : node_(node), name_space_(std::move(name_space)), clock_source_(clock) {}
  // Closes what was opened last first.
  ~Endpoints() {
    while (!kept_.empty()) kept_.pop_back();
  }
  Endpoints(const Endpoints&) = delete;
  Endpoints& operator=(const Endpoints&) = delete;

  Node& node() { return node_; }
  const std::string& name_space() const { return name_space_; }

  // Offers a service. The handler may reply later.
  template <msg::Service S>
  void Serve(const std::string& name, typename Server<S>::Handler handler) {
    if (opened_) KeepServer(MakeServer<S>(node_, Resolve(name), std::move(handler)));
  }
  // The same with the calling participant.
  template <msg::Service S>
  void Serve(const std::string& name, typename Server<S>::HandlerOfCaller handler) {
    if (opened_) KeepServer(MakeServer<S>(node_, Resolve(name), std::move(handler)));
  }
  // Subscribes. Returns the subscription, which knows its writers; null if it could not be opened.
  // The handler owns the sample and may move it.
  template <msg::Message M>
  Subscription* Subscribe(const std::string& name, std::function<void(M&&)> handler,
                          const Qos& qos = kDefaultQos, SubscriptionEvents events = {}) {
    return SubscribeResolved<M>(Resolve(name), std::move(handler), qos, std::move(events));
  }
  // Subscribes with the publisher of each sample, and a callback for a lost publisher.
  template <msg::Message M>
  Subscription* SubscribeEach(const std::string& name,
                              std::function<void(const M&, EndpointId publisher)> handler,
                              std::function<void(EndpointId publisher)> on_publisher_lost,
                              const Qos& qos = kDefaultQos) {
    return SubscribeWithInfo<M>(
        name,
        [handler = std::move(handler)](const M& sample, const SampleInfo& info) {
          handler(sample, info.writer);
        },
        std::move(on_publisher_lost), qos);
  }
  // The same with all that is known of each sample.
  template <msg::Message M>
  Subscription* SubscribeWithInfo(const std::string& name,
                                  std::function<void(const M&, const SampleInfo&)> handler,
                                  std::function<void(EndpointId publisher)> on_publisher_lost,
                                  const Qos& qos = kDefaultQos) {
    if (!opened_) return nullptr;
    SubscriptionEvents events;
    events.on_writer_lost = std::move(on_publisher_lost);
    return Keep(
        MakeSubscription<M>(node_, Resolve(name), std::move(handler), qos, std::move(events)));
  }
  // Subscribes to a `topic` that is already resolved.
  template <msg::Message M>
  Subscription* SubscribeResolved(const std::string& topic, std::function<void(M&&)> handler,
                                  const Qos& qos, SubscriptionEvents events = {}) {
    if (!opened_) return nullptr;
    return Keep(MakeSubscription<M>(
        node_, topic,
        [handler = std::move(handler)](M&& sample, const SampleInfo&) {
          handler(std::move(sample));
        },
        qos, std::move(events)));
  }
  // Returns a function that publishes a sample; it does nothing if the topic could not be opened.
  template <msg::Message M>
  std::function<void(const M&)> PublishFunction(const std::string& name,
                                                const Qos& qos = kDefaultQos) {
    auto* publisher = Advertise<M>(name, qos);
    if (publisher == nullptr) return [](const M&) {};
    // A failure to publish is ignored: most topics have a next sample.
    return [publisher](const M& sample) { static_cast<void>(publisher->Publish(sample)); };
  }
  // A publisher, which knows its matched readers; null if it could not be opened.
  template <msg::Message M>
  Publisher<M>* Advertise(const std::string& name, const Qos& qos = kDefaultQos,
                          WriterCallbacks callbacks = {}) {
    if (!opened_) return nullptr;
    return Keep(MakePublisher<M>(node_, Resolve(name), qos, std::move(callbacks)));
  }
  // A client of a service; null if it could not be opened.
  template <msg::Service S>
  Client<S>* OpenClient(const std::string& name, std::function<void()> on_match_changed = {}) {
    if (!opened_) return nullptr;
    return Keep(MakeClient<S>(node_, Resolve(name), std::move(on_match_changed)));
  }

  // Offers an action; goals are stamped by the clock unless `options` have another one.
  template <msg::Action A>
  void ServeAction(const std::string& name, ActionHandlers<A> handlers,
                   ActionServerOptions options = {}) {
    if (!options.stamp) options.stamp = [this] { return clock().Stamp(); };
    if (opened_) {
      Keep(MakeActionServer<A>(node_, Resolve(name), std::move(handlers), std::move(options)));
    }
  }
  // A client of an action; null if it could not be opened.
  template <msg::Action A>
  ActionClient<A>* OpenActionClient(const std::string& name, ActionClientOptions options = {}) {
    if (!opened_) return nullptr;
    return Keep(MakeActionClient<A>(node_, Resolve(name), std::move(options)));
  }

  // The clock of the machine's modules, see [controller] clock.
  Clock& clock() {
    if (clock_) return *clock_;
    auto made = Clock::Of(clock_source_, node_);
    if (!made) Refuse(made.error());
    clock_ = made ? std::move(made).value() : Clock::Steady(node_.loop());
    return *clock_;
  }
  // Runs `work` every `period` of that time.
  void Every(Duration period, std::function<void()> work) {
    kept_.push_back(clock().Every(period, std::move(work)));
  }

  // Keeps an object of the module that uses the endpoints, such as a handle of the clock; dropped
  // before the clock.
  void Keep(std::shared_ptr<void> thing) { kept_.push_back(std::move(thing)); }

  // Whether a reply of one of the services is held until its client can be reached.
  bool HoldsReplies() const {
    return std::ranges::any_of(holds_, [](const auto& holds) { return holds(); });
  }

  // The error of the first endpoint that could not be opened.
  const Result<>& opened() const { return opened_; }

 private:
  std::string Resolve(const std::string& name) const { return ResolveName(name_space_, name); }
  void Refuse(const Error& error) {
    if (opened_) opened_ = error;
  }
  template <class T>
  T* Keep(Result<std::unique_ptr<T>> made) {
    if (!made) {
      Refuse(made.error());
      return nullptr;
    }
    const std::shared_ptr<T> kept = std::move(made).value();
    kept_.push_back(kept);
    return kept.get();
  }

  template <class Server>
  void KeepServer(Result<std::unique_ptr<Server>> made) {
    const Server* server = Keep(std::move(made));
    if (server != nullptr) holds_.push_back([server] { return server->Holds(); });
  }

  Node& node_;
  const std::string name_space_;
  const ClockSource clock_source_;
  Result<> opened_;
  std::unique_ptr<Clock> clock_;
  std::vector<std::function<bool()>> holds_;  // of each service
  std::vector<std::shared_ptr<void>> kept_;   // dropped before the clock, which timers need
};

}  // namespace musher::transport
