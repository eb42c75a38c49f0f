#pragma once
// The services and topics of CyberDog's manager, in the machine's namespace, kept as long as this.
//
// Threads: loop thread only.

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/transport/node.hpp"
#include "musher/transport/service.hpp"

namespace musher::cyberdog {

class Endpoints {
 public:
  // The node must outlive it.
  Endpoints(transport::Node& node, std::string name_space)
      : node_(node), name_space_(std::move(name_space)) {}

  transport::Node& node() { return node_; }

  template <msg::Service S>
  void Serve(const char* name, typename transport::Server<S>::Handler handler) {
    Keep(transport::MakeServer<S>(node_, Resolve(name), std::move(handler)));
  }
  template <msg::Message M>
  void Hear(const char* name, std::function<void(const M&)> handler) {
    HearResolved<M>(Resolve(name), std::move(handler), transport::kDefaultQos);
  }
  // `topic` with its namespace.
  template <msg::Message M>
  void HearResolved(const std::string& topic, std::function<void(const M&)> handler,
                    const transport::Qos& qos) {
    Keep(transport::MakeSubscription<M>(
        node_, topic,
        [handler = std::move(handler)](const M& sample, const transport::SampleInfo&) {
          handler(sample);
        },
        qos));
  }
  // Says one sample; does nothing when the topic could not be opened.
  template <msg::Message M>
  std::function<void(const M&)> Tell(const char* name) {
    auto made = transport::MakePublisher<M>(node_, Resolve(name));
    if (!made) {
      opened_ = made.error();
      return [](const M&) {};
    }
    // What cannot be sent is followed by the next.
    return [publisher = std::shared_ptr(std::move(made).value())](const M& sample) {
      static_cast<void>(publisher->Publish(sample));
    };
  }

  // To call somebody else's service; null when it could not be opened.
  template <msg::Service S>
  transport::Client<S>* Ask(const char* name, std::function<void()> on_match_changed = {}) {
    return Keep(transport::MakeClient<S>(node_, Resolve(name), std::move(on_match_changed)));
  }

  // Why one of them could not be opened.
  const Result<>& opened() const { return opened_; }

 private:
  std::string Resolve(const std::string& name) const {
    return transport::ResolveName(name_space_, name);
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

  transport::Node& node_;
  const std::string name_space_;
  Result<> opened_;
  std::vector<std::shared_ptr<void>> kept_;
};

}  // namespace musher::cyberdog
