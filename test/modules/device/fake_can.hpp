#pragma once
// A CAN bus in virtual time: the test is its other devices.

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "musher/modules/device/can_frame.hpp"

namespace musher::device {

class FakeCan {
 public:
  // Of the robot: `Dependencies::open_can`.
  CanBus::Open Opener() {
    return [this](transport::EventLoop&, const std::string& network_interface,
                  CanBus::Events events) -> Result<std::unique_ptr<CanBus>> {
      if (!up)
        return Error{static_cast<std::int32_t>(KeyCode::kNetError), network_interface + " is down"};
      auto port = std::make_unique<Port>(*this, std::move(events));
      ports_.push_back(port.get());
      return std::unique_ptr<CanBus>(std::move(port));
    };
  }

  // The other devices send it.
  void Deliver(const CanFrame& frame) {
    for (Port* const port : std::vector(ports_)) {
      const auto& ids = port->filter;
      if (ids.empty() || std::ranges::find(ids, frame.id) != ids.end())
        port->events.on_frame(frame);
    }
  }
  void Fail(const std::string& why) {
    for (Port* const port : std::vector(ports_)) port->events.on_fault(why);
  }
  void Recover() {
    for (Port* const port : std::vector(ports_)) port->events.on_recovered();
  }
  // The interface goes down; `up` lets it be opened again.
  void GoDown() {
    up = false;
    for (Port* const port : std::vector(ports_)) port->events.on_lost("can0 is down");
  }
  // The ids of what the robot has sent since the last call.
  std::vector<std::uint32_t> TakeIds() {
    std::vector<std::uint32_t> ids;
    for (const CanFrame& frame : std::exchange(sent, {})) ids.push_back(frame.id.number);
    return ids;
  }

  bool up = true;
  bool queue_is_full = false;
  std::vector<CanFrame> sent;  // by the robot

 private:
  struct Port : CanBus {
    Port(FakeCan& its_bus, Events its_events) : bus(its_bus), events(std::move(its_events)) {}
    ~Port() override { std::erase(bus.ports_, this); }
    Result<> Send(const CanFrame& frame) override {
      if (bus.queue_is_full) {
        return Error{static_cast<std::int32_t>(KeyCode::kNetError), "can0: its queue is full"};
      }
      bus.sent.push_back(frame);
      return Ok();
    }
    void Filter(const std::vector<CanId>& ids) override { filter = ids; }

    FakeCan& bus;
    Events events;
    std::vector<CanId> filter;
  };

  std::vector<Port*> ports_;
};

}  // namespace musher::device
