#include "musher/test/protocols/cyberdog_module.hpp"

#include <algorithm>
#include <utility>

namespace musher::testing {

CyberdogModule::CyberdogModule(transport::Node& node, std::string name_space, std::string name,
                               std::string heartbeats_as, Duration set_up_takes)
    : node_(node),
      name_space_(std::move(name_space)),
      name_(std::move(name)),
      heartbeats_as_(std::move(heartbeats_as)) {
  end_ = node.loop().At(node.loop().Now() + set_up_takes, [this] { Open(); });
  if (heartbeats_as_.empty()) return;
  heartbeats_ = transport::MakePublisher<msg::Heartbeats>(
                    node, transport::ResolveName(name_space_, "manager_heartbeats"),
                    transport::kSystemDefaultQos)
                    .value();
  heartbeat_ = node.loop().Every(Milliseconds(500), [this] { Heartbeat(); });
}

void CyberdogModule::Open() {
  server_ = transport::MakeServer<msg::FsMachine>(
                node_, transport::ResolveName(name_space_, name_ + "machine_service"),
                [this](const msg::FsMachine::Request& request, Reply reply) {
                  queue_.emplace_back(request.target_state, std::move(reply));
                  Next();
                })
                .value();
}

void CyberdogModule::Next() {
  if (busy_ || queue_.empty()) return;
  const auto [state, reply] = std::move(queue_.front());
  queue_.pop_front();
  Run(state, reply);
}

void CyberdogModule::Run(const std::string& state, const Reply& reply) {
  if (std::find(unknown_states.begin(), unknown_states.end(), state) != unknown_states.end()) {
    return reply({0, 8});
  }
  log_.push_back(state);
  if (on_callback) on_callback(state);
  const Callback callback = script[state];
  busy_ = true;
  end_ = node_.loop().At(node_.loop().Now() + callback.takes, [this, reply, code = callback.code] {
    busy_ = false;
    if (lost_replies-- <= 0) reply({0, code});
    Next();
  });
}

void CyberdogModule::Heartbeat() {
  if (!sends_heartbeats || (busy_ && !heartbeats_while_busy)) return;
  msg::Heartbeats heartbeat;
  heartbeat.name = heartbeats_as_;
  static_cast<void>(heartbeats_->Publish(heartbeat));
}

}  // namespace musher::testing
