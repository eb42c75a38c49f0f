#pragma once
// The board as an actuator of the robot: its two topics, and what the robot's states mean for it.
//
// Threads: state callbacks run on the actuator's worker, everything else on the loop.

#include <functional>

#include "board.hpp"
#include "musher/actuator/machine_actuator.hpp"
#include "musher/messages/stamp.hpp"
#include "musher/transport/endpoints.hpp"

class LegBoard : public musher::MachineActuator {
 public:
  LegBoard() : MachineActuator("leg_board") {
    RegisterStateCallback("SetUp", [this] { return SetUp(); });
    // The motion manager lays the body down where a state needs it: nothing is left to do here.
    RegisterStateCallback([](const musher::State&) { return musher::Ok(); });
  }

  const Board& board() const { return board_; }  // for tests

 protected:
  void OnEmergencyStop() override { board_.Stop(); }

 private:
  musher::Result<> SetUp() {
    return OpenEndpoints([this](musher::transport::Endpoints& wire) {
      clock_ = &wire.clock();
      publish_ = wire.PublishFunction<musher::msg::BodyState>("world/body_state");
      wire.Subscribe<Board::Command>("world/body_command", [this](const Board::Command& command) {
        if (!HeldByStop() || command.mode == 0) board_.Take(command, clock_->Now());
      });
      wire.Every(musher::Milliseconds(20), [this] { Report(); });
    });
  }

  void Report() {
    musher::msg::BodyState state = board_.Report(clock_->Now());
    state.header.stamp = clock_->Stamp();
    publish_(state);
  }

  Board board_;
  std::function<void(const musher::msg::BodyState&)> publish_;
  musher::transport::Clock* clock_ = nullptr;  // from SetUp on
};
