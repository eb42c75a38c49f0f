// The pictures of docs/state-machines.md match those that the code draws, and its excerpts run.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "first_state_machine/greeter.hpp"
#include "musher/behavior/fsm/graph.hpp"
#include "musher/behavior/fsm/nested.hpp"
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

// [photo]
struct Photo {
  std::int64_t count = 1;
  void Persist(fsm::Archive& archive) { archive.Field("count", count); }
};

class Camera : public fsm::State {
 public:
  void Declare(fsm::Transitions& transitions) override { photo_ = transitions.On<Photo>("photo"); }
  fsm::Next CheckTransition(const fsm::Tick& tick) override {
    const Photo* photo = photo_.In(tick);
    if (photo == nullptr) return fsm::Next::Stay();
    taken += photo->count;
    return fsm::Next::Handle();
  }

  std::int64_t taken = 0;

 private:
  fsm::TypedEvent<Photo> photo_;
};
// [photo end]

TEST(Tutorial, SendsACommandWithData) {
  auto state = std::make_unique<Camera>();
  const Camera& camera = *state;
  Machine machine;
  machine.Add("CAMERA", std::move(state));
  machine.AddEvent<Photo>("photo");
  ASSERT_TRUE(machine.Build("CAMERA"));
  ASSERT_TRUE(machine.Start(Time{}));
  ASSERT_TRUE(machine.Send("photo", Photo{.count = 3}));
  machine.RunOnce(Time{});
  EXPECT_EQ(camera.taken, 3);
}

TEST(Tutorial, RunsTwoMachinesSideBySide) {
  Machine machine;
  auto arms = std::make_unique<Machine>(Machine::Options{.name = "arms"});
  auto face = std::make_unique<Machine>(Machine::Options{.name = "face"});
  arms->Add("WAVE", std::make_unique<State>());
  face->Add("SMILE", std::make_unique<State>());
  // [regions]
  std::vector<fsm::Nested::Region> regions;
  regions.push_back({std::move(arms), "WAVE"});
  regions.push_back({std::move(face), "SMILE"});
  machine.Add("SHOW", std::make_unique<fsm::Nested>(std::move(regions), fsm::Nested::Options{}));
  // [regions end]
  ASSERT_TRUE(machine.Build("SHOW"));
  ASSERT_TRUE(machine.Start(Time{}));
  EXPECT_EQ(machine.Path(), "SHOW/(WAVE|SMILE)");
}

}  // namespace musher::fsm::tutorial_test
