// route_server on a simulated network, in virtual time; and its file.

#include "musher/modules/navigation/route_server/route_server.hpp"

#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "musher/test/modules/navigation/navigation_rig.hpp"
#include "musher/test/navigation/route_graphs.hpp"
#include "musher/test/support/diagnostics.hpp"
#include "musher/test/support/paths.hpp"
#include "musher/test/support/temp_folder.hpp"

namespace musher::navigation::route_server_test {

using testing::At;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using testing::LoopBackground;
using transport::GoalEnd;
using Compute = msg::ComputeRoute;
using Track = msg::ComputeAndTrackRoute;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

//   4 ------ 3       each edge both ways, 10 m; the edge from a to b has the id 10 a + b
//   |        |
//   1 ------ 2
std::string SquareJson() {
  return testing::JsonOf({{1, {0, 0, 0}}, {2, {10, 0, 0}}, {3, {10, 10, 0}}, {4, {0, 10, 0}}},
                         {{12, 1, 2},
                          {21, 2, 1},
                          {23, 2, 3},
                          {32, 3, 2},
                          {34, 3, 4},
                          {43, 4, 3},
                          {41, 4, 1},
                          {14, 1, 4}});
}

class RouteServerTest : public ::testing::Test {
 protected:
  RouteServerTest() {
    config_.graph_file = folder_ / "graph.geojson";
    Write(SquareJson());
    config_.graph =
        std::make_shared<const RouteGraph>(ReadGraphFile(config_.graph_file, "map").value());
    config_.robots = {{"a", "a/odom", "a/compute_route", "a/compute_and_track_route"}};
  }
  void Write(const std::string& graph) { std::ofstream(config_.graph_file) << graph; }

  void Start() {
    const auto log = [this](LogLevel, const std::string& line) { log_.push_back(line); };
    server_ = RouteServer::Make({*node_, *clock_, "", log}, config_,
                                std::make_unique<LoopBackground>(node_->loop(), Milliseconds(20)))
                  .value();
    server_->Permit(true, "");
    odometry_timer_ = peers_->loop().Every(Milliseconds(50), [this] {
      if (!odometry_silent_) PublishPlace();
    });
    Run(1000);  // discovery
  }
  void PublishPlace() {
    msg::Odometry odometry;
    odometry.header.frame_id = "map";
    odometry.header.stamp = msg::ToStamp(peers_->loop().Now().time_since_epoch());
    odometry.pose.pose = ToMessage(Pose{at_, 0});
    EXPECT_TRUE(odometry_->Publish(odometry));
  }
  void Run(std::int64_t ms) { network_.RunFor(Milliseconds(ms)); }
  // To where the robot is from now on, known by the server.
  void Move(double x_m, double y_m) {
    at_ = {x_m, y_m, 0};
    Run(200);
  }
  transport::GoalOutcome<Compute> RouteBy(const Compute::Goal& goal) {
    const std::size_t index = routes_.Send(goal);
    EXPECT_TRUE(RunUntil([&] { return routes_.ends[index].has_value(); }));
    return routes_.ends[index].value_or(transport::GoalOutcome<Compute>{});
  }
  static Compute::Goal ToPlace(double x_m, double y_m) {
    Compute::Goal goal;
    goal.goal = At(x_m, y_m);
    goal.use_poses = true;
    return goal;
  }
  static Track::Goal Between(std::uint16_t from, std::uint16_t to) {
    Track::Goal goal;
    goal.start_id = from;
    goal.goal_id = to;
    return goal;
  }
  bool RunUntil(const std::function<bool()>& holds) {
    return network_.RunUntil(holds, network_.now() + Milliseconds(3000));
  }
  static std::vector<int> NodesOf(const msg::Route& route) {
    std::vector<int> ids;
    for (const msg::RouteNode& node : route.nodes) ids.push_back(node.nodeid);
    return ids;
  }
  void ExpectRefused(const Compute::Goal& goal, int code, const std::string& why) {
    const auto outcome = RouteBy(goal);
    EXPECT_EQ(outcome.end, GoalEnd::kAborted) << why;
    EXPECT_EQ(outcome.result.error_code, code) << why;
    EXPECT_THAT(outcome.result.error_msg, HasSubstr(why));
    EXPECT_TRUE(outcome.result.route.nodes.empty());
    EXPECT_TRUE(outcome.result.path.poses.empty());
    EXPECT_THAT(log_, Contains(HasSubstr(why)));
    log_.clear();
    Run(2100);  // the same kind of warning is due again
  }
  bool Change(const msg::DynamicEdges::Request& request) {
    std::optional<bool> success;
    edges_->Call(request, Milliseconds(1000),
                 [&](const auto& reply) { success = reply && reply.value().success; });
    EXPECT_TRUE(RunUntil([&] { return success.has_value(); }));
    return success.value_or(false);
  }
  bool Close(std::vector<std::uint16_t> edges) {
    msg::DynamicEdges::Request request;
    request.closed_edges = std::move(edges);
    return Change(request);
  }
  bool SetGraph(const std::string& path) {
    std::optional<bool> success;
    msg::SetRouteGraph::Request request;
    request.graph_filepath = path;
    graphs_->Call(request, Milliseconds(1000),
                  [&](const auto& reply) { success = reply && reply.value().success; });
    EXPECT_TRUE(RunUntil([&] { return success.has_value(); }));
    return success.value_or(false);
  }
  // "last -edge- next" of each feedback since the last call.
  std::vector<std::string> Feedback() {
    std::vector<std::string> lines;
    for (; read_ < tracks_.feedback.size(); ++read_) {
      const Track::Feedback& one = tracks_.feedback[read_];
      lines.push_back(fmt::format("{} -{}- {}{}", one.last_node_id, one.current_edge_id,
                                  one.next_node_id, one.rerouted ? " rerouted" : ""));
    }
    return lines;
  }
  // Tracks from 1 by 2 to 3; the robot is at 1.
  std::size_t BeginTrack() {
    Start();
    const std::size_t index = tracks_.Send(Between(1, 3));
    Run(200);
    EXPECT_FALSE(tracks_.ends[index]);
    return index;
  }
  int CodeOf(std::size_t index) const {
    const auto& end = tracks_.ends[index];
    return end && end->end == GoalEnd::kAborted ? end->result.error_code : -1;
  }
  std::string WhyOf(std::size_t index) const {
    return tracks_.ends[index] ? tracks_.ends[index]->result.error_msg : "it goes on";
  }

