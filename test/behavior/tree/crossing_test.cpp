// A tree in the form of the first examples of BehaviorTree.CPP 4, from its text to its end: a door
// that may be closed, two subtrees, remapped keys, scripts and conditions.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::crossing_test {

constexpr const char* kXml = R"(<?xml version="1.0"?>
<root BTCPP_format="4" main_tree_to_execute="Cross">
  <!-- the robot crosses a room -->
  <BehaviorTree ID="Cross">
    <Sequence>
      <Script code=" tries := 0; goal := 'kitchen' " />
      <Fallback name="door">
        <Inverter>
          <IsDoorClosed/>
        </Inverter>
        <SubTree ID="OpenDoor" door_name="{goal}" attempts="{tries}" most="3"/>
      </Fallback>
      <Walk to="{goal}" distance="{walked}" _onSuccess="done := walked >= 2.5"/>
    </Sequence>
  </BehaviorTree>
  <BehaviorTree ID="OpenDoor">
    <Fallback>
      <Open/>
      <RetryUntilSuccessful num_attempts="{most}">
        <Sequence _post="attempts += 1">
          <Pick name="pick" of="{door_name}"/>
          <Open/>
        </Sequence>
      </RetryUntilSuccessful>
      <AlwaysFailure _skipIf="attempts > 2"/>
    </Fallback>
  </BehaviorTree>
</root>
)";

struct Room {
  bool closed = true;
  int picks = 0;
  std::vector<std::string> picked;
};

class Pick : public StatefulAction {
 public:
  Pick(Setup& setup, Room& room) : of_(setup.Input<std::string>("of")), room_(room) {}
  Status OnStart(const Tick&) override { return Status::kRunning; }
  Status OnRunning(const Tick&) override {
    room_.picked.push_back(of_.Get());
    if (++room_.picks < 3) return Status::kFailure;
    room_.closed = false;
    return Status::kSuccess;
  }

 private:
  InPort<std::string> of_;
  Room& room_;
};

class Walk : public StatefulAction {
 public:
  explicit Walk(Setup& setup)
      : to_(setup.Input<std::string>("to")), distance_m_(setup.Output<double>("distance")) {}
  Status OnStart(const Tick& tick) override {
    since_ = tick.now;
    return Status::kRunning;
  }
  Status OnRunning(const Tick& tick) override {
    distance_m_.Set(ToSeconds(tick.now - since_));
    return tick.now - since_ >= std::chrono::seconds(3) ? Status::kSuccess : Status::kRunning;
  }

 private:
  InPort<std::string> to_;
  OutPort<double> distance_m_;
  Time since_{};
};

TEST(Crossing, OpensTheDoorAndWalksToTheEnd) {
  Room room;
  Factory factory;
  ASSERT_TRUE(factory.AddCondition("IsDoorClosed", [&room](const Tick&) {
    return room.closed ? Status::kSuccess : Status::kFailure;
  }));
  ASSERT_TRUE(factory.AddAction(
      "Open", [&room](const Tick&) { return room.closed ? Status::kFailure : Status::kSuccess; }));
  ASSERT_TRUE(factory.Add<Pick>("Pick", room));
  ASSERT_TRUE(factory.Add<Walk>("Walk"));
  const auto tree = MakeTree(kXml, factory);
  ASSERT_NE(tree, nullptr);

  std::string letters;
  for (int i = 0; i < 60 && (letters.empty() || letters.back() == 'R'); ++i) {
    letters += Letter(tree->TickOnce(At(500 * i)));
  }
  EXPECT_EQ(letters.back(), 'S') << letters << tree->HistoryText();
  EXPECT_THAT(room.picked, testing::ElementsAre("kitchen", "kitchen", "kitchen"));
  EXPECT_EQ(tree->board().Get<double>("tries").value(), 3);
  EXPECT_TRUE(tree->board().Get<bool>("done").value());
  EXPECT_THAT(tree->HistoryText(),
              testing::HasSubstr("Cross/Sequence/door/OpenDoor/Fallback/RetryUntilSuccessful/"
                                 "Sequence/pick: IDLE -> RUNNING"));
}

TEST(Crossing, NamesTheNodesThatAreNotRegistered) {
  EXPECT_THAT(Findings(kXml), testing::HasSubstr("there is no node 'IsDoorClosed'"));
}

}  // namespace musher::tree::crossing_test
