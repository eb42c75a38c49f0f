// Graphs of routes: what is read of GeoJSON, the cheapest way, and the path along it.

#include "musher/navigation/route/route_graph.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "musher/navigation/navigation_fault.hpp"
#include "musher/test/navigation/route_graphs.hpp"

namespace musher::navigation::route_graph_test {

using testing::EdgeJson;
using ::testing::ElementsAre;
using testing::GraphJson;
using testing::GraphOf;
using ::testing::HasSubstr;
using testing::NodeJson;

std::string FaultOf(const std::string& geojson) {
  const auto graph = ReadRouteGraph(geojson, "map");
  if (graph) return "it is read";
  EXPECT_TRUE(Is(graph.error(), Fault::kMap));
  return graph.error().message;
}
std::vector<int> NodesOf(const RouteGraph& graph, const Route& route) {
  std::vector<int> ids;
  for (const std::size_t node : route.nodes) ids.push_back(graph.nodes[node].id);
  return ids;
}
std::vector<int> EdgesOf(const RouteGraph& graph, const Route& route) {
  std::vector<int> ids;
  for (const std::size_t edge : route.edges) ids.push_back(graph.edges[edge].id);
  return ids;
}
Result<Route> RouteOf(const RouteGraph& graph, RouteId from, RouteId to,
                      const EdgeChanges& changes = {}) {
  return FindRoute(graph, *graph.NodeOf(from), *graph.NodeOf(to), changes);
}

TEST(RouteGraphFile, HasNodesAndEdgesWithTheirCostsInTheOrderOfTheirIds) {
  const auto graph =
      ReadRouteGraph(GraphJson({EdgeJson(9, 2, 1, R"("cost": 7.5, "overridable": false)"),
                                NodeJson(2, "[3, 4]", R"("frame": "map")"),
                                NodeJson(1, "[0, 0, 0.5]"), EdgeJson(4, 1, 2, R"("cost": 7.5)")}),
                     "map");
  ASSERT_TRUE(graph) << graph.error().message;
  ASSERT_EQ(graph.value().nodes.size(), 2U);
  EXPECT_EQ(graph.value().nodes[0].id, 1);
  EXPECT_EQ(graph.value().nodes[0].at, (Point{0, 0, 0.5}));
  EXPECT_EQ(graph.value().nodes[1].at, (Point{3, 4, 0}));
  ASSERT_EQ(graph.value().edges.size(), 2U);
  EXPECT_EQ(graph.value().edges[0].id, 4);
  EXPECT_NEAR(graph.value().edges[0].cost, std::hypot(3, 4, 0.5), 1e-12) << "its length";
  EXPECT_EQ(graph.value().edges[1].cost, 7.5) << "may not be overridden";
}

// Properties that are not used may be nested as deeply as they like.
TEST(RouteGraphFile, MayHavePropertiesThatAreNotUsed) {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']');
  const auto graph =
      ReadRouteGraph(GraphJson({NodeJson(1, "[0, 0]", "\"metadata\": {\"a\": " + deep + "}")},
                               R"("crs": {"type": "name"}, )"),
                     "map");
  ASSERT_TRUE(graph) << graph.error().message;
}