  const TempFolder folder_;
  transport::sim::Network network_{1};
  std::unique_ptr<transport::Node> node_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Node> peers_ = network_.MakeNode("robot");
  std::unique_ptr<transport::Clock> clock_ = transport::Clock::Steady(node_->loop());
  RouteConfig config_;
  std::vector<std::string> log_;
  std::unique_ptr<RouteServer> server_;
  Point at_{0, 0, 0};
  bool odometry_silent_ = false;
  std::unique_ptr<transport::Publisher<msg::Odometry>> odometry_ =
      transport::MakePublisher<msg::Odometry>(*peers_, "a/odom", transport::kSensorDataQos).value();
  transport::LoopHandlePtr odometry_timer_;
  testing::Goals<Compute> routes_{*peers_, "a/compute_route"};
  testing::Goals<Track> tracks_{*peers_, "a/compute_and_track_route"};
  std::unique_ptr<transport::Client<msg::DynamicEdges>> edges_ =
      transport::MakeClient<msg::DynamicEdges>(*peers_,
                                               "route_server/DynamicEdgesScorer/adjust_edges")
          .value();
  std::unique_ptr<transport::Client<msg::SetRouteGraph>> graphs_ =
      transport::MakeClient<msg::SetRouteGraph>(*peers_, "route_server/set_route_graph").value();
  std::size_t read_ = 0;
};

TEST_F(RouteServerTest, FindsARouteFromWhereTheRobotIsToTheGoal) {
  at_ = {-1, -1, 0};
  Start();
  const auto outcome = RouteBy(ToPlace(11, 11));
  ASSERT_EQ(outcome.end, GoalEnd::kSucceeded) << outcome.result.error_msg;
  EXPECT_EQ(outcome.result.error_code, 0);
  const msg::Route& route = outcome.result.route;
  EXPECT_THAT(NodesOf(route), ElementsAre(1, 2, 3));
  EXPECT_EQ(route.header.frame_id, "map");
  EXPECT_EQ(route.route_cost, 20.0F);
  ASSERT_EQ(route.edges.size(), 2U);
  EXPECT_EQ(route.edges[0].edgeid, 12);
  EXPECT_EQ(route.edges[1].start, (msg::Point{10, 0, 0}));
  EXPECT_EQ(route.edges[1].end, (msg::Point{10, 10, 0}));
  const msg::Path& path = outcome.result.path;
  EXPECT_EQ(path.header.frame_id, "map");
  ASSERT_EQ(path.poses.size(), 401U) << "each 5 cm";
  EXPECT_EQ(path.poses.front().pose.position, (msg::Point{0, 0, 0}));
  EXPECT_EQ(path.poses.back().pose.position, (msg::Point{10, 10, 0}));
}

TEST_F(RouteServerTest, FindsARouteFromAStartOrBetweenNodes) {
  Start();
  Compute::Goal goal = ToPlace(0, 10);
  goal.use_start = true;
  goal.start = At(10, 10);
  EXPECT_THAT(NodesOf(RouteBy(goal).result.route), ElementsAre(3, 4));
  goal = {};
  goal.start_id = 2;
  goal.goal_id = 4;
  goal.start = At(kNan, 0);  // poses are not used
  EXPECT_THAT(NodesOf(RouteBy(goal).result.route), ElementsAre(2, 1, 4));
  goal.goal_id = 2;
  const auto outcome = RouteBy(goal);
  EXPECT_EQ(outcome.end, GoalEnd::kSucceeded);
  EXPECT_THAT(NodesOf(outcome.result.route), ElementsAre(2));
  EXPECT_EQ(outcome.result.path.poses.size(), 1U);
}

TEST_F(RouteServerTest, LeadsNoRobotBackToANodeThatItHasPassed) {
  Start();
  Move(4, 0.5);
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 6)).result.route), ElementsAre(2))
      << "neither back to 1 nor beyond the goal to 3";
}

