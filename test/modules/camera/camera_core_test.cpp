// The decisions for one camera, in virtual time.

#include "musher/modules/camera/camera_core.hpp"

#include <gmock/gmock.h>

#include "musher/modules/camera/self_check.hpp"

namespace musher::camera::camera_core_test {

using ::testing::HasSubstr;

constexpr Duration kSilence = Milliseconds(1000);
constexpr Duration kRetry = Milliseconds(500);

Time At(std::int64_t ms) {
  return Time{} + Milliseconds(ms);
}
FrameFacts Frame(std::int64_t ms, std::uint32_t width = 640, std::uint32_t height = 480) {
  return {ms * 1'000'000, width, height};
}
CameraCore Core(SourceKind source, double rate_hz = 0) {
  CameraConfig camera;
  camera.name = "front";
  camera.from = "somewhere";
  camera.source = source;
  camera.rate_hz = rate_hz;
  return {camera, kSilence, kRetry};
}

TEST(CameraCore, OpensWhenWantedAndClosesWhenNot) {
  CameraCore core = Core(SourceKind::kWorld);
  EXPECT_FALSE(core.NextTick());
  EXPECT_TRUE(core.Want(true, At(0)).open);
  EXPECT_EQ(core.Want(true, At(1)), CameraActions{});
  EXPECT_TRUE(core.OnFrame(Frame(10), At(10)).publish);
  EXPECT_TRUE(core.has_given());
  EXPECT_TRUE(core.Want(false, At(20)).close);
  EXPECT_FALSE(core.has_given());
  EXPECT_EQ(core.OnFrame(Frame(30), At(30)), CameraActions{}) << "of a source that was closed";
}

TEST(CameraCore, LogsASilentTopicOnceAndThatItIsBack) {
  CameraCore core = Core(SourceKind::kWorld);
  static_cast<void>(core.Want(true, At(0)));
  EXPECT_EQ(core.NextTick(), At(1000));
  EXPECT_EQ(core.Tick(At(999)), CameraActions{});
  const CameraActions silent = core.Tick(At(1000));
  ASSERT_TRUE(silent.log);
  EXPECT_EQ(*silent.log, (LogLine{4407, "front: no picture for 1000 ms"}));
  EXPECT_FALSE(silent.close) << "a topic comes back by itself";
  EXPECT_EQ(core.Tick(At(5000)), CameraActions{});
  const CameraActions back = core.OnFrame(Frame(5001), At(5001));
  EXPECT_EQ(back.log, (LogLine{0, "front: receiving pictures again"}));
  EXPECT_TRUE(back.publish);
  EXPECT_FALSE(core.fault());
}

TEST(CameraCore, ReopensADeviceUntilItIsBackAndLogsItOnce) {
  CameraCore core = Core(SourceKind::kDevice);
  static_cast<void>(core.Want(true, At(0)));
  static_cast<void>(core.OnFrame(Frame(10), At(10)));
  const CameraActions gone = core.OnFailed({4412, "unplugged"}, At(100));
  EXPECT_EQ(gone.log, (LogLine{4412, "front: unplugged"}));
  EXPECT_TRUE(gone.close);
  EXPECT_EQ(core.NextTick(), At(600));
  EXPECT_FALSE(core.Tick(At(599)).open);
  EXPECT_TRUE(core.Tick(At(600)).open);
  const CameraActions again = core.OnFailed({4412, "no such device"}, At(601));
  EXPECT_FALSE(again.log);
  EXPECT_EQ(core.fault()->text, "front: no such device");
  EXPECT_TRUE(core.Tick(At(1101)).open);
  EXPECT_EQ(core.OnFrame(Frame(1200), At(1200)).log,
            (LogLine{0, "front: receiving pictures again"}));
}

TEST(CameraCore, ReopensASilentDeviceRepeatedly) {
  CameraCore core = Core(SourceKind::kDevice);
  static_cast<void>(core.Want(true, At(0)));
  const CameraActions silent = core.Tick(At(1000));
  EXPECT_TRUE(silent.log);
  EXPECT_TRUE(silent.close);
  EXPECT_TRUE(core.Tick(At(1500)).open);
  const CameraActions still = core.Tick(At(2500));
  EXPECT_FALSE(still.log);
  EXPECT_TRUE(still.close);
  EXPECT_TRUE(core.Tick(At(3000)).open);
}

TEST(CameraCore, DoesNotReopenASourceThatHasEnded) {
  CameraCore core = Core(SourceKind::kVideo);
  static_cast<void>(core.Want(true, At(0)));
  static_cast<void>(core.OnFrame(Frame(1), At(1)));
  const CameraActions over = core.OnEnded(At(10));
  EXPECT_EQ(over.log, (LogLine{0, "front: somewhere has ended"}));
  EXPECT_TRUE(over.close);
  EXPECT_FALSE(core.NextTick());
  EXPECT_TRUE(core.ended());
  static_cast<void>(core.Want(false, At(20)));
  EXPECT_TRUE(core.Want(true, At(30)).open) << "from its beginning";
}

TEST(CameraCore, ForgetsItsFaultWhenItIsSwitchedOff) {
  CameraCore core = Core(SourceKind::kDevice);
  static_cast<void>(core.Want(true, At(0)));
  static_cast<void>(core.OnFailed({4412, "unplugged"}, At(1)));
  EXPECT_FALSE(core.Want(false, At(2)).close) << "closed by the failure already";
  EXPECT_FALSE(core.NextTick());
  EXPECT_FALSE(core.fault());
  EXPECT_EQ(core.OnFailed({4412, "late"}, At(3)), CameraActions{});
}

TEST(CameraCore, LogsAnotherSizeThanAnnouncedOnce) {
  CameraCore core = Core(SourceKind::kWorld);
  static_cast<void>(core.Want(true, At(0)));
  core.OnAnnounced(640, 480);
  EXPECT_FALSE(core.OnFrame(Frame(1), At(1)).log);
  const CameraActions other = core.OnFrame(Frame(2, 320, 240), At(2));
  EXPECT_EQ(other.log, (LogLine{4410, "front: its pictures are 320x240, not 640x480"}));
  EXPECT_TRUE(other.publish);
  EXPECT_FALSE(core.OnFrame(Frame(3, 320, 240), At(3)).log);
  EXPECT_TRUE(core.OnFrame(Frame(4), At(4)).log);
}

int Published(CameraCore& core, std::int64_t period_ms, std::int64_t jitter_ms, int frames) {
  int published = 0;
  for (int i = 0; i < frames; ++i) {
    const std::int64_t ms = i * period_ms + (i % 2 == 0 ? jitter_ms : 0);
    if (core.OnFrame(Frame(ms), At(0)).publish) ++published;
  }
  return published;
}

TEST(CameraCore, PublishesAtItsRateByTheTimeOfTheShots) {
  for (const std::int64_t jitter_ms : {0, 3}) {
    CameraCore core = Core(SourceKind::kWorld, 10);
    static_cast<void>(core.Want(true, At(0)));
    EXPECT_NEAR(Published(core, 33, jitter_ms, 300), 99, 1) << jitter_ms;  // of 9.9 s
  }
  CameraCore slower = Core(SourceKind::kWorld, 30);
  static_cast<void>(slower.Want(true, At(0)));
  EXPECT_EQ(Published(slower, 100, 0, 50), 50) << "no more than there are";
}

TEST(CameraCore, ContinuesAtItsRateAfterTheWorldIsRestarted) {
  CameraCore core = Core(SourceKind::kWorld, 10);
  static_cast<void>(core.Want(true, At(0)));
  EXPECT_TRUE(core.OnFrame(Frame(100'000), At(0)).publish);
  EXPECT_TRUE(core.OnFrame(Frame(20), At(1)).publish);
  EXPECT_FALSE(core.OnFrame(Frame(60), At(2)).publish);
  EXPECT_TRUE(core.OnFrame(Frame(120), At(3)).publish);
}

TEST(CameraSelfCheck, FailsForACriticalCameraOnlyOrWhenAllFail) {
  const Result<> bad = Error{4409, "dark"};
  EXPECT_TRUE(EvaluateSelfCheck({{"front", {}}, {"left", bad}}, {"front"}).result);
  EXPECT_EQ(EvaluateSelfCheck({{"front", {}}, {"left", bad}}, {"front"}).failing,
            "left: dark, 4409");
  const auto critical = EvaluateSelfCheck({{"front", bad}, {"left", {}}}, {"front"});
  ASSERT_FALSE(critical.result);
  EXPECT_EQ(critical.result.error(), (Error{4409, "front (critical): dark, 4409"}));
  EXPECT_FALSE(EvaluateSelfCheck({{"front", bad}, {"left", bad}}, {}).result);
  EXPECT_TRUE(EvaluateSelfCheck({}, {}).result);
}

}  // namespace musher::camera::camera_core_test
