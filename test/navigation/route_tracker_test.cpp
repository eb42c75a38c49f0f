// Which node of its route a robot has reached.

#include "musher/navigation/route/route_tracker.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <string>

#include "musher/test/navigation/route_graphs.hpp"

namespace musher::navigation::route_tracker_test {

using testing::GraphOf;

// The ids of the last node, the edge and the next node: "1 -12- 2"; "." where there is none.
std::string StateOf(const RouteTracker& tracker) {
  const RouteGraph& graph = tracker.graph();
  const auto last = tracker.last_node(), next = tracker.next_node(), edge = tracker.edge();
  return (last ? std::to_string(graph.nodes[*last].id) : ".") + " -" +
         (edge ? std::to_string(graph.edges[*edge].id) : ".") + "- " +
         (next ? std::to_string(graph.nodes[*next].id) : ".");
}
RouteTracker TrackerOf(RouteGraph graph, RouteId from, RouteId to) {
  const auto shared = std::make_shared<const RouteGraph>(std::move(graph));
  return {shared,
          FindRoute(*shared, *shared->NodeOf(from), *shared->NodeOf(to)).value(),
          {.reached_m = 2, .end_reached_m = 1}};
}
// 1 leads 10 m to the east to 2, that 10 m to the north to 3.
RouteTracker Corner() {
  return TrackerOf(
      GraphOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}, {3, {10, 10, 0}}}, {{12, 1, 2}, {23, 2, 3}}), 1, 3);
}

TEST(ATrackedRoute, HasItsNodesReachedOneAfterTheOther) {
  RouteTracker tracker = Corner();
  EXPECT_FALSE(tracker.Update({-3, 0, 0}));
  EXPECT_EQ(StateOf(tracker), ". -.- 1");
  EXPECT_TRUE(tracker.Update({-0.9, 0, 0}));
  EXPECT_EQ(StateOf(tracker), "1 -12- 2");
  EXPECT_FALSE(tracker.Update({5, 0.3, 0}));
  EXPECT_FALSE(tracker.Update({8.5, 0, 0})) << "near the corner, and not past it";
  EXPECT_TRUE(tracker.Update({9.8, 0.3, 0})) << "past the line that halves it";
  EXPECT_EQ(StateOf(tracker), "2 -23- 3");
  EXPECT_FALSE(tracker.Update({10, 8.9, 0}));
  EXPECT_FALSE(tracker.done());
  EXPECT_TRUE(tracker.Update({10, 9.1, 5})) << "heights do not count";
  EXPECT_EQ(StateOf(tracker), "3 -.- .");
  EXPECT_TRUE(tracker.done());
  EXPECT_FALSE(tracker.Update({0, 0, 0})) << "it has ended";
}

TEST(ATrackedRoute, GoesOnWhereTheRobotJoinsItBehindItsFirstNodes) {
  RouteTracker tracker = Corner();
  EXPECT_TRUE(tracker.Update({4, 1, 0}));
  EXPECT_EQ(StateOf(tracker), "1 -12- 2");
  EXPECT_TRUE(tracker.Update({11, 5, 0})) << "beside the edge behind the corner, which it has cut";
  EXPECT_EQ(StateOf(tracker), "2 -23- 3");
}

// In an aisle the way back lies a metre beside the way there.
TEST(ATrackedRoute, IsNotTakenForItsWayBackBesideIt) {
  RouteTracker tracker =
      TrackerOf(GraphOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}, {3, {10, 1, 0}}, {4, {0, 1, 0}}},
                        {{12, 1, 2}, {23, 2, 3}, {34, 3, 4}}),
                1, 4);
  tracker.Update({0, 0, 0});
  for (double x_m = 0.5; x_m < 9.7; x_m += 0.1) {
    tracker.Update({x_m, 0.2, 0});
    ASSERT_EQ(StateOf(tracker), "1 -12- 2") << x_m;
  }
  for (double y_m = 0.2; y_m < 1; y_m += 0.1) tracker.Update({10, y_m, 0});
  tracker.Update({9, 1, 0});
  EXPECT_EQ(StateOf(tracker), "3 -34- 4");
  tracker.Update({0.5, 1, 0});
  EXPECT_TRUE(tracker.done());
}

TEST(ATrackedRoute, LeadsBackOnTheSameWay) {
  RouteTracker tracker = TrackerOf(
      GraphOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}, {3, {5, 0, 0}}}, {{12, 1, 2}, {23, 2, 3}}), 1, 3);
  tracker.Update({0, 0, 0});
  tracker.Update({5, 0, 0});
  EXPECT_EQ(StateOf(tracker), "1 -12- 2") << "its end has to wait until it was at 2";
  tracker.Update({9.2, 0, 0});
  EXPECT_EQ(StateOf(tracker), "2 -23- 3");
  tracker.Update({5.5, 0, 0});
  EXPECT_TRUE(tracker.done());
}

TEST(ATrackedRoute, OfOneNodeEndsThere) {
  RouteTracker tracker = TrackerOf(GraphOf({{1, {0, 0, 0}}}, {}), 1, 1);
  tracker.Update({1.5, 0, 0});
  EXPECT_EQ(StateOf(tracker), ". -.- 1");
  tracker.Update({0.5, 0, 0});
  EXPECT_TRUE(tracker.done());
}

TEST(ATrackedRoute, IsClosedWhereAnEdgeThatIsLeftIsClosed) {
  RouteTracker tracker = Corner();
  const auto closed = [&tracker](RouteId edge) {
    EdgeChanges changes;
    changes.closed = {*tracker.graph().EdgeOf(edge)};
    return tracker.IsClosed(changes);
  };
  EXPECT_TRUE(closed(12));
  tracker.Update({0, 0, 0});
  EXPECT_TRUE(closed(12)) << "it is on it";
  tracker.Update({10, 1, 0});
  EXPECT_FALSE(closed(12)) << "it has passed it";
  EXPECT_TRUE(closed(23));
  tracker.Update({10, 10, 0});
  EXPECT_FALSE(closed(23));
}

}  // namespace musher::navigation::route_tracker_test