TEST_F(RouteServerTest, RefusesWhatItCannotFindWithTheReason) {
  Start();
  ExpectRefused(ToPlace(kNan, 0), 400, "goal: it has a number that is not finite");
  ExpectRefused(ToPlace(100, 0), 403,
                "the goal (100.00, 0.00) is 90.00 m from the nearest node, expected at most 10");
  Compute::Goal goal = ToPlace(10, 10);
  goal.goal.header.frame_id = "odom";
  ExpectRefused(goal, 401, "goal: its frame is 'odom', expected 'map'");
  goal = ToPlace(10, 10);
  goal.use_start = true;
  goal.start = At(0, std::numeric_limits<double>::infinity());
  ExpectRefused(goal, 400, "start: it has a number that is not finite");
  goal = {};
  goal.start_id = 1;
  goal.goal_id = 9;
  ExpectRefused(goal, 403, "goal_id: the graph has no node 9");
  goal.start_id = 0;
  ExpectRefused(goal, 403, "start_id: the graph has no node 0");
  Move(0, -40);
  ExpectRefused(ToPlace(10, 10), 403, "the robot at (0.00, -40.00) is 40.00 m from the nearest");
  odometry_silent_ = true;
  Run(600);
  ExpectRefused(ToPlace(10, 10), 401, "no odometry on a/odom for 0.");
}

TEST_F(RouteServerTest, LeadsThroughNoClosedEdge) {
  Start();
  EXPECT_TRUE(Close({12}));
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 10)).result.route), ElementsAre(1, 4, 3));
  EXPECT_TRUE(Close({43}));
  ExpectRefused(ToPlace(10, 10), 405, "no route leads from node 1 to node 3; 2 edges are closed");
  msg::DynamicEdges::Request open;
  open.opened_edges = {12, 43};
  EXPECT_TRUE(Change(open));
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 10)).result.route), ElementsAre(1, 2, 3));
  msg::DynamicEdges::Request dearer;
  dearer.adjust_edges = {{23, 1.5F}};
  EXPECT_TRUE(Change(dearer));
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 10)).result.route), ElementsAre(1, 4, 3));
}

