#include "musher/modules/skills/robot/saved_flight.hpp"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "musher/base/toml/file.hpp"
#include "musher/base/toml/parsed.hpp"
#include "musher/base/toml/table_reader.hpp"

namespace musher::skills {
namespace {

using config_toml::TableReader;

constexpr Duration kWrittenEach = std::chrono::seconds(1);
constexpr double kFarthestM = 1e6;

struct Place {
  HostTime written;
  navigation::Point at;
};

Place ReadPlace(const config_toml::Table& table, config_toml::Findings& findings) {
  TableReader root(table, {1, 1}, "", findings);
  for (const char* key : {"written_host", "written_ns", "x_m", "y_m", "z_m"}) {
    root.Require(key, "what Save() has written");
  }
  Place place;
  if (const auto host = root.String("written_host")) place.written.host = host->text;
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  place.written.since_boot = Duration(root.Integer("written_ns", 0, kMost).value_or(0));
  place.at = {root.Number("x_m", -kFarthestM, kFarthestM).value_or(0),
              root.Number("y_m", -kFarthestM, kFarthestM).value_or(0),
              root.Number("z_m", -kFarthestM, kFarthestM).value_or(0)};
  return place;
}

}  // namespace

std::optional<navigation::Point> SavedFlight::Found() const {
  if (file_.empty()) return std::nullopt;
  const Result<std::string> text = config_toml::ReadModuleText(file_);
  if (!text) return std::nullopt;
  const auto read = config_toml::ReadTextWith<Parsed<Place>>(text.value(), file_, ReadPlace);
  if (!read.config) return std::nullopt;
  const HostTime now = host_now_();
  const Duration age = now.since_boot - read.config->written.since_boot;
  const bool counts = !now.host.empty() && read.config->written.host == now.host &&
                      age >= Duration{} && age <= kMostAge;
  return counts ? std::optional(read.config->at) : std::nullopt;
}

Result<> SavedFlight::Save(const std::optional<navigation::Point>& place) {
  if (file_.empty()) return Ok();
  if (!place) {
    if (!std::exchange(removed_, true)) saved_.Remove();
    written_at_.reset();
    return Ok();
  }
  const HostTime now = host_now_();
  if (written_at_ && now.since_boot - *written_at_ < kWrittenEach) return Ok();
  written_at_ = now.since_boot;
  removed_ = false;
  const Result<> written = saved_.Replace(
      fmt::format("written_host = \"{}\"\nwritten_ns = {}\nx_m = {:.3f}\ny_m = {:.3f}\n"
                  "z_m = {:.3f}\n",
                  now.host, now.since_boot.count(), place->x_m, place->y_m, place->z_m));
  const std::string fault = written ? "" : written.error().message;
  if (std::exchange(fault_, fault) == fault || written) return Ok();
  return Error{kCodeFailed, "where it is in the air is not saved: " + fault};
}

}  // namespace musher::skills
