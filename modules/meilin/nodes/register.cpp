#include "musher/modules/meilin/nodes/register.hpp"

#include <initializer_list>

#include "musher/modules/meilin/nodes/action_nodes.hpp"
#include "musher/modules/meilin/nodes/fetch.hpp"
#include "musher/modules/meilin/nodes/get_off_edge.hpp"
#include "musher/modules/meilin/nodes/move.hpp"
#include "musher/modules/meilin/nodes/segment_nodes.hpp"
#include "musher/modules/meilin/nodes/wait_nodes.hpp"

namespace musher::meilin {

Result<> RegisterNodes(tree::Factory& factory, Robot& robot, const Settings& settings) {
  const std::initializer_list<Result<>> added = {
      factory.Add<Move>("Move", robot, settings),
      factory.Add<Fetch>("Fetch", robot, settings),
      factory.Add<GetOffEdge>("GetOffEdge", robot, settings),
      factory.Add<Align>("Align", robot, settings),
      factory.Add<MoveToPose>("MoveToPose", robot, settings),
      factory.Add<SuspensionControl>("SuspensionControl", robot),
      factory.Add<ArmAction>("ArmAction", robot),
      factory.Add<SpearAction>("SpearAction", robot),
      factory.Add<PopNextMeilinSegment>("PopNextMeilinSegment"),
      factory.Add<PopNextSegment>("PopNextSegment"),
      factory.Add<SwitchSegmentType>("SwitchSegmentType"),
      factory.Add<ForEachSegment>("ForEachSegment"),
      factory.Add<RetrySegment>("RetrySegment"),
      factory.Add<WaitArmIdle>("WaitArmIdle", robot),
      factory.Add<WaitForR1Signal>("WaitForR1Signal", robot),
      factory.Add<WaitSeconds>("WaitSeconds"),
      factory.Add<SetDebugStatus>("SetDebugStatus"),
      factory.Add<IsSegmentType>("IsSegmentType"),
      factory.Add<IsString<true>>("IsStringEmpty"),
      factory.Add<IsString<false>>("IsStringNonEmpty"),
  };
  for (const Result<>& each : added) {
    if (!each) return each;
  }
  return Ok();
}

}  // namespace musher::meilin