TEST_F(RouteServerTest, ChangesNoEdgeByARequestThatIsWrong) {
  Start();
  EXPECT_FALSE(Close({12, 99}));
  EXPECT_THAT(log_, Contains("edges are not changed: the graph has no edge 99"));
  for (const float cost :
       {-1.0F, std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    msg::DynamicEdges::Request request;
    request.closed_edges = {12};
    request.adjust_edges = {{14, cost}};
    EXPECT_FALSE(Change(request)) << cost;
  }
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 10)).result.route), ElementsAre(1, 2, 3));
}

TEST_F(RouteServerTest, TracksARobotToTheEndOfItsRoute) {
  const std::size_t goal = BeginTrack();
  EXPECT_THAT(Feedback(), ElementsAre("1 -12- 2"));
  EXPECT_THAT(NodesOf(tracks_.feedback[0].route), ElementsAre(1, 2, 3));
  EXPECT_EQ(tracks_.feedback[0].path.poses.size(), 401U);
  Move(5, 0.2);
  EXPECT_THAT(Feedback(), IsEmpty()) << "nothing has changed";
  Move(9.9, 0.3);
  EXPECT_THAT(Feedback(), ElementsAre("2 -23- 3"));
  EXPECT_FALSE(tracks_.ends[goal]);
  Move(10, 9.5);
  ASSERT_TRUE(tracks_.ends[goal]);
  EXPECT_EQ(tracks_.ends[goal]->end, GoalEnd::kSucceeded);
  EXPECT_EQ(tracks_.ends[goal]->result.error_code, 0);
  EXPECT_EQ(tracks_.ends[goal]->result.execution_duration.sec, 0);
  EXPECT_GT(tracks_.ends[goal]->result.execution_duration.nanosec, 500'000'000U);
}

TEST_F(RouteServerTest, TracksByNoPoseOfBefore) {
  const std::size_t goal = BeginTrack();
  odometry_silent_ = true;
  at_ = {10, 10, 0};
  Run(400);
  EXPECT_FALSE(tracks_.ends[goal]);
  Run(400);
  EXPECT_EQ(CodeOf(goal), 401);
  EXPECT_THAT(WhyOf(goal), HasSubstr("the place of the robot is not known: no odometry on a/odom"));
}

// A pose that is not finite, or in a frame that has no place in the map, is none.
TEST_F(RouteServerTest, TracksByNoPoseThatIsWrong) {
  const std::size_t goal = BeginTrack();
  at_ = {kNan, 0, 0};
  Run(900);
  EXPECT_EQ(CodeOf(goal), 401);
  EXPECT_THAT(log_, Contains(HasSubstr("a: refused: ")));
}

TEST_F(RouteServerTest, TracksNoRouteWithoutAPose) {
  odometry_silent_ = true;
  Start();
  const std::size_t goal = tracks_.Send(Between(1, 3));
  Run(200);
  EXPECT_EQ(CodeOf(goal), 401);
  EXPECT_THAT(Feedback(), IsEmpty());
}

TEST_F(RouteServerTest, EndsATrackedRouteForANewerGoalAndForItsClient) {
  const std::size_t first = BeginTrack();
  const std::size_t second = tracks_.Send(Between(1, 4));
  Run(200);
  EXPECT_EQ(CodeOf(first), 400);
  EXPECT_EQ(WhyOf(first), "a newer goal has replaced this one");
  EXPECT_THAT(Feedback(), ElementsAre("1 -12- 2", "1 -14- 4"));
  tracks_.Cancel(second);
  Run(200);
  ASSERT_TRUE(tracks_.ends[second]);
  EXPECT_EQ(tracks_.ends[second]->end, GoalEnd::kCanceled);
  Move(0, 10);
  EXPECT_THAT(Feedback(), IsEmpty());
}

TEST_F(RouteServerTest, EndsATrackedRouteForANewerGoalThatIsRefused) {
  const std::size_t first = BeginTrack();
  const std::size_t second = tracks_.Send(Between(1, 77));
  Run(200);
  EXPECT_EQ(CodeOf(first), 400);
  EXPECT_EQ(CodeOf(second), 403);
}

