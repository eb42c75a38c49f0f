// musher-camera strip: a camera's pictures over time, side by side.

#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/messages/stamp.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/camera/pace.hpp"
#include "musher/modules/camera/tool/caption.hpp"
#include "musher/modules/camera/tool/commands.hpp"
#include "musher/modules/camera/tool/strip_picture.hpp"

namespace musher::camera::tool {
namespace {

constexpr int kMostColumns = 8;

// Takes a picture when it is due, by the pictures' own stamps.
class Collector {
 public:
  explicit Collector(const StripOptions& options)
      : options_(options), pace_(1 / options.every_s), caption_(Seconds(options.every_s).count()) {}

  void OnText(const std::string& text) { caption_.OnText(text); }

  void Take(msg::Image picture) {
    last_picture_at_ = std::chrono::steady_clock::now();
    const std::int64_t stamp_ns = msg::FromStamp(picture.header.stamp).count();
    if (done() || !Due(stamp_ns)) return;
    auto tile = TileOf(std::move(picture), static_cast<std::uint32_t>(options_.width_px));
    if (!tile) {
      unreadable_ = tile.error();
      return;
    }
    if (tiles_.empty()) first_ns_ = stamp_ns;
    std::string label = LabelOf(stamp_ns, first_ns_);
    if (!caption_.text().empty()) label += "  " + caption_.text();
    tiles_.push_back({std::move(tile).value(), std::move(label)});
  }

  bool done() const { return static_cast<int>(tiles_.size()) >= options_.count; }
  bool Silent() const {
    return std::chrono::steady_clock::now() > last_picture_at_ + Seconds(options_.timeout_s);
  }
  const std::vector<StripTile>& tiles() const { return tiles_; }
  const std::optional<Error>& unreadable() const { return unreadable_; }

 private:
  bool Due(std::int64_t stamp_ns) {
    return options_.changes.empty() ? pace_.Due(stamp_ns) : caption_.Due(stamp_ns);
  }

  const StripOptions options_;
  Pace pace_;
  Caption caption_;
  std::int64_t first_ns_ = 0;
  Time last_picture_at_ = std::chrono::steady_clock::now();
  std::vector<StripTile> tiles_;
  std::optional<Error> unreadable_;
};

// Null without a topic.
Result<std::unique_ptr<transport::Subscription>> SubscribeToTexts(program::ToolLink& link,
                                                                  const std::string& topic,
                                                                  Collector& collector) {
  if (topic.empty()) return std::unique_ptr<transport::Subscription>();
  return transport::MakeSubscription<msg::String>(
      link.node(), link.Name(topic),
      [&collector](const msg::String& text, const auto&) { collector.OnText(text.data); });
}

}  // namespace

ExitCode Run(const ToolOptions& global, const StripOptions& options) {
  const auto opened = program::ToolLink::Open(global);
  if (!opened) return Fail(ExitCode::kUsage, opened.error());
  program::ToolLink& link = *opened.value();
  Collector collector(options);
  const auto subscription = SubscribeToPictures(
      link, options.topic,
      [&](msg::Image&& picture, const auto&) { collector.Take(std::move(picture)); });
  if (!subscription) return Fail(ExitCode::kUsage, subscription.error());
  const auto texts = SubscribeToTexts(link, options.changes, collector);
  if (!texts) return Fail(ExitCode::kUsage, texts.error());
  while (!collector.done() && !collector.Silent() && !link.interrupted()) {
    link.RunUntil([&] { return collector.done(); }, Milliseconds(200));
  }
  if (collector.tiles().empty()) {
    if (link.interrupted()) {
      return Fail(ExitCode::kInterrupted, {kCodeFailed, "interrupted before the first picture"});
    }
    if (collector.unreadable()) return Fail(ExitCode::kNotDone, *collector.unreadable());
    return Fail(ExitCode::kNotDone,
                NothingCame(*subscription.value(), options.topic, global, options.timeout_s));
  }
  const int columns = options.columns > 0 ? options.columns : kMostColumns;
  if (Result<> saved = Save(DrawStrip(collector.tiles(), columns), options.file); !saved) {
    return Fail(ExitCode::kNotDone, saved.error());
  }
  if (global.json) {
    nlohmann::json json = {{"file", options.file}, {"topic", options.topic}};
    for (const StripTile& tile : collector.tiles()) json["times"].push_back(tile.label);
    std::cout << json.dump(2) << std::endl;
  } else {
    std::cout << options.file << ": " << collector.tiles().size() << " of " << options.count
              << " pictures of " << options.topic << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::camera::tool
