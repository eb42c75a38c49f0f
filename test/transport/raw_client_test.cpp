// A request that was made long ago is not sent any more, whatever kept its client from sending it.

#include "musher/transport/raw_client.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "musher/messages/std_srvs/trigger.hpp"
#include "musher/test/transport/suspended_node.hpp"
#include "musher/transport/service.hpp"
#include "musher/transport/sim/network.hpp"

namespace musher::transport::raw_client_test {

using std::chrono::seconds;

// A call of 20 s on a laptop, whose robot is switched on later.
class LateRequest : public ::testing::Test {
 protected:
  void Call() {
    client_ = MakeClient<msg::Trigger>(laptop_, "walk").value();
    client_->Call({}, seconds(20), [this](Result<msg::Trigger::Response> reply) {
      ended_.emplace(std::move(reply));
    });
    network_.RunFor(seconds(1));
  }
  void SwitchRobotOn() {
    server_ = MakeServer<msg::Trigger>(*robot_, "walk",
                                       [this](const msg::Trigger::Request&, const auto& reply) {
                                         ++served_;
                                         reply({});
                                       })
                  .value();
  }
  void ExpectNotSent() {
    network_.RunFor(seconds(2));
    EXPECT_EQ(served_, 0);
    ASSERT_TRUE(ended_);
    ASSERT_FALSE(ended_->ok());
    EXPECT_EQ(ended_->error().code, kCodeTimeout);
    EXPECT_EQ(ended_->error().message, "walk: no server available in time");
  }

  sim::Network network_{1};
  testing::SuspendedNode laptop_{network_.MakeNode("laptop")};
  std::unique_ptr<Node> robot_ = network_.MakeNode("robot");
  std::unique_ptr<Client<msg::Trigger>> client_;
  std::unique_ptr<Server<msg::Trigger>> server_;
  std::optional<Result<msg::Trigger::Response>> ended_;
  int served_ = 0;
};

TEST_F(LateRequest, IsSentWithinItsTime) {
  Call();
  SwitchRobotOn();
  network_.RunFor(seconds(2));
  EXPECT_EQ(served_, 1);
  ASSERT_TRUE(ended_);
  EXPECT_TRUE(ended_->ok());
}

TEST_F(LateRequest, IsNotSentOnceItsComputerWasSuspendedForItsTime) {
  Call();
  laptop_.loop().suspended = seconds(25);
  SwitchRobotOn();
  ExpectNotSent();
}

TEST_F(LateRequest, IsNotSentOnceItsProcessWasStoppedForItsTime) {
  Call();
  network_.Pause(laptop_.simulated());
  SwitchRobotOn();
  network_.RunFor(seconds(25));
  network_.Resume(laptop_.simulated());
  ExpectNotSent();
}

}  // namespace musher::transport::raw_client_test