TEST_F(RouteServerTest, HasAnotherRouteOnceAnEdgeAheadIsClosed) {
  const std::size_t goal = BeginTrack();
  Move(5, 0);
  Feedback();
  EXPECT_TRUE(Close({23}));
  Run(100);
  EXPECT_THAT(Feedback(), ElementsAre("1 -12- 2 rerouted"));
  EXPECT_THAT(NodesOf(tracks_.feedback.back().route), ElementsAre(1, 2, 1, 4, 3))
      << "it turns at the next node";
  Move(10, 0);
  EXPECT_THAT(Feedback(), ElementsAre("2 -21- 1"));
  EXPECT_TRUE(Close({21}));
  Run(100);
  EXPECT_EQ(CodeOf(goal), 405) << "it is on an edge that is closed, and there is no other one";
  EXPECT_THAT(WhyOf(goal), HasSubstr("no route leads from node 2 to node 3"));
}

TEST_F(RouteServerTest, TurnsBackOnAnEdgeThatIsClosed) {
  BeginTrack();
  Move(5, 0);
  Feedback();
  EXPECT_TRUE(Close({12}));
  Run(100);
  EXPECT_THAT(NodesOf(tracks_.feedback.back().route), ElementsAre(1, 4, 3));
  EXPECT_THAT(Feedback(), ElementsAre("0 -0- 1 rerouted"));
}

TEST_F(RouteServerTest, IsNotDisturbedByAnEdgeThatItHasPassed) {
  BeginTrack();
  Move(10, 3);
  Feedback();
  EXPECT_TRUE(Close({12}));
  Run(100);
  EXPECT_THAT(Feedback(), IsEmpty());
}

TEST_F(RouteServerTest, ReadsItsFileAgainOrAnotherOne) {
  const std::size_t goal = BeginTrack();
  Write("{");
  EXPECT_FALSE(SetGraph(""));
  EXPECT_THAT(log_, Contains(HasSubstr("graph.geojson: line 1, column 2: invalid JSON; the one "
                                       "before stays")));
  EXPECT_FALSE(SetGraph("missing.geojson"));
  EXPECT_FALSE(SetGraph("/dev"));
  EXPECT_FALSE(tracks_.ends[goal]) << "the graph is what it was";
  Write(testing::JsonOf({{1, {0, 0, 0}}, {3, {10, 10, 0}}}, {{13, 1, 3}}));
  EXPECT_TRUE(SetGraph(""));
  Run(100);
  EXPECT_EQ(CodeOf(goal), 402);
  EXPECT_EQ(WhyOf(goal), "the graph was replaced");
  EXPECT_THAT(NodesOf(RouteBy(ToPlace(10, 10)).result.route), ElementsAre(1, 3));
  EXPECT_FALSE(Close({12})) << "an edge of the graph before";
}

// Its reader would wait for ever.
TEST_F(RouteServerTest, ReadsNoPipe) {
  Start();
  const std::string pipe = folder_ / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_FALSE(SetGraph(pipe));
  EXPECT_THAT(log_, Contains(HasSubstr("pipe: it is no regular file")));
}

TEST_F(RouteServerTest, RejectsGoalsOutsideOfActiveAndEndsThePresentOne) {
  const std::size_t goal = BeginTrack();
  server_->Permit(false, "it is in LowPower");
  Run(100);
  EXPECT_EQ(CodeOf(goal), 400);
  EXPECT_EQ(WhyOf(goal), "it is in LowPower");
  EXPECT_EQ(RouteBy(ToPlace(10, 10)).end, GoalEnd::kRejected);
  EXPECT_THAT(log_, Contains("a: a goal is rejected: it is in LowPower"));
  server_->Permit(true, "");
  EXPECT_EQ(RouteBy(ToPlace(10, 10)).end, GoalEnd::kSucceeded);
}

TEST_F(RouteServerTest, ForgetsThePlaceOfTheRobotWhenTheWorldIsRestarted) {
  const std::size_t goal = BeginTrack();
  odometry_silent_ = true;
  Run(50);
  server_->OnTimeJump("the time has jumped");
  Run(100);
  EXPECT_EQ(WhyOf(goal), "the time has jumped");
  EXPECT_FALSE(server_->Check().result());
  EXPECT_EQ(server_->Check().result().error().message, "a: no odometry on a/odom");
}

