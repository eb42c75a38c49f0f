// A tick does not allocate, unless there is a fault.

#include "musher/test/behavior/fsm/counting_new.hpp"
#include "musher/test/behavior/tree/trees.hpp"

namespace musher::tree::allocation_test {

class Copy : public Action {
 public:
  explicit Copy(Setup& setup)
      : from_(setup.Input<std::string>("from")), to_(setup.Output<std::string>("to")) {}
  Status Do(const Tick&) override {
    to_.Set(from_.Get());
    return Status::kSuccess;
  }

 private:
  InPort<std::string> from_;
  OutPort<std::string> to_;
};

constexpr const char* kXml = R"(<root BTCPP_format="4" main_tree_to_execute="Main">
<BehaviorTree ID="Main">
  <Sequence>
    <Copy from="a text that is too long to lie inside of a string" to="{text}"/>
    <Script code="n := n + 1; word := n > 5 ? 'few' : 'many'; both := text + word"/>
    <Parallel success_count="1" failure_count="2">
      <Sleep msec="30" _onSuccess="slept := true"/>
      <Timeout msec="20"><Sleep msec="100" _onHalted="halted := n"/></Timeout>
    </Parallel>
    <SubTree ID="Sub" in="{n}" most="3" _skipIf="n % 2 == 1"/>
    <RetryUntilSuccessful num_attempts="3"><ForceFailure><AlwaysSuccess/></ForceFailure>
    </RetryUntilSuccessful>
  </Sequence>
</BehaviorTree>
<BehaviorTree ID="Sub">
  <ReactiveFallback>
    <ScriptCondition code="in &lt; most"/>
    <LoopDouble queue="1;2;3" value="{x}"><Inverter><AlwaysFailure/></Inverter></LoopDouble>
    <Switch2 variable="{in}" case_1="1" case_2="two">
      <AlwaysSuccess/><AlwaysSuccess/><AlwaysSuccess/>
    </Switch2>
  </ReactiveFallback>
</BehaviorTree>
</root>)";

TEST(Tick, TakesNoMemory) {
  Factory factory;
  ASSERT_TRUE(factory.Add<Copy>("Copy"));
  std::string xml = kXml;
  xml.replace(xml.find("n % 2 == 1"), 10, "n &lt; 0");
  const auto tree = MakeTree(xml, factory);
  ASSERT_TRUE(tree->board().Set("n", 0.0));
  const auto run = [&tree](int from, int to) {
    int failures = 0;
    for (int i = from; i < to; ++i) {
      const Result<Status> result = tree->TickOnce(At(10 * i));
      if (!result || result.value() == Status::kFailure) ++failures;
      EXPECT_TRUE(result) << result.error().message;
    }
    return failures;
  };
  run(0, 200);  // texts and lists have got their room
  const std::size_t before = testing::AllocationsOfNew().times;
  const int failures = run(200, 5000);
  EXPECT_EQ(testing::AllocationsOfNew().times - before, 0U);
  EXPECT_GT(failures, 100);
}

// The counter counts.
TEST(Build, TakesMemory) {
  const std::size_t before = testing::AllocationsOfNew().times;
  const auto tree = MakeTree(Main("<AlwaysSuccess/>"));
  EXPECT_GT(testing::AllocationsOfNew().times, before + 5);
}

}  // namespace musher::tree::allocation_test