TEST(RouteGraphFile, ThatIsWrongIsRefusedWithThePlace) {
  EXPECT_THAT(FaultOf(""), HasSubstr("line 1, column 1: invalid JSON"));
  EXPECT_EQ(FaultOf("{\n  \"features\": [NaN]\n}"), "line 2, column 16: invalid JSON");
  EXPECT_THAT(FaultOf("[]"), HasSubstr("features: expected an array"));
  EXPECT_THAT(FaultOf(GraphJson({})), HasSubstr("features: the graph has no nodes"));
  EXPECT_EQ(FaultOf(GraphJson({"3"})),
            "features[0].geometry.type: expected Point (a node), MultiLineString or LineString (an "
            "edge), it is missing");
  EXPECT_THAT(FaultOf(GraphJson({R"({"geometry": {"type": "Polygon"}})"})),
              HasSubstr("found \"Polygon\""));
  EXPECT_EQ(
      FaultOf(GraphJson({NodeJson(1, "[0, 0]"), NodeJson(2, "[1, 0]"), NodeJson(1, "[2, 0]")})),
      "features[2].properties.id: the graph has node 1 already");
  EXPECT_EQ(FaultOf(GraphJson({NodeJson(1, "[0, 0]"), NodeJson(2, "[1, 0]"), EdgeJson(5, 1, 2),
                               EdgeJson(5, 2, 1)})),
            "features[3].properties.id: the graph has edge 5 already");
  EXPECT_EQ(FaultOf(GraphJson({NodeJson(1, "[0, 0]"), EdgeJson(5, 1, 7)})),
            "features[1].properties.endid: there is no node 7");
  EXPECT_EQ(FaultOf(GraphJson({NodeJson(1, "[0, 0]"), EdgeJson(5, 1, 1)})),
            "features[1].properties.endid: the edge leads from node 1 to itself");
  EXPECT_EQ(FaultOf(GraphJson({NodeJson(1, "[0, 0]", R"("frame": "odom")")})),
            "features[0].properties.frame: expected \"map\", the frame of the server, found "
            "\"odom\"");
  EXPECT_EQ(FaultOf(GraphJson({NodeJson(70000, "[0, 0]")})),
            "features[0].properties.id: expected a whole number from 0 to 65535, found 70000");
  EXPECT_THAT(FaultOf(GraphJson({R"({"geometry": {"type": "Point"}, "properties": {}})"})),
              HasSubstr("properties.id: expected a whole number from 0 to 65535, it is missing"));
  EXPECT_THAT(FaultOf(GraphJson({R"({"geometry": {"type": "Point"}, "properties": 3})"})),
              HasSubstr("features[0].properties: expected an object with an id"));
  for (const char* at : {"[0]", "[0, 0, 0, 0]", "[\"0\", 0]", "[null, 0]", "[2e6, 0]", "3"}) {
    EXPECT_EQ(FaultOf(GraphJson({NodeJson(1, at)})),
              "features[0].geometry.coordinates: expected [x, y] or [x, y, z] in m, from -1e6 to "
              "1e6")
        << at;
  }
  EXPECT_THAT(FaultOf(GraphJson({NodeJson(1, "[1e999, 0]")})),
              HasSubstr("invalid JSON: a number is too large"));
  for (const char* cost : {"-1", "\"3\"", "1e10", "null"}) {
    EXPECT_THAT(FaultOf(GraphJson({NodeJson(1, "[0, 0]"), NodeJson(2, "[1, 0]"),
                                   EdgeJson(5, 1, 2, fmt::format("\"cost\": {}", cost))})),
                HasSubstr("features[2].properties.cost: expected a number from 0 to 1e9"))
        << cost;
  }
  EXPECT_THAT(FaultOf(GraphJson({NodeJson(1, "[0]"), NodeJson(2, "[1]")})),
              HasSubstr("(and 1 more faults)"));
}