TEST_F(RouteServerTest, IsDestroyedWhileItTracksAndReads) {
  const std::size_t goal = BeginTrack();
  msg::SetRouteGraph::Request request;
  graphs_->Call(request, Milliseconds(1000), [](const auto&) {});
  Run(5);
  server_.reset();
  Run(1000);
  ASSERT_TRUE(tracks_.ends[goal]);
}

std::string FileError(const std::string& text) {
  return musher::testing::FirstError(ReadRouteText(text, "/x/route.toml"));
}

TEST(RouteFile, ThatIsShippedHasTheDefaultsAndAGraph) {
  const auto reading = ReadRouteFile(SourceDir() + "/config/navigation/route.toml");
  ASSERT_THAT(reading.diagnostics, IsEmpty());
  const RouteConfig& file = *reading.config;
  const auto brief = ReadRouteText("graph = \"g.geojson\"\n[[robot]]\nname = \"jetbot_0\"\n", "r");
  ASSERT_TRUE(brief.config);
  const RouteConfig& defaults = *brief.config;
  EXPECT_EQ(file.frame, defaults.frame);
  EXPECT_EQ(file.edges, defaults.edges);
  EXPECT_EQ(file.set_graph, defaults.set_graph);
  EXPECT_EQ(file.step_m, defaults.step_m);
  EXPECT_EQ(file.near_m, defaults.near_m);
  EXPECT_EQ(file.beside_m, defaults.beside_m);
  EXPECT_EQ(file.track.reached_m, defaults.track.reached_m);
  EXPECT_EQ(file.track.end_reached_m, defaults.track.end_reached_m);
  EXPECT_EQ(file.stale, defaults.stale);
  EXPECT_EQ(file.self_check_time, defaults.self_check_time);
  EXPECT_EQ(file.tf.topic, defaults.tf.topic);
  EXPECT_EQ(file.tf.stale, defaults.tf.stale);
  ASSERT_FALSE(file.robots.empty());
  EXPECT_EQ(file.robots[0].odometry, defaults.robots[0].odometry);
  EXPECT_EQ(file.robots[0].action, defaults.robots[0].action);
  EXPECT_EQ(file.robots[0].track, defaults.robots[0].track);
  ASSERT_NE(file.graph, nullptr);
  EXPECT_GT(file.graph->nodes.size(), 3U);
}

TEST(RouteFile, ReportsErrorsAtTheirPlace) {
  EXPECT_EQ(FileError("[[robot]]\nname = \"a\"\n"),
            "/x/route.toml:1:1: error: the key \"graph\" is missing; expected the GeoJSON file of "
            "the graph, as in \"route_graph.geojson\"");
  EXPECT_EQ(FileError("graph = \"g\"\nnear_cm = 3\n[[robot]]\nname = \"a\"\n"),
            "/x/route.toml:2:1: error: unknown key \"near_cm\"; did you mean \"near_m\"?");
  EXPECT_EQ(FileError("graph = \"g\"\n[[robot]]\nname = \"a\"\n[[robot]]\nname = \"a\"\n"),
            "/x/route.toml:5:8: error: robot.name: another table has the robot \"a\"");
  EXPECT_EQ(FileError("graph = \"g\"\nstep_m = 0\n[[robot]]\nname = \"a\"\n").substr(0, 30),
            "/x/route.toml:2:10: error: ste");
}

TEST(RouteFile, NamesAGraphThatCannotBeUsed) {
  const TempFolder folder;
  std::ofstream(folder / "route.toml") << "graph = \"g.geojson\"\n[[robot]]\nname = \"a\"\n";
  const auto error = [&folder] {
    return musher::testing::FirstError(ReadRouteFile(folder / "route.toml"));
  };
  EXPECT_THAT(error(), HasSubstr("g.geojson: the file cannot be read: No such file"));
  std::ofstream(folder / "g.geojson")
      << testing::GraphJson({testing::NodeJson(1, "[0, 0]"), testing::EdgeJson(2, 1, 3)});
  EXPECT_THAT(error(), HasSubstr("g.geojson: features[1].properties.endid: there is no node 3"));
}

}  // namespace musher::navigation::route_server_test
