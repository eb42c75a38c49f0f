#include "musher/modules/line_walker/walker_topics.hpp"

#include <cstdio>
#include <utility>

#include "musher/cyberdog/codes/module_codes.hpp"
#include "musher/messages/stamp.hpp"

namespace musher::line_walker {
namespace {

constexpr Duration kFramePeriod = Milliseconds(50);
constexpr Duration kStatusPeriod = Milliseconds(100);
constexpr Duration kBreakPeriod = Milliseconds(500);  // of the steady clock
constexpr Duration kLongestAlone = Milliseconds(1000);
constexpr Duration kLatestHeartbeat = Milliseconds(1500);
constexpr Duration kQuiet = std::chrono::seconds(2);  // between warnings of one kind
constexpr std::size_t kLongestWord = 40;              // of a refused command, in the log

Error Failed(const std::string& what) {
  return {MakeCode(cyberdog::module_code::kFollow, KeyCode::kSelfCheckFailed), what};
}

// Printable and short: the word comes from outside.
std::string Quoted(const std::string& word) {
  std::string quoted = "\"";
  for (const char letter : word.substr(0, kLongestWord)) {
    const bool plain = letter >= ' ' && letter <= '~' && letter != '"';
    quoted += plain ? letter : '?';
  }
  return quoted + (word.size() > kLongestWord ? "…\"" : "\"");
}

std::string SecondsText(Duration time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", ToSeconds(time));
  return text;
}

}  // namespace

WalkerTopics::WalkerTopics(const Dependencies& dependencies, WalkerConfig config)
    : dependencies_(dependencies),
      config_(std::move(config)),
      warnings_([this](const std::string& line) { Log(LogLevel::kWarning, line); }, kQuiet),
      walker_(config_.walk),
      breaks_(dependencies.node.loop()),
      endpoints_(dependencies.node, dependencies.name_space) {}

Result<std::unique_ptr<WalkerTopics>> WalkerTopics::Make(const Dependencies& dependencies,
                                                         const WalkerConfig& config) {
  std::unique_ptr<WalkerTopics> topics(new WalkerTopics(dependencies, config));
  if (Result<> opened = topics->Open(); !opened) return opened.error();
  return topics;
}

Result<> WalkerTopics::Open() {
  const TopicNames& names = config_.topics;
  transport::Clock& clock = dependencies_.clock;
  status_ = endpoints_.Advertise<msg::String>(names.status);
  servo_ = endpoints_.Advertise<msg::MotionServoCmd>(names.servo, transport::kSystemDefaultQos);
  endpoints_.Subscribe<msg::MotionServoResponse>(
      names.servo_response, [this, &clock](const msg::MotionServoResponse& response) {
        walker_.OnResponse(response, clock.Now());
      });
  endpoints_.Subscribe<msg::Odometry>(
      names.odometry,
      [this, &clock](const msg::Odometry& odometry) {
        const msg::Stamp& stamp = odometry.header.stamp;
        const Duration age = msg::FromStamp(clock.Stamp()) - msg::FromStamp(stamp);
        walker_.OnOdometry(odometry, clock.Now(), stamp == msg::Stamp{} ? Duration(0) : age);
      },
      transport::kSensorDataQos);
  command_ = endpoints_.Subscribe<msg::String>(
      names.command, [this](const msg::String& word) { OnCommand(word.data); });
  if (!endpoints_.opened()) return endpoints_.opened();
  status_timer_ = clock.Every(kStatusPeriod, [this] { PublishStatus(); });
  break_checks_ = dependencies_.node.loop().Every(kBreakPeriod, [this] { CheckBreak(); });
  return Ok();
}

// Also where no tick comes, as the machine's clock stands.
void WalkerTopics::CheckBreak() {
  StopAfterBreak();
  if (ticks_ && !walker_.active()) Tick();
}

void WalkerTopics::StopAfterBreak() {
  const auto could_not_run = breaks_.Take();
  if (!could_not_run) return;
  walker_.Stop(dependencies_.clock.Now(),
               "this process could not run for " + SecondsText(*could_not_run));
  walker_.ForgetLane();
}

void WalkerTopics::OnCommand(const std::string& word) {
  if (word == "START") return OnStart();
  if (word == "STOP") {
    if (walker_.active()) EndWalk("STOP");
    return;
  }
  if (word == "HEARTBEAT") {
    if (walker_.active()) heartbeat_at_ = dependencies_.clock.Now();
    return;
  }
  warnings_.Log("word", "unknown command " + Quoted(word) + " refused: expected START or STOP",
                dependencies_.clock.Now());
}

void WalkerTopics::OnStart() {
  const Time now = dependencies_.clock.Now();
  if (!permitted_) return warnings_.Log("state", "START refused: " + not_permitted_, now);
  if (walker_.active()) return warnings_.Log("twice", "START ignored: it walks already", now);
  if (const auto could_not_run = breaks_.Recent()) {
    return warnings_.Log("late",
                         "START refused: this process could not run for " +
                             SecondsText(*could_not_run) + ", and the command may be as old",
                         now);
  }
  if (!lines_) {
    if (const Result<> opened = Subscribe(); !opened) {
      return warnings_.Log("lines", "START refused: " + opened.error().message, now);
    }
  }
  walker_.Start(now);
  alone_since_.reset();
  heartbeat_at_.reset();
  ticks_ = dependencies_.clock.Every(kFramePeriod, [this] { Tick(); });
  Log(LogLevel::kInfo, "START: walking in the lane");
  PublishStatus();
}

void WalkerTopics::EndWalk(const std::string& why) {
  if (!walker_.active()) return;
  walker_.Stop(dependencies_.clock.Now(), why);
  Tick();
}

void WalkerTopics::Permit(bool permitted, const std::string& why) {
  permitted_ = permitted;
  if (permitted) return;
  not_permitted_ = why;
  EndWalk(why);
}

transport::Subscription* WalkerTopics::SubscribeTo(const std::string& topic, View view) {
  return lines_->endpoints.SubscribeEach<msg::YellowLines>(
      topic,
      [this, topic, view](const msg::YellowLines& lines, transport::EndpointId publisher) {
        OnLines(topic, view, lines, publisher);
      },
      [](transport::EndpointId) {}, transport::kSensorDataQos);
}

// The next tick concludes a walk that ends here: its subscriptions are not closed in their handler.
void WalkerTopics::OnLines(const std::string& topic, View view, const msg::YellowLines& lines,
                           transport::EndpointId publisher) {
  const Time now = dependencies_.clock.Now();
  if (lines_->publishers.at(std::size_t(view)).Note(publisher)) {
    return walker_.Stop(now, "two publishers of " + topic + " take turns; end one of them");
  }
  walker_.OnLines(view, lines, now);
}

Result<> WalkerTopics::Subscribe() {
  lines_ = std::make_unique<Lines>(dependencies_);
  lines_->left = SubscribeTo(config_.topics.left, View::kLeft);
  lines_->right = SubscribeTo(config_.topics.right, View::kRight);
  lines_->front = SubscribeTo(config_.topics.front, View::kFront);
  Result<> opened = lines_->endpoints.opened();
  if (!opened) lines_.reset();
  return opened;
}

void WalkerTopics::StopIfAlone() {
  const Time now = dependencies_.clock.Now();
  if (heartbeat_at_ && now - *heartbeat_at_ >= kLatestHeartbeat) {
    walker_.Stop(now, "no heartbeat of its commander for " + SecondsText(kLatestHeartbeat));
  } else if (command_->MatchedWriters() > 0) {
    alone_since_.reset();
  } else if (!alone_since_) {
    alone_since_ = now;
  } else if (now - *alone_since_ >= kLongestAlone) {
    walker_.Stop(now, "its commander is lost");
  }
}

void WalkerTopics::Tick() {
  StopAfterBreak();
  if (walker_.active()) StopIfAlone();
  if (const auto step = walker_.Tick(dependencies_.clock.Now())) Publish(*step);
  if (!walker_.active()) Conclude();
}

void WalkerTopics::Conclude() {
  ticks_.reset();
  if (!checked_) lines_.reset();
  const End end = walker_.end().value_or(End::kStopped);
  const bool fine = end == End::kCourseEnd || end == End::kStopped;
  Log(fine ? LogLevel::kInfo : LogLevel::kWarning,
      "the walk has ended after " + SecondsText(walker_.Runtime(dependencies_.clock.Now())) + ", " +
          std::string(NameOf(end)) + ": " + walker_.reason());
  PublishStatus();
}

void WalkerTopics::Publish(const LineWalker::Step& step) {
  msg::MotionServoCmd frame;
  frame.motion_id = msg::MotionId::kWalkUserTrot;
  frame.cmd_type = step.end ? msg::MotionServoCmd::kEnd : msg::MotionServoCmd::kData;
  frame.cmd_source = msg::MotionSource::kAlgo;
  frame.vel_des = {static_cast<float>(step.velocity.forward_m_s),
                   static_cast<float>(step.velocity.left_m_s),
                   static_cast<float>(step.velocity.yaw_rad_s)};
  const auto height = static_cast<float>(config_.step_height_m);
  frame.step_height = {height, height};
  static_cast<void>(servo_->Publish(frame));  // without frames the motion manager stops the body
}

void WalkerTopics::PublishStatus() {
  const Time now = dependencies_.clock.Now();
  warnings_.Tick(now);
  static_cast<void>(status_->Publish({walker_.StatusText(now)}));
}

Result<> WalkerTopics::SetChecked(bool checked) {
  checked_ = checked;
  if (checked && !lines_) return Subscribe();
  if (!checked && !walker_.active()) lines_.reset();
  return Ok();
}

Result<> WalkerTopics::Check() const {
  const TopicNames& names = config_.topics;
  std::string faults;
  const auto add = [&faults](const std::string& fault) {
    faults += (faults.empty() ? "" : ", ") + fault;
  };
  const auto need_one = [&](const transport::Subscription* lines, const std::string& topic) {
    const int publishers = lines == nullptr ? 0 : lines->MatchedWriters();
    if (publishers == 0) add("no publisher of " + topic);
    if (publishers > 1) add("more than one publisher of " + topic);
  };
  if (servo_->MatchedReaders() == 0) add("no subscriber of " + names.servo);
  need_one(lines_ ? lines_->left : nullptr, names.left);
  need_one(lines_ ? lines_->right : nullptr, names.right);
  need_one(lines_ ? lines_->front : nullptr, names.front);
  return faults.empty() ? Ok() : Result<>(Failed(faults));
}

}  // namespace musher::line_walker