// Its time grew with the square of its nodes.
TEST(RouteGraphFile, WithAllIdsIsRead) {
  std::vector<std::string> features;
  for (int id = 0; id < 65'536; ++id) features.push_back(NodeJson(id, fmt::format("[{}, 0]", id)));
  for (int id = 0; id < 65'535; ++id) features.push_back(EdgeJson(id, id, id + 1));
  const std::string text = GraphJson(features);
  const auto begin = std::chrono::steady_clock::now();
  const auto graph = ReadRouteGraph(text, "map");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::minutes(2));
  ASSERT_TRUE(graph) << graph.error().message;
  EXPECT_EQ(graph.value().nodes.size(), 65'536U);
  EXPECT_EQ(FindRoute(graph.value(), 0, 65'535).value().edges.size(), 65'535U);
}

TEST(RouteGraphFile, ThatIsTooLargeIsRefused) {
  EXPECT_EQ(FaultOf(std::string(kMostGraphBytes + 1, ' ')), "the graph is larger than 64 MiB");
}

// Any text ends with a graph or a fault. A text that is a graph with one byte changed comes nearer
// to the reader's decisions than any text.
RC_GTEST_PROP(RouteGraphFile, OfAnyTextIsAGraphOrAFault, ()) {
  std::string text = GraphJson({NodeJson(1, "[0, 0]"), NodeJson(2, "[1, 0]"), EdgeJson(5, 1, 2)});
  const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
  text[at] = *rc::gen::arbitrary<char>();
  const auto graph = ReadRouteGraph(text, "map");
  if (graph) {
    RC_ASSERT(!graph.value().nodes.empty());
    for (const GraphEdge& edge : graph.value().edges) {
      RC_ASSERT(edge.from < graph.value().nodes.size() && edge.to < graph.value().nodes.size());
    }
  } else {
    RC_ASSERT(!graph.error().message.empty());
  }
}

//   3 -- 4
//   |    |      all edges both ways, 1 m
//   1 -- 2
const RouteGraph& Square() {
  static const RouteGraph graph =
      GraphOf({{1, {0, 0, 0}}, {2, {1, 0, 0}}, {3, {0, 1, 0}}, {4, {1, 1, 0}}}, {{10, 1, 2},
                                                                                 {11, 2, 1},
                                                                                 {12, 1, 3},
                                                                                 {13, 3, 1},
                                                                                 {14, 2, 4},
                                                                                 {15, 4, 2},
                                                                                 {16, 3, 4},
                                                                                 {17, 4, 3}});
  return graph;
}

TEST(ARoute, IsTheCheapestOneAndTheSameEachTime) {
  const auto route = RouteOf(Square(), 1, 4);
  ASSERT_TRUE(route);
  EXPECT_THAT(NodesOf(Square(), route.value()), ElementsAre(1, 2, 4)) << "of two that cost 2";
  EXPECT_THAT(EdgesOf(Square(), route.value()), ElementsAre(10, 14));
  EXPECT_EQ(route.value().cost, 2);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(RouteOf(Square(), 1, 4).value(), route.value());
  const auto around =
      RouteOf(Square(), 1, 4, {.closed = {}, .dearer = {{*Square().EdgeOf(14), 0.5}}});
  EXPECT_THAT(NodesOf(Square(), around.value()), ElementsAre(1, 3, 4));
}

TEST(ARoute, TakesTheFirstOfTwoEdgesBetweenTheSameNodes) {
  const RouteGraph graph =
      GraphOf({{1, {0, 0, 0}}, {2, {1, 0, 0}}}, {{30, 1, 2}, {20, 1, 2}, {25, 2, 1}});
  EXPECT_THAT(EdgesOf(graph, RouteOf(graph, 1, 2).value()), ElementsAre(20));
}

TEST(ARoute, LeadsThroughNoClosedEdgeAndFailsWhereThereIsNoOther) {
  EdgeChanges changes;
  changes.closed = {*Square().EdgeOf(14)};
  EXPECT_THAT(NodesOf(Square(), RouteOf(Square(), 1, 4, changes).value()), ElementsAre(1, 3, 4));
  changes.closed.insert(*Square().EdgeOf(16));
  const auto none = RouteOf(Square(), 1, 4, changes);
  ASSERT_FALSE(none);
  EXPECT_TRUE(Is(none.error(), Fault::kWalledIn));
  EXPECT_EQ(none.error().message, "no route leads from node 1 to node 4; 2 edges are closed");
  EXPECT_TRUE(RouteOf(Square(), 4, 1, changes)) << "the way back is another edge";
}

TEST(ARoute, FollowsTheDirectionOfItsEdges) {
  const RouteGraph graph = GraphOf({{1, {0, 0, 0}}, {2, {1, 0, 0}}}, {{10, 1, 2}});
  EXPECT_TRUE(RouteOf(graph, 1, 2));
  EXPECT_EQ(RouteOf(graph, 2, 1).error().message, "no route leads from node 2 to node 1");
}

TEST(ARoute, FromANodeToItselfIsThatNode) {
  const auto route = RouteOf(Square(), 3, 3);
  ASSERT_TRUE(route);
  EXPECT_THAT(NodesOf(Square(), route.value()), ElementsAre(3));
  EXPECT_EQ(PathAlong(Square(), route.value(), 0.1, 0.7), (Path{{{0, 1, 0}, 0.7}}));
}

// Against every route without a loop.
double CheapestBySearch(const RouteGraph& graph, std::size_t from, std::size_t to,
                        std::vector<char>& seen) {
  if (from == to) return 0;
  double best = std::numeric_limits<double>::infinity();
  seen[from] = 1;
  for (const std::size_t edge : graph.leave[from]) {
    if (seen[graph.edges[edge].to]) continue;
    best = std::min(
        best, graph.edges[edge].cost + CheapestBySearch(graph, graph.edges[edge].to, to, seen));
  }
  seen[from] = 0;
  return best;
}
RC_GTEST_PROP(ARoute, CostsAsLittleAsAnyOther, ()) {
  const auto count = *rc::gen::inRange<int>(1, 7);
  std::vector<testing::NodeAt> nodes;
  for (int i = 0; i < count; ++i) {
    nodes.push_back({static_cast<RouteId>(i),
                     {*rc::gen::inRange(0, 5) * 1.0, *rc::gen::inRange(0, 5) * 1.0, 0}});
  }
  std::vector<testing::EdgeBetween> edges;
  for (RouteId id = 0; id < 12 && count > 1; ++id) {
    const auto from = static_cast<RouteId>(*rc::gen::inRange(0, count));
    const auto to = static_cast<RouteId>((from + *rc::gen::inRange(1, count)) % count);
    edges.push_back({id, from, to});
  }
  const RouteGraph graph = GraphOf(nodes, edges);
  const auto to = static_cast<std::size_t>(count - 1);
  std::vector<char> seen(graph.nodes.size());
  const double best = CheapestBySearch(graph, 0, to, seen);
  const auto route = FindRoute(graph, 0, to);
  RC_ASSERT(route.ok() == std::isfinite(best));
  if (!route) return;
  RC_ASSERT(std::abs(route.value().cost - best) < 1e-9);
  RC_ASSERT(route.value().nodes.front() == 0U);
  RC_ASSERT(route.value().nodes.back() == to);
  double cost = 0;
  for (std::size_t i = 0; i < route.value().edges.size(); ++i) {
    const GraphEdge& edge = graph.edges[route.value().edges[i]];
    RC_ASSERT(edge.from == route.value().nodes[i]);
    RC_ASSERT(edge.to == route.value().nodes[i + 1]);
    cost += edge.cost;
  }
  RC_ASSERT(std::abs(cost - best) < 1e-9);
}

TEST(TheNearestNode, IsThatOfTheSmallestIdWhereTwoAreAsNear) {
  const auto nearest = [](double x_m, double y_m) {
    return Square().nodes[NearestNode(Square(), {x_m, y_m, 9}, 10, "the goal").value()].id;
  };
  EXPECT_EQ(nearest(0.9, 0.2), 2);
  EXPECT_EQ(nearest(0.5, 0.5), 1) << "as near to all";
  EXPECT_EQ(nearest(1.5, 0.5), 2) << "as near to 4";
}

TEST(TheNearestNode, ThatIsTooFarAwayIsNone) {
  EXPECT_TRUE(NearestNode(Square(), {3, 0, 0}, 2, "the goal"));
  const auto none = NearestNode(Square(), {4, 0, 0}, 2, "the goal");
  ASSERT_FALSE(none);
  EXPECT_TRUE(Is(none.error(), Fault::kOutside));
  EXPECT_EQ(none.error().message,
            "the goal (4.00, 0.00) is 3.00 m from the nearest node, expected at most 2.00 m");
}

// 1 -- 2 -- 3 -- 4, each 10 m.
const RouteGraph& Line() {
  static const RouteGraph graph =
      GraphOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}, {3, {20, 0, 0}}, {4, {30, 0, 0}}},
              {{12, 1, 2}, {23, 2, 3}, {34, 3, 4}, {43, 4, 3}, {32, 3, 2}, {21, 2, 1}});
  return graph;
}

