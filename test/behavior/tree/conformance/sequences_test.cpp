// Order of the children of sequences, as BehaviorTree.CPP 4.10 documents it.
// "a^" is a's first tick, "a" a further one, "a!" its halt.

#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::conformance_sequences_test {

using SequencesAsDocumented = TickedTree;

TEST_F(SequencesAsDocumented, SequenceWithMemoryGivesTheTreeATurnBetweenItsChildren) {
  const std::string steps = "<SequenceWithMemory>" + Leaf("a", "S") + Leaf("b", "S") +
                            Leaf("c", "S") + "</SequenceWithMemory>";
  EXPECT_EQ(Run(steps, 3), "RRS a^ b^ c^ ");
  const std::string guarded =
      "<ReactiveSequence>" + Leaf("cond", "S") + steps + "</ReactiveSequence>";
  EXPECT_EQ(Run(guarded, 3), "RRS cond^ a^ cond^ b^ cond^ c^ ");
  tree = MakeTree(Main(guarded), factory);
  EXPECT_EQ(Letter(tree->TickOnce(At(0))), 'S');
  EXPECT_EQ(Take(), "cond^ a^ cond^ b^ cond^ c^ ");
}
TEST_F(SequencesAsDocumented, AChildThatWasRunningNeedsNoTurnBeforeTheNextOne) {
  EXPECT_EQ(Run("<SequenceWithMemory>" + Leaf("a", "RS") + Leaf("b", "S") + Leaf("c", "S") +
                    "</SequenceWithMemory>",
                3),
            "RRS a^ a b^ c^ ");
}
TEST_F(SequencesAsDocumented, AConditionIsEvaluatedBetweenTheChildrenOfASequenceWithMemory) {
  tree = MakeTree(
      Main("<SequenceWithMemory _while=\"ok\">" + Leaf("a", "S", "_onSuccess=\"ok = false\"") +
           Leaf("b", "S") + "</SequenceWithMemory>"),
      factory);
  ASSERT_TRUE(tree->board().Set("ok", true));
  EXPECT_EQ(Letter(tree->TickOnce(At(0))), '-');
  EXPECT_EQ(Take(), "a^ ");
}
TEST_F(SequencesAsDocumented, SequenceWithMemoryStopsAtAConditionThatFails) {
  EXPECT_EQ(Run("<ReactiveSequence>" + Leaf("cond", "SF") + "<SequenceWithMemory>" +
                    Leaf("a", "S") + Leaf("b", "S") + "</SequenceWithMemory></ReactiveSequence>",
                2),
            "RF cond^ a^ cond^ ");
}
TEST_F(SequencesAsDocumented, ASequenceTicksItsChildrenInOneTick) {
  EXPECT_EQ(Run("<Sequence>" + Leaf("a", "S") + Leaf("b", "S") + "</Sequence>", 1), "S a^ b^ ");
}

}  // namespace musher::tree::conformance_sequences_test
