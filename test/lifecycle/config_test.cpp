#include "musher/lifecycle/config/config.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace musher::config_test {

MachineConfig TwoActuators() {
  MachineConfig config;
  config.states = {"SetUp", "Active", "Parked"};
  config.default_time = Milliseconds(250);
  config.ranks = {{"Active", 6}, {"Parked", 3}};
  ActuatorConfig wheels;
  wheels.name = "wheels";
  wheels.states = {"SetUp", "Active"};
  wheels.times = {Milliseconds(900), Milliseconds(40)};
  ActuatorConfig voice;
  voice.name = "voice";
  voice.states = {"SetUp"};
  voice.times = {Milliseconds(10)};
  config.actuators = {wheels, voice};
  return config;
}

bool Has(const std::vector<FlowEdge>& flow, const FlowEdge& edge) {
  return std::find(flow.begin(), flow.end(), edge) != flow.end();
}

TEST(ActuatorConfig, HasTheStatesThatItListsWithTheirTimes) {
  const ActuatorConfig wheels = TwoActuators().actuators[0];
  EXPECT_TRUE(wheels.Lists("Active"));
  EXPECT_FALSE(wheels.Lists("Parked"));
  EXPECT_EQ(wheels.TimeFor("Active"), Milliseconds(40));
  EXPECT_EQ(wheels.TimeFor("Parked"), std::nullopt);
}

TEST(MachineConfig, FindsActuatorsByName) {
  const MachineConfig config = TwoActuators();
  EXPECT_EQ(config.IndexOf("voice"), ActuatorIndex(1));
  EXPECT_EQ(config.IndexOf("voices"), std::nullopt);
}

TEST(MachineConfig, GivesTheDefaultTimeWhereAnActuatorHasNone) {
  const MachineConfig config = TwoActuators();
  EXPECT_EQ(config.TimeFor(0, "SetUp"), Milliseconds(900));
  EXPECT_EQ(config.TimeFor(1, "Active"), Milliseconds(250));
}

TEST(MachineConfig, HasItsStatesWithTheirRanks) {
  const MachineConfig config = TwoActuators();
  EXPECT_TRUE(config.HasState("Parked"));
  EXPECT_FALSE(config.HasState("OTA"));
  EXPECT_EQ(config.RankOf("Parked"), 3);
  EXPECT_EQ(config.RankOf("SetUp"), std::nullopt);
}

TEST(DefaultFlow, GoesBetweenAnyTwoStatesOfTheRunPhase) {
  const auto flow = DefaultFlow({"Active", "Protected", "DeActive", "LowPower", "OTA"});
  EXPECT_EQ(flow.size(), 20U);
  EXPECT_TRUE(Has(flow, {"OTA", "Active"}));
  EXPECT_FALSE(Has(flow, {"Active", "Active"}));
}

TEST(DefaultFlow, LeavesErrorThroughSelfCheckOnly) {
  const auto flow = DefaultFlow({"SelfCheck", "Active", "DeActive", "Error", "TearDown"});
  EXPECT_TRUE(Has(flow, {"Active", "Error"}));
  EXPECT_TRUE(Has(flow, {"Error", "SelfCheck"}));
  EXPECT_TRUE(Has(flow, {"SelfCheck", "DeActive"}));
  EXPECT_TRUE(Has(flow, {"Error", "TearDown"}));
  EXPECT_FALSE(Has(flow, {"Error", "Active"}));
}

TEST(DefaultFlow, HasNoWayOutOfTearDown) {
  const auto flow = DefaultFlow({"SetUp", "SelfCheck", "Active", "Error", "TearDown"});
  EXPECT_TRUE(std::none_of(flow.begin(), flow.end(),
                           [](const FlowEdge& edge) { return edge.from == kTearDown; }));
}

TEST(DefaultFlow, TakesOwnStatesForStatesOfTheRunPhase) {
  const auto flow = DefaultFlow({"Active", "Parked"});
  EXPECT_EQ(flow, (std::vector<FlowEdge>{{"Active", "Parked"}, {"Parked", "Active"}}));
}

// One config on each computer that may lead.
TEST(Config, OfAComputerHasTheActuatorsOfItsOwnAddressAsTheControllersOwn) {
  MachineConfig config = TwoActuators();
  HostConfig brain;
  brain.name = "brain";
  brain.address = "10.0.0.1";
  HostConfig motion;
  motion.name = "motion";
  motion.address = "motion.local";
  config.hosts = {brain, motion};
  config.actuators[*config.IndexOf("voice")].host = "brain";
  config.actuators[*config.IndexOf("wheels")].host = "motion";
  TakeOwnHosts(config, {"192.168.1.7", "motion.local"});
  EXPECT_EQ(config.actuators[*config.IndexOf("voice")].host, "brain");
  EXPECT_EQ(config.actuators[*config.IndexOf("wheels")].host, "");
  EXPECT_EQ(config.actuators[*config.IndexOf("wheels")].cwd, "/") << "as where its host starts it";
  EXPECT_EQ(config.hosts, std::vector<HostConfig>{brain});
}

}  // namespace musher::config_test
