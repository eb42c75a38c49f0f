// The page of `musher-view` for a person at another host, by a plain HTTP client there: the
// emergency stop needs no login on the robot's networks, everything else does.

#include <algorithm>
#include <regex>

#include "musher/test/integration/network/robot_and_desk.hpp"

namespace musher::testing::page_test {

using ::testing::EndsWith;
using ::testing::HasSubstr;

constexpr const char* kPort = "8765";
constexpr const char* kProxyPort = "8080";

struct Answer {
  int status = 0;  // 0: no connection
  std::string body;
  std::string cookie;
};

class PageFromTheDesk : public RobotAndDesk {
 protected:
  void SetUp() override {
    RobotAndDesk::SetUp();
    if (IsSkipped()) return;
    Connect(kEthernet);
    Connect(kWifi);
    ASSERT_NO_FATAL_FAILURE(Start());
  }

  // On the robot, on all of its addresses.
  void Serve(std::vector<std::string> more = {}) {
    std::vector<std::string> words = {BinDir() + "/musher-view", "--bind", "0.0.0.0", "--port",
                                      kPort};
    words.insert(words.end(), more.begin(), more.end());
    view_ = std::make_unique<Process>(robot_->Here(words));
    const std::string acting = view_->LineWith("enter the PIN");
    std::smatch found;
    ASSERT_TRUE(std::regex_search(acting, found, std::regex("PIN (\\d{6})"))) << acting;
    pin_ = found[1];
    // It follows the machine once it has discovered it.
    ASSERT_TRUE(Until([this] {
      return Request(*robot_, "POST", "127.0.0.1", "/api/plan", R"({"target":"LowPower"})")
                 .status == 200;
    }));
  }

  // `more`: headers.
  static Answer Request(const Host& from, const std::string& method, const std::string& address,
                        const std::string& path, const std::string& body = "",
                        const std::vector<std::string>& more = {}, const char* port = kPort) {
    const std::string script = SourceDir() + "/test/integration/network/http_request.py";
    std::vector<std::string> words = {"python3", script, method,
                                      "http://" + address + ":" + port + path, body};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = from.Do(words);
    EXPECT_EQ(ended.exit, 0) << ended.err;
    const nlohmann::json read = Json(ended.out);
    return {read["status"], read["body"], read["cookie"]};
  }
  Answer Get(const std::string& address, const std::string& path) const {
    return Request(*desk_, "GET", address, path);
  }
  Answer Post(const std::string& address, const std::string& path, const std::string& body = "{}",
              const std::vector<std::string>& more = {}) const {
    return Request(*desk_, "POST", address, path, body, more);
  }
  bool IsStopped() const { return robot_->Status()["emergency_stop"]["engaged"]; }

  // With the stop of the page, without a login; and released by a person with one.
  void ExpectTheStopWorks(const std::string& address) {
    SCOPED_TRACE(address);
    ASSERT_FALSE(IsStopped());
    const Answer stop = Post(address, "/api/estop", R"({"reason":"smoke"})");
    EXPECT_EQ(stop.status, 200) << stop.body;
    EXPECT_TRUE(IsStopped());
    EXPECT_EQ(robot_->Status()["held_by_stop"].size(), 3U);
    ASSERT_EQ(robot_->Run({"estop", "--release"}).exit, 0);
    ASSERT_EQ(robot_->Run({"set", "Active"}).exit, 0);
  }
  // Nothing of what acts is done, nor shown where looking needs a login.
  void ExpectActingNeedsALogin(const std::string& address, int status,
                               const char* port = kPort) const {
    for (const char* path : {"/api/set", "/api/release", "/api/restart", "/api/skill",
                             "/api/cancel_skill", "/api/pause_skill"}) {
      const Answer refused = Request(*desk_, "POST", address, path,
                                     R"({"target":"LowPower","actuator":"legs"})", {}, port);
      EXPECT_EQ(refused.status, status) << path << refused.body;
      EXPECT_THAT(refused.body, HasSubstr("login")) << path;
    }
    EXPECT_EQ(robot_->Status()["state"], "Active");
    EXPECT_EQ(Pids(), pids_);
  }

