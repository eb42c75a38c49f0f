#pragma once
// A body behind a motion board on LCM: a CyberDog 2's, its simulator, or modules/world with
// [board] kind = "lcm". The decisions are in lcm_link.hpp; here are its sockets and its timer.
//
// While no route leads to the board, or the board is silent, the sockets are opened again each
// second: those of an interface that was away are no longer in the groups, and where it has got
// another address they send from the old one. Once the board has responded they stay on their
// interfaces.
//
// Threads: the loop's only. A loop that hangs sends no frame, and the board lets the body lie down.

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "musher/modules/motion/gait_definition.hpp"
#include "musher/modules/motion/lcm_link.hpp"
#include "musher/modules/motion/motion_config.hpp"
#include "musher/transport/clock.hpp"
#include "musher/transport/lcm_socket.hpp"

namespace musher::motion {

class LcmBackend : public MotionBackend {
 public:
  // All run on the loop, never inside Send(), except on_fault.
  struct Events {
    OnBody on_body;
    std::function<void()> on_restart;                         // of the board
    std::function<void(const std::string& why)> on_held;      // LinkOutput.held_by
    std::function<void(std::int32_t, std::string)> on_fault;  // code and sentence
    // Another program has given the board a gait: that of this process is replaced.
    std::function<void(const std::string& why)> on_other_gait;
  };

  // `clock` gives the stamps of odometry; it and the loop outlive the backend.
  LcmBackend(transport::EventLoop& loop, const transport::Clock& clock, const MotionConfig& config,
             Events events);

  void Send(const BodyCommand& command) override;
  bool TakesGaits() const override { return true; }
  void DefineGait(const UserGait& gait, OnDefined then) override;
  std::string Source() const override;
  Result<> Reachable() const override { return opened_; }
  bool KnowsCommanders() const override { return loop_.Now() - opened_at_ >= kOtherSender; }

 private:
  Result<> Open();
  void Reopen();
  // Of the loop, for the link, which gets the suspensions of this computer before.
  Time Now();
  LcmLink::Sender SenderOf(const transport::LcmSample& sample);
  // A datagram that is no whole LCM message.
  void OnNoMessage(const transport::LcmSample& sample, const char* channel);
  void OnCommandGroup(const transport::LcmSample& sample);
  void OnResponseGroup(const transport::LcmSample& sample);
  void OnLocationGroup(const transport::LcmSample& sample);
  void OnGaitResult(const transport::LcmSample& sample);
  void OnOtherGait(const std::string& sender);
  void Handle(GaitDefinition::Output output);
  void Handle(const LinkOutput& output);
  void Transmit(const BodyCommand& frame);
  void Arm();

  transport::EventLoop& loop_;
  const transport::Clock& clock_;
  const Events events_;
  const LcmConfig config_;
  LcmLink link_;
  transport::HostAddresses addresses_;
  Time addresses_at_{};
  Duration suspended_;  // of this computer since its boot, as the link knows it
  Time reopened_at_{};  // or not needed
  Result<> opened_;     // the sockets, at the last try; they are kept where that has failed
  Time opened_at_{};    // those that are kept
  std::unique_ptr<transport::LcmSocket> commands_;
  std::unique_ptr<transport::LcmSocket> responses_;
  std::unique_ptr<transport::LcmSocket> locations_;
  GaitDefinition definition_;
  OnDefined on_defined_;
  std::string answers_of_;  // the sender
  NewestOnly answers_;
  transport::LoopHandlePtr answer_timer_;  // of the definition
  Time armed_for_{};
  transport::LoopHandlePtr timer_;  // these two are last: their callbacks use the rest
  transport::LoopHandlePtr reopen_timer_;
};

}  // namespace musher::motion
