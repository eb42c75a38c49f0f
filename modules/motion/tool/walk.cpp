// musher-motion walk: a square, closed loop on odometry.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/base/decimal.hpp"
#include "musher/messages/nav_msgs/odometry.hpp"
#include "musher/modules/motion/motion_wire.hpp"
#include "musher/modules/motion/tool/commands.hpp"
#include "musher/modules/motion/tool/odometry_watch.hpp"
#include "musher/modules/motion/tool/speed_stream.hpp"
#include "musher/modules/motion/tool/square_walk.hpp"

namespace musher::motion::tool {
namespace {

// The state of the walk and the decision on its next speed.
class Walker {
 public:
  Walker(SpeedStream& stream, const WalkOptions& options)
      : stream_(stream), options_(options), opened_(Now()) {}

  Result<> Listen() {
    auto odometry = transport::MakeSubscription<msg::Odometry>(
        stream_.link().node(), stream_.link().Name("odom_out"),
        [this](const msg::Odometry& message, const transport::SampleInfo&) {
          pose_ = PlanarPoseOf(FromWire(message.pose.pose));
          odometry_watch_.OnSample(Now());
        });
    if (!odometry) return odometry.error();
    odometry_ = std::move(odometry).value();
    return Ok();
  }

  std::optional<SpeedLimit> Next() {
    if (odometry_watch_.Missing(Now())) {
      return Fault("no odometry on " + stream_.link().Name("odom_out"));
    }
    if (!walk_) {
      if (Now() - opened_ > kStandingUp) return Fault("the body does not start walking");
      if (!stream_.moving() || !pose_) return SpeedLimit{};  // it stands up
      walk_.emplace(*pose_, options_.square_m, options_.speed);
      begun_ = Now();
    }
    if (odometry_watch_.Old(Now())) return SpeedLimit{};  // do not walk without odometry
    const SpeedLimit speed = walk_->Step(*pose_);
    if (walk_->done()) return std::nullopt;
    return speed;
  }

  const std::optional<Error>& fault() const { return fault_; }
  double seconds() const { return ToSeconds(Now() - begun_); }
  double gap_m() const { return walk_->Gap(*pose_); }

 private:
  Time Now() const { return stream_.link().clock().Now(); }
  std::nullopt_t Fault(const std::string& what) {
    fault_ = Error{kCodeNetError, what};
    return std::nullopt;
  }

  SpeedStream& stream_;
  const WalkOptions& options_;
  const Time opened_;
  Time begun_{};
  OdometryWatch odometry_watch_{opened_, kStandingUp};
  std::optional<PlanarPose> pose_;
  std::optional<SquareWalk> walk_;
  std::optional<Error> fault_;
  std::unique_ptr<transport::Subscription> odometry_;
};

}  // namespace

ExitCode Run(const GlobalOptions& global, const WalkOptions& options) {
  auto opened = SpeedStream::Open(global, kUserTrot, options.source);
  if (const auto* exit = std::get_if<ExitCode>(&opened)) return *exit;
  SpeedStream& stream = *std::get<std::unique_ptr<SpeedStream>>(opened);
  Walker walker(stream, options);
  if (const auto listening = walker.Listen(); !listening) {
    return Fail(ExitCode::kUsage, listening.error());
  }
  const std::chrono::duration<double> longest(20 * options.square_m / options.speed + 60);
  const auto exit = stream.Run([&] { return walker.Next(); },
                               std::chrono::duration_cast<Duration>(longest), "the walk");
  if (exit) return *exit;
  if (walker.fault()) return Fail(ExitCode::kNotDone, *walker.fault());
  if (global.json) {
    std::cout << nlohmann::json{{"side_m", options.square_m},
                                {"seconds", walker.seconds()},
                                {"gap_m", walker.gap_m()}}
                     .dump(2)
              << std::endl;
  } else {
    std::cout << "walked a square of " << Decimal(options.square_m, 2) << " m in "
              << Decimal(walker.seconds(), 1) << " s; ended " << Decimal(walker.gap_m(), 3)
              << " m from where it began, by its odometry" << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::motion::tool