TEST(ARouteBetweenPlaces, LeadsNeitherBackToItsFirstNodeNorBeyondItsGoal) {
  const auto nodes = [](std::optional<Point> start, std::optional<Point> goal) {
    const Route route = RouteOf(Line(), 1, 4).value();
    return NodesOf(Line(), WithoutDetours(Line(), route, start, goal, 1));
  };
  EXPECT_THAT(nodes({}, {}), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(nodes(Point{4, 0.5, 0}, Point{26, -0.5, 0}), ElementsAre(2, 3));
  EXPECT_THAT(nodes(Point{-1, 0, 0}, Point{31, 0, 0}), ElementsAre(1, 2, 3, 4)) << "before, behind";
  EXPECT_THAT(nodes(Point{4, 1.5, 0}, Point{26, 1.5, 0}), ElementsAre(1, 2, 3, 4)) << "too far off";
  EXPECT_THAT(nodes(Point{0.05, 0, 0}, Point{29.95, 0, 0}), ElementsAre(1, 2, 3, 4)) << "at them";
  Route one = RouteOf(Line(), 1, 2).value();
  one = WithoutDetours(Line(), one, Point{4, 0, 0}, Point{6, 0, 0}, 1);
  EXPECT_THAT(NodesOf(Line(), one), ElementsAre(2)) << "a node stays";
  EXPECT_EQ(one.cost, 0);
}

TEST(ThePathOfARoute, HasPosesAtSmallStepsThatLookAlongIt) {
  const Route route = RouteOf(Square(), 1, 4).value();
  const Path path = PathAlong(Square(), route, 0.3);
  ASSERT_EQ(path.size(), 9U);
  EXPECT_EQ(path.front(), (Pose{{0, 0, 0}, 0}));
  EXPECT_EQ(path[4].at, (Point{1, 0, 0}));
  EXPECT_NEAR(path[4].yaw_rad, M_PI / 2, 1e-12) << "at the node it looks ahead";
  EXPECT_EQ(path.back().at, (Point{1, 1, 0}));
  for (std::size_t i = 1; i < path.size(); ++i) {
    EXPECT_LE(Distance(path[i - 1].at, path[i].at), 0.3);
  }
}

TEST(ThePathOfARoute, HasABoundedNumberOfPoses) {
  const RouteGraph graph = GraphOf({{1, {-1e6, 0, 0}}, {2, {1e6, 0, 0}}}, {{10, 1, 2}});
  EXPECT_LE(PathAlong(graph, RouteOf(graph, 1, 2).value(), 0.05).size(), 100'000U);
}

}  // namespace musher::navigation::route_graph_test
