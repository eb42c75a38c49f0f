// What the applications of examples/ do by themselves in Active, after each start of their process.

#include "first_application/door.hpp"
#include "first_skill/kitchen.hpp"
#include "first_tree/gardener.hpp"
#include "musher/application/load_tree.hpp"
#include "musher/test/application/show.hpp"
#include "musher/test/support/paths.hpp"
#include "new_app/new_app.hpp"

namespace musher::examples_test {

template <class Application>
class Peeked : public Application, public testing::Inspected<Peeked<Application>> {
 public:
  using Application::Now;
};

template <class Application>
class Machine : public Peeked<Application> {
 public:
  using Application::machine;
  std::string Path() {
    return this->Of([this](auto&) { return machine().Path(); });
  }
};

class PeekedKitchen : public Peeked<Kitchen> {
 public:
  bool Runs() {
    return Of([this](auto&) { return manager().running(); });
  }
};

class PeekedGardener : public Peeked<Gardener> {
 public:
  tree::Status Status() {
    return Of([this](auto&) { return result(); });
  }

 private:
  Result<tree::Document> LoadTree() override {
    return ReadTreeDocument(SourceDir() + "/examples/first_tree/garden.xml",
                            [](const std::string&) {});
  }
};

// A second in Active, with no command.
template <class Application>
void StandInActive(testing::Harness& harness, Application& application) {
  harness.Open(application);
  ASSERT_TRUE(harness.controller().Switch("SelfCheck").done());
  ASSERT_TRUE(harness.controller().Switch("Active").done());
  harness.Tick(application, 50);
}

TEST(AnExample, TheDoorStandsClosedUntilItIsCommanded) {
  testing::Harness harness("topic", "door");
  ActuatorRunner<Machine<Door>> door;
  ASSERT_NO_FATAL_FAILURE(StandInActive(harness, door));
  EXPECT_EQ(door.Path(), "CLOSED");
}
TEST(AnExample, TheTemplateOfAnApplicationIsIdleUntilItIsCommanded) {
  testing::Harness harness("topic", "new_app");
  ActuatorRunner<Machine<NewApp>> application;
  ASSERT_NO_FATAL_FAILURE(StandInActive(harness, application));
  EXPECT_EQ(application.Path(), "IDLE");
}
TEST(AnExample, TheKitchenHeatsNothingWithoutAGoal) {
  testing::Harness harness("topic", "kitchen");
  ActuatorRunner<PeekedKitchen> kitchen;
  ASSERT_NO_FATAL_FAILURE(StandInActive(harness, kitchen));
  EXPECT_FALSE(kitchen.Runs());
}
TEST(AnExample, TheGardenerBeginsByItselfByItsOption) {
  testing::Harness harness("topic", "gardener");
  ActuatorRunner<PeekedGardener> gardener;
  ASSERT_NO_FATAL_FAILURE(StandInActive(harness, gardener));
  EXPECT_EQ(gardener.Status(), tree::Status::kRunning) << "a garden does not move";
}

}  // namespace musher::examples_test