  std::unique_ptr<Process> view_;
  std::string pin_;
};

TEST_F(PageFromTheDesk, StopsTheRobotWithoutALoginByEachOfItsNetworks) {
  ASSERT_NO_FATAL_FAILURE(Serve());
  for (const TestNet& net : {kEthernet, kWifi}) {
    EXPECT_EQ(Get(net.Address(1), "/").status, 200);
    ExpectTheStopWorks(net.Address(1));
  }
  EXPECT_THAT(robot_->Run({"history"}).out, HasSubstr("a person without a login (10.77.2.2)"));
  ExpectNothingWasLost();
}

// `curl -X POST` without a body was refused.
TEST_F(PageFromTheDesk, StopsTheRobotWhateverTheBodyOfTheRequestIs) {
  ASSERT_NO_FATAL_FAILURE(Serve());
  for (const char* body : {"", "null", "smoke", "[]", R"({"reason":7,"machine":null})"}) {
    const Answer stop = Post(kWifi.Address(1), "/api/estop", body);
    EXPECT_EQ(stop.status, 200) << body << ": " << stop.body;
    EXPECT_TRUE(IsStopped()) << body;
    ASSERT_EQ(robot_->Run({"estop", "--release"}).exit, 0);
  }
}

TEST_F(PageFromTheDesk, LooksAndActsWithALoginOnly) {
  ASSERT_NO_FATAL_FAILURE(Serve());
  const std::string robot = kWifi.Address(1);
  ExpectActingNeedsALogin(robot, 401);
  for (const char* path : {"/api/history", "/api/topics", "/api/log?actuator=legs", "/metrics",
                           "/camera?topic=/front", "/api/tree?name=x", "/api/behavior?name=x"}) {
    EXPECT_EQ(Get(robot, path).status, 401) << path;
  }
  EXPECT_EQ(Post(robot, "/api/plan", R"({"target":"LowPower"})").status, 401);
  EXPECT_EQ(Post(robot, "/api/login", R"({"pin":"000000"})").cookie, "");
  const Answer login = Post(robot, "/api/login", R"({"pin":")" + pin_ + R"("})");
  ASSERT_EQ(login.status, 200) << login.body;
  const std::vector<std::string> person = {"Cookie: " + login.cookie};
  EXPECT_EQ(Request(*desk_, "GET", robot, "/api/history", "", person).status, 200);
  EXPECT_EQ(Post(robot, "/api/estop", "{}", person).status, 200);
  EXPECT_TRUE(IsStopped());
  EXPECT_EQ(Post(robot, "/api/release", "{}", person).status, 200);
  EXPECT_FALSE(IsStopped());
  const Answer set = Post(robot, "/api/set", R"({"target":"LowPower"})", person);
  EXPECT_EQ(set.status, 200) << set.body;
  const nlohmann::json status = robot_->Status();
  EXPECT_EQ(status["state"], "LowPower");
  const std::string requester = status["requested_by"];
  EXPECT_THAT(requester, EndsWith(" on the page"));
  EXPECT_THAT(robot_->Run({"history"}).out,
              HasSubstr("switch to LowPower requested by " + requester));
}

// The page at the desk, of a person who knows which network is left. By all of them DDS chooses the
// lost one.
TEST_F(PageFromTheDesk, IsServedThereByTheOneNetworkThatIsLeft) {
  for (const auto& [left, lost] : {std::pair(kWifi, kEthernet), std::pair(kEthernet, kWifi)}) {
    SCOPED_TRACE(std::string(lost.robot) + " is down");
    Down(lost);
    const char* port = left.robot == kWifi.robot ? kPort : kProxyPort;  // both run to the end
    Process view(desk_->Here(
        {BinDir() + "/musher-view", "--no-link", "--port", port, "--interface", left.Desk()}));
    ASSERT_NE(view.LineWith("The page is at"), "");
    const auto at_desk = [&](const std::string& path, const std::string& body) {
      return Request(*desk_, "POST", "127.0.0.1", path, body, {}, port).status;
    };
    EXPECT_TRUE(Until([&] { return at_desk("/api/plan", R"({"target":"LowPower"})") == 200; },
                      kReachedWithin));
    EXPECT_EQ(at_desk("/api/estop", R"({"reason":"smoke"})"), 200);
    EXPECT_TRUE(IsStopped());
    ASSERT_EQ(robot_->Run({"estop", "--release"}).exit, 0);
    ASSERT_EQ(robot_->Run({"set", "Active"}).exit, 0);
    Up(lost);
  }
}

TEST_F(PageFromTheDesk, AProgramInPythonReachesTheRobotByTheOneNetworkThatIsLeft) {
  setenv("PYTHONPATH", (BinDir() + "/../python").c_str(), 1);
  const bool has_package = RunToEnd({"python3", "-c", "import musher"}).exit == 0;
  if (!has_package) unsetenv("PYTHONPATH");
  if (!has_package) GTEST_SKIP() << "this build has no Python package";
  for (const auto& [left, lost] : {std::pair(kWifi, kEthernet), std::pair(kEthernet, kWifi)}) {
    SCOPED_TRACE(std::string(lost.robot) + " is down");
    Down(lost);
    const Ended program = desk_->Do(
        {"python3", "-c",
         "import musher\n"
         "with musher.Machine(interface='" +
             left.Desk() +
             "') as robot:\n"
             "    print(robot.status().state, len(robot.estop('smoke', timeout_s=60)))\n"});
    EXPECT_EQ(program.out, "Active 3\n") << program.err;
    EXPECT_TRUE(IsStopped());
    ASSERT_EQ(robot_->Run({"estop", "--release"}).exit, 0);
    ASSERT_EQ(robot_->Run({"set", "Active"}).exit, 0);
    Up(lost);
  }
  unsetenv("PYTHONPATH");
}

// A browser sends the Origin of the page that a person has open.
TEST_F(PageFromTheDesk, DoesNotStopTheRobotForAPageOfAnotherSite) {
  ASSERT_NO_FATAL_FAILURE(Serve());
  const std::string robot = kEthernet.Address(1);
  for (const std::string header : {"Origin: http://evil.example", "Sec-Fetch-Site: cross-site",
                                   "Host: evil.example", "Origin: null"}) {
    const Answer refused = Post(robot, "/api/estop", "{}", {header});
    EXPECT_EQ(refused.status, 403) << header << refused.body;
  }
  EXPECT_FALSE(IsStopped());
  EXPECT_EQ(Post(robot, "/api/estop", "{}", {"Origin: http://" + robot + ":" + kPort}).status, 200);
  EXPECT_TRUE(IsStopped());
}

TEST_F(PageFromTheDesk, StopsTheRobotWithALoginOnlyWhereTheConfigWantsThat) {
  ASSERT_NO_FATAL_FAILURE(Serve({"--stop-needs-login"}));
  EXPECT_EQ(Post(kWifi.Address(1), "/api/estop").status, 401);
  EXPECT_EQ(Request(*robot_, "POST", "127.0.0.1", "/api/estop", "{}").status, 403);
  EXPECT_FALSE(IsStopped());
}

// Such a proxy makes looking public, as the page's documentation says; nothing more.
TEST_F(PageFromTheDesk, BehindAProxyThatNamesNoClientStopsTheRobotAndActsWithALoginOnly) {
  ASSERT_NO_FATAL_FAILURE(Serve());
  Process proxy(robot_->Here({"python3", SourceDir() + "/test/integration/network/plain_proxy.py",
                              kProxyPort, std::string("127.0.0.1:") + kPort}));
  ASSERT_EQ(proxy.LineWith("ready"), "ready");
  const std::string robot = kWifi.Address(1);
  const auto by_proxy = [&](const std::string& path, const std::vector<std::string>& more = {}) {
    return Request(*desk_, "POST", robot, path, "{}", more, kProxyPort);
  };
  ExpectActingNeedsALogin(robot, 403, kProxyPort);
  EXPECT_EQ(Request(*desk_, "GET", robot, "/api/history", "", {}, kProxyPort).status, 200);
  // Each proxy that says so.
  for (const std::string header : {"X-Forwarded-For: 10.77.2.2", "X-Real-IP: 10.77.2.2",
                                   "Forwarded: for=10.77.2.2", "Via: 1.1 proxy"}) {
    EXPECT_EQ(Request(*desk_, "GET", robot, "/api/history", "", {header}, kProxyPort).status, 401)
        << header;
  }
  // One that does not pass the upgrade to a WebSocket on.
  const Answer live = Request(*desk_, "GET", robot, "/live", "", {}, kProxyPort);
  EXPECT_EQ(live.status, 426);
  EXPECT_THAT(live.body, HasSubstr("Upgrade and Connection"));
  const Answer stop = by_proxy("/api/estop");
  EXPECT_EQ(stop.status, 200) << stop.body;
  EXPECT_TRUE(IsStopped());
  EXPECT_EQ(by_proxy("/api/release").status, 403);
  EXPECT_TRUE(IsStopped());
}

}  // namespace musher::testing::page_test
