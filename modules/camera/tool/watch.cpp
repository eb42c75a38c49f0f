// musher-camera watch: rate, age and loss.

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/base/decimal.hpp"
#include "musher/modules/camera/tool/commands.hpp"
#include "musher/modules/camera/tool/picture_count.hpp"

namespace musher::camera::tool {
namespace {

void PrintLine(const PictureCount& seen) {
  std::cout << seen.shape() << "  " << Decimal(seen.RateHz(), 1) << " Hz  age p50 "
            << Decimal(seen.AgeMs(0.5), 2) << " ms, p99 " << Decimal(seen.AgeMs(0.99), 2)
            << " ms  lost " << seen.Lost() << " of " << seen.count() + seen.Lost() << std::endl;
}

}  // namespace

ExitCode Run(const ToolOptions& global, const WatchOptions& options) {
  const auto opened = program::ToolLink::Open(global);
  if (!opened) return Fail(ExitCode::kUsage, opened.error());
  program::ToolLink& link = *opened.value();
  if (!link.AwaitClock())
    return Fail(ExitCode::kNotDone, {kCodeNetError, "no publisher of /clock"});
  PictureCount all;
  PictureCount recent;
  const auto subscription =
      SubscribeToPictures(link, options.topic, [&](msg::Image&& picture, const auto&) {
        const Duration age = AgeOf(picture, link, global);
        const Time now = std::chrono::steady_clock::now();
        all.Add(picture, age, now);
        recent.Add(picture, age, now);
      });
  if (!subscription) return Fail(ExitCode::kUsage, subscription.error());
  if (!link.RunUntil([&] { return all.count() > 0; }, Seconds(options.timeout_s))) {
    if (link.interrupted()) return ExitCode::kInterrupted;
    return Fail(ExitCode::kNotDone,
                NothingCame(*subscription.value(), options.topic, global, options.timeout_s));
  }
  const Time begun = std::chrono::steady_clock::now();
  while (!link.interrupted()) {
    Duration step = std::chrono::seconds(1);
    if (options.seconds > 0) {
      const Time end = begun + Seconds(options.seconds);
      if (std::chrono::steady_clock::now() >= end) break;
      step = std::min<Duration>(step, end - std::chrono::steady_clock::now());
    }
    link.RunUntil([] { return false; }, step);
    if (!global.json) {
      recent.count() > 1 ? PrintLine(recent)
                         : static_cast<void>(std::cout << "no picture for a second" << std::endl);
    }
    recent = {};
  }
  if (global.json) {
    std::cout << nlohmann::json{{"topic", options.topic},
                                {"shape", all.shape()},
                                {"pictures", all.count()},
                                {"rate_hz", all.RateHz()},
                                {"age_p50_ms", all.AgeMs(0.5)},
                                {"age_p99_ms", all.AgeMs(0.99)},
                                {"lost", all.Lost()}}
                     .dump(2)
              << std::endl;
  } else {
    std::cout << "all: ";
    PrintLine(all);
  }
  return ExitCode::kDone;
}

}  // namespace musher::camera::tool
