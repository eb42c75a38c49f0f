// musher-camera strip: the pictures of cameras over time, side by side.

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "musher/base/decimal.hpp"
#include "musher/messages/std_msgs/string.hpp"
#include "musher/modules/camera/tool/collector.hpp"
#include "musher/modules/camera/tool/commands.hpp"
#include "musher/modules/camera/tool/strip_picture.hpp"

namespace musher::camera::tool {
namespace {

constexpr int kMostColumns = 8;

// The subscriptions of a strip, and when to give up.
class Film {
 public:
  Film(program::ToolLink& link, const StripOptions& options)
      : link_(link), options_(options), collector_(options), topics_{options.topic} {
    topics_.insert(topics_.end(), options.beside.begin(), options.beside.end());
  }

  // Until it is done, interrupted, or nothing comes any more.
  Result<> Run() {
    if (Result<> open = SubscribeToTexts(); !open) return open;
    while (!collector_.done() && !Silent() && !link_.interrupted()) {
      if (Result<> open = OpenOrClose(); !open) return open;
      link_.RunUntil([&] { return collector_.NeedsPictures() == pictures_.empty(); },
                     Milliseconds(200));
    }
    return Ok();
  }

  const Collector& collector() const { return collector_; }

  // Why there is no picture.
  Error Nothing(const ToolOptions& global) const {
    if (collector_.unreadable()) return *collector_.unreadable();
    if (!pictures_.empty()) {
      return NothingCame(*pictures_.front(), options_.topic, global, options_.timeout_s);
    }
    return {kCodeTimeout,
            "no text on " + options_.changes + " within " + Decimal(options_.timeout_s, 1) + " s"};
  }

 private:
  Result<> SubscribeToTexts() {
    if (options_.changes.empty()) return Ok();
    auto texts = transport::MakeSubscription<msg::String>(
        link_.node(), link_.Name(options_.changes),
        [this](const msg::String& text, const auto&) { collector_.OnText(text.data); });
    if (!texts) return texts.error();
    texts_ = std::move(texts).value();
    return Ok();
  }

  Result<> OpenOrClose() {
    if (!collector_.NeedsPictures()) {
      pictures_.clear();
      return Ok();
    }
    if (!pictures_.empty()) return Ok();
    alive_at_ = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < topics_.size(); ++i) {
      auto pictures =
          SubscribeToPictures(link_, topics_[i], [this, i](msg::Image&& picture, const auto&) {
            alive_at_ = std::chrono::steady_clock::now();
            collector_.Take(i, std::move(picture));
          });
      if (!pictures) return pictures.error();
      pictures_.push_back(std::move(pictures).value());
    }
    return Ok();
  }

  // While no pictures are needed, the publisher of the texts has to be there.
  bool Silent() {
    const Time now = std::chrono::steady_clock::now();
    if (pictures_.empty() && texts_ && texts_->MatchedWriters() > 0) alive_at_ = now;
    return now > alive_at_ + Seconds(options_.timeout_s);
  }

  program::ToolLink& link_;
  const StripOptions options_;
  Collector collector_;
  std::vector<std::string> topics_;
  Time alive_at_ = std::chrono::steady_clock::now();
  std::unique_ptr<transport::Subscription> texts_;
  std::vector<std::unique_ptr<transport::Subscription>> pictures_;
};

int ColumnsOf(const StripOptions& options) {
  if (options.columns > 0) return options.columns;
  return std::max(1, kMostColumns / static_cast<int>(1 + options.beside.size()));
}

}  // namespace

ExitCode Run(const ToolOptions& global, const StripOptions& options) {
  const auto opened = program::ToolLink::Open(global);
  if (!opened) return Fail(ExitCode::kUsage, opened.error());
  program::ToolLink& link = *opened.value();
  Film film(link, options);
  if (Result<> run = film.Run(); !run) return Fail(ExitCode::kUsage, run.error());
  const std::vector<StripTile> tiles = film.collector().Tiles();
  if (tiles.empty()) {
    if (link.interrupted()) {
      return Fail(ExitCode::kInterrupted, {kCodeFailed, "interrupted before the first picture"});
    }
    return Fail(ExitCode::kNotDone, film.Nothing(global));
  }
  if (Result<> saved = Save(DrawStrip(tiles, ColumnsOf(options)), options.file); !saved) {
    return Fail(ExitCode::kNotDone, saved.error());
  }
  if (global.json) {
    nlohmann::json json = {{"file", options.file}, {"topic", options.topic}};
    for (const StripTile& tile : tiles) json["times"].push_back(tile.label);
    std::cout << json.dump(2) << std::endl;
  } else {
    std::cout << options.file << ": " << tiles.size() << " of " << options.count << " pictures of "
              << options.topic << std::endl;
  }
  return ExitCode::kDone;
}

}  // namespace musher::camera::tool
