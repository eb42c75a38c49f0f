#include "musher/modules/camera/tool/collector.hpp"

#include <algorithm>
#include <utility>

#include "musher/messages/stamp.hpp"
#include "musher/modules/camera/tool/commands.hpp"

namespace musher::camera::tool {

Collector::Collector(const StripOptions& options)
    : options_(options), pace_(1 / options.every_s), caption_(Seconds(options.every_s).count()) {}

void Collector::Take(std::size_t camera, msg::Image picture) {
  if (done()) return;
  const std::int64_t stamp_ns = msg::FromStamp(picture.header.stamp).count();
  const bool due = camera == 0 && Due(stamp_ns);
  if (due && begun_) Finish();
  if (done() || (!due && (!begun_ || begun_->pictures[camera]))) return;
  auto tile = TileOf(std::move(picture), static_cast<std::uint32_t>(options_.width_px));
  if (!tile) {
    unreadable_ = tile.error();
    return;
  }
  if (due) Begin(stamp_ns);
  begun_->pictures[camera] = std::move(tile).value();
  if (begun_->Complete()) Finish();
}

bool Collector::NeedsPictures() const {
  return !done() && (!options_.on_demand || begun_ || caption_.pending());
}

std::vector<StripTile> Collector::Tiles() const {
  std::vector<StripTile> tiles = tiles_;
  if (begun_) tiles.push_back({SideBySide(begun_->pictures), begun_->label});
  return tiles;
}

bool Collector::Begun::Complete() const {
  return std::all_of(pictures.begin(), pictures.end(),
                     [](const auto& picture) { return picture.has_value(); });
}

bool Collector::Due(std::int64_t stamp_ns) {
  return options_.changes.empty() ? pace_.Due(stamp_ns) : caption_.Due(stamp_ns);
}

void Collector::Begin(std::int64_t stamp_ns) {
  if (!first_ns_) first_ns_ = stamp_ns;
  std::string label = LabelOf(stamp_ns, *first_ns_);
  if (!caption_.text().empty()) label += "  " + caption_.text();
  begun_ =
      Begun{std::vector<std::optional<msg::Image>>(1 + options_.beside.size()), std::move(label)};
}

void Collector::Finish() {
  tiles_.push_back({SideBySide(begun_->pictures), std::move(begun_->label)});
  begun_.reset();
}

}  // namespace musher::camera::tool
