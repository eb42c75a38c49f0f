#include "musher/modules/navigation/server/mask_source.hpp"

#include <utility>

#include "musher/base/toml/names.hpp"
#include "musher/modules/navigation/messages/conversions.hpp"

namespace musher::navigation {

MaskSource::MaskSource(transport::Endpoints& endpoints, const std::string& info_topic,
                       std::string name_space, std::string frame, Handlers handlers)
    : node_(endpoints.node()),
      name_space_(std::move(name_space)),
      frame_(std::move(frame)),
      handlers_(std::move(handlers)) {
  endpoints.Subscribe<msg::CostmapFilterInfo>(
      info_topic, [this](const msg::CostmapFilterInfo& info) { OnInfo(info); },
      transport::kLatchedQos);
}

void MaskSource::OnInfo(const msg::CostmapFilterInfo& info) {
  if (!config_toml::IsTopic(info.filter_mask_topic)) {
    return handlers_.on_refusal("filter info: filter_mask_topic is not the name of a topic");
  }
  const bool same = mask_ && info.filter_mask_topic == info_.filter_mask_topic;
  info_ = info;
  if (same) {
    if (grid_) OnGrid(*grid_);
    return;
  }
  mask_.reset();
  grid_.reset();
  auto subscription = transport::MakeSubscription<msg::OccupancyGrid>(
      node_, transport::ResolveName(name_space_, info.filter_mask_topic),
      [this](const msg::OccupancyGrid& grid, const transport::SampleInfo&) {
        grid_ = std::make_shared<const msg::OccupancyGrid>(grid);
        OnGrid(grid);
      },
      transport::kLatchedQos);
  if (!subscription) return handlers_.on_refusal(subscription.error().message);
  mask_ = std::move(subscription).value();
}

void MaskSource::OnGrid(const msg::OccupancyGrid& grid) {
  auto values = ToGrid(grid, frame_);
  if (!values) return handlers_.on_refusal(values.error().message);
  FilterMask mask{std::move(values).value(), info_.base, info_.multiplier};
  if (const auto checked = CheckFilterMask(mask); !checked) {
    return handlers_.on_refusal(checked.error().message);
  }
  handlers_.on_mask(info_.type, std::move(mask));
}

}  // namespace musher::navigation
