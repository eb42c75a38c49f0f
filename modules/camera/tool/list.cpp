// musher-camera list: the topics with pictures.

#include <cmath>
#include <iomanip>
#include <iostream>
#include <list>
#include <nlohmann/json.hpp>

#include "musher/base/decimal.hpp"
#include "musher/modules/camera/tool/commands.hpp"
#include "musher/modules/camera/tool/picture_count.hpp"

namespace musher::camera::tool {
namespace {

const std::vector<std::string> kUsual = {"image_rgb", "image_left", "image_right", "image"};

struct Row {
  std::string topic;
  PictureCount seen;
  double age_ms = 0;  // of the last
  std::unique_ptr<transport::Subscription> subscription;
};

// Stamps of a simulated world are no time of day.
std::string AgeText(double age_ms) {
  constexpr double kOldestMs = 3'600'000;
  if (std::abs(age_ms) > kOldestMs) return "stamped by another clock; see --clock";
  return Decimal(age_ms, 1) + " ms";
}

void Print(const std::list<Row>& rows, const ToolOptions& global) {
  if (global.json) {
    nlohmann::json json = nlohmann::json::array();
    for (const Row& row : rows) {
      nlohmann::json entry = {{"topic", row.topic}, {"pictures", row.seen.count()}};
      if (row.seen.count() > 0) {
        entry["shape"] = row.seen.shape();
        entry["rate_hz"] = row.seen.RateHz();
        entry["age_ms"] = row.age_ms;
      }
      json.push_back(entry);
    }
    std::cout << json.dump(2) << std::endl;
    return;
  }
  std::cout << std::left << std::setw(24) << "TOPIC" << std::setw(18) << "PICTURE" << std::setw(10)
            << "RATE"
            << "AGE\n";
  for (const Row& row : rows) {
    std::cout << std::setw(24) << row.topic;
    if (row.seen.count() == 0) {
      std::cout << "no picture\n";
      continue;
    }
    std::cout << std::setw(18) << row.seen.shape() << std::setw(10)
              << Decimal(row.seen.RateHz(), 1) + " Hz" << AgeText(row.age_ms) << "\n";
  }
  std::cout << std::flush;
}

}  // namespace

ExitCode Run(const ToolOptions& global, const ListOptions& options) {
  const auto opened = program::ToolLink::Open(global);
  if (!opened) return Fail(ExitCode::kUsage, opened.error());
  program::ToolLink& link = *opened.value();
  if (!link.AwaitClock())
    return Fail(ExitCode::kNotDone, {kCodeNetError, "no publisher of /clock"});
  std::list<Row> rows;
  for (const std::string& topic : options.topics.empty() ? kUsual : options.topics) {
    Row& row = rows.emplace_back();
    row.topic = topic;
    auto subscription = SubscribeToPictures(link, topic, [&](msg::Image&& picture, const auto&) {
      const Duration age = AgeOf(picture, link, global);
      row.age_ms = std::chrono::duration<double, std::milli>(age).count();
      row.seen.Add(picture, age, std::chrono::steady_clock::now());
    });
    if (!subscription) return Fail(ExitCode::kUsage, subscription.error());
    row.subscription = std::move(subscription).value();
  }
  link.RunUntil([] { return false; }, link.discovery() + Seconds(options.seconds));
  // Omits a topic that has no publisher and was not requested.
  if (options.topics.empty()) {
    rows.remove_if([](const Row& row) { return row.subscription->MatchedWriters() == 0; });
  }
  if (rows.empty()) return Fail(ExitCode::kNotDone, link.NotFound("pictures are published"));
  Print(rows, global);
  return ExitCode::kDone;
}

}  // namespace musher::camera::tool
