// The pictures of docs/state-machines.md match those that the code draws.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "first_state_machine/greeter.hpp"
#include "musher/behavior/fsm/graph.hpp"
#include "musher/test/support/paths.hpp"

namespace musher::fsm::tutorial_test {

TEST(Tutorial, ShowsTheMachineAsItIsDrawn) {
  std::ifstream file(SourceDir() + "/docs/state-machines.md", std::ios::binary);
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  Robot robot;
  const auto machine = MakeGreeter(robot);
  ASSERT_TRUE(machine->Build("IDLE"));
  EXPECT_THAT(machine->warnings(), ::testing::IsEmpty());
  EXPECT_THAT(page, ::testing::HasSubstr("```mermaid\n" + ToMermaid(machine->chart()) + "```\n"));
}

}  // namespace musher::fsm::tutorial_test
