#include "musher/modules/motion/motion_config.hpp"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <numbers>
#include <utility>

#include "musher/base/toml/document.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/base/toml/names.hpp"
#include "musher/base/toml/rows.hpp"
#include "musher/transport/lcm_packet.hpp"

namespace musher::motion {
namespace {

namespace row = config_toml::row;
using config_toml::Findings;
using config_toml::Rows;
using config_toml::Table;
using config_toml::TableReader;

constexpr std::int64_t kFarthestPriority =
    100;  // that of an idle body: every source may control it

constexpr std::array<std::pair<const char*, std::int32_t>, 6> kSources = {
    {{"debug", kFromDebug},
     {"app", kFromApp},
     {"audio", kFromAudio},
     {"vis", kFromVision},
     {"blutele", kFromBluetooth},
     {"algo", kFromAlgorithm}}};

// The priorities of all sources.
Rows PriorityRows(Priorities& priorities) {
  Rows rows;
  for (const auto& [name, source] : kSources) {
    rows.emplace_back([&priorities, name = name, source = source](TableReader& reader) {
      const auto value = reader.Integer(name, -kFarthestPriority, kFarthestPriority);
      if (value) priorities[source] = static_cast<std::int32_t>(*value);
    });
  }
  return rows;
}

// An LCM url, with the reader's position where it is wrong.
config_toml::Row UrlRow(const char* key, std::string& url) {
  return [key, &url](TableReader& reader) {
    row::Text(key, url)(reader);
    const auto parsed = transport::ReadLcmUrl(url);
    if (!parsed) reader.Fault(reader.At(key), key, parsed.error().message);
  };
}

// An IPv4 address; "": any.
config_toml::Row AddressRow(const char* key, std::string& address) {
  return [key, &address](TableReader& reader) {
    row::Text(key, address)(reader);
    in_addr parsed{};
    if (address.empty() || inet_pton(AF_INET, address.c_str(), &parsed) == 1) return;
    reader.Fault(reader.At(key), key, "expected an IPv4 address, such as \"192.168.44.233\"");
  };
}

Rows BoardRows(MotionConfig& config) {
  constexpr int kMostTtl = 255;
  LcmConfig& lcm = config.lcm;
  return {
      row::Choice("kind", config.board, {{"topic", BoardKind::kTopic}, {"lcm", BoardKind::kLcm}}),
      UrlRow("command_url", lcm.command_url),
      UrlRow("response_url", lcm.response_url),
      UrlRow("localization_url", lcm.localization_url),
      row::Text("interface", lcm.network_interface),
      AddressRow("board", lcm.board),
      row::Integer("ttl", lcm.ttl, 0, kMostTtl),
      row::Time("wait_ms", config.board_wait),
      row::Time("silent_ms", config.board_silent),
      row::Time("feedback_ms", config.board_feedback)};
}

// A name of a frame.
config_toml::Row FrameRow(const char* key, std::string& frame) {
  return [key, &frame](TableReader& reader) {
    row::Text(key, frame)(reader);
    if (frame.empty() && reader.Has(key))
      reader.Fault(reader.At(key), key, "expected the name of a frame");
  };
}

// Whether `frame` is fixed on `on`, by the mounts of `config`, which form no cycle.
bool IsFixedOn(const TfConfig& config, std::string frame, const std::string& on) {
  while (frame != on) {
    const auto mount = std::ranges::find(config.mounts, frame, &Mount::frame);
    if (mount == config.mounts.end()) return false;
    frame = mount->parent;
  }
  return true;
}

// [[tf.mount]]. A frame has one place, and no frame is fixed on itself, also not by others.
void ReadMounts(TableReader& tf, TfConfig& config) {
  constexpr double kFarthestM = 10;
  constexpr double kHalfTurnDeg = 180;
  for (TableReader& reader : tf.Subs("mount")) {
    Mount mount;
    mount.parent = config.base;
    std::array<double, 3>& xyz = mount.xyz_m;
    std::array<double, 3> rpy_deg{};
    ReadRows(reader,
             {row::Required("frame", "the name of a frame, such as \"laser_link\"",
                            FrameRow("frame", mount.frame)),
              FrameRow("parent", mount.parent),
              row::Numbers("xyz_m", {&xyz[0], &xyz[1], &xyz[2]}, -kFarthestM, kFarthestM,
                           "expected [x, y, z] in metres"),
              row::Numbers("rpy_deg", {&rpy_deg[0], &rpy_deg[1], &rpy_deg[2]}, -kHalfTurnDeg,
                           kHalfTurnDeg, "expected [roll, pitch, yaw] in degrees")});
    for (std::size_t i = 0; i < rpy_deg.size(); ++i) {
      mount.rpy_rad.at(i) = rpy_deg.at(i) * std::numbers::pi / kHalfTurnDeg;
    }
    const bool placed = mount.frame == mount.parent || mount.frame == config.base ||
                        mount.frame == config.odom ||
                        std::ranges::count(config.mounts, mount.frame, &Mount::frame) > 0;
    if (mount.frame.empty()) continue;  // reported by its row
    if (placed) {
      reader.Fault(reader.At("frame"), "frame", "'" + mount.frame + "' has another place already");
    } else if (IsFixedOn(config, mount.parent, mount.frame)) {
      reader.Fault(reader.At("parent"), "parent",
                   "'" + mount.parent + "' is fixed on '" + mount.frame + "': a cycle of frames");
    } else {
      config.mounts.push_back(std::move(mount));
    }
  }
}

Rows TfRows(TfConfig& config) {
  return {row::Bool("publish", config.publish), FrameRow("odom", config.odom),
          FrameRow("base", config.base),
          row::Check(
              "base", [&config] { return config.base != config.odom; },
              "it is the frame of the odometry, too"),
          [&config](TableReader& reader) { ReadMounts(reader, config); }};
}

MotionConfig Read(const Table& table, const std::string& path, Findings& findings) {
  MotionConfig config;
  const std::filesystem::path folder = config_toml::FolderOf(path);
  config.motions = config_toml::Absolute(folder, "motions.toml");
  config.gaits = config_toml::Absolute(folder, "gaits");
  TableReader root(table, {1, 1}, "", findings);
  ReadRows(root,
           {row::File("motions", config.motions, folder), row::File("gaits", config.gaits, folder),
            row::Sub("priority", PriorityRows(config.priorities)),
            row::Sub("board", BoardRows(config)), row::Sub("tf", TfRows(config.tf))});
  return config;
}

}  // namespace

std::optional<std::string> WarningOfClock(const MotionConfig& config, ClockSource clock) {
  if (config.board != BoardKind::kLcm || clock != ClockSource::kTopic) return std::nullopt;
  if (config.lcm.ttl == 0 || config.lcm.network_interface == "lo") return std::nullopt;
  return "[board] kind is \"lcm\" and [controller] clock is \"topic\": while /clock stands still, "
         "no "
         "watchdog of the motion manager runs; set clock = \"steady\" for a robot, or ttl = 0 for "
         "a "
         "simulated body";
}

Parsed<MotionConfig> ReadMotionConfigText(std::string_view text, const std::string& path) {
  return config_toml::ReadTextWith<Parsed<MotionConfig>>(
      text, path,
      [&](const Table& root, Findings& findings) { return Read(root, path, findings); });
}

Parsed<MotionConfig> ReadMotionConfigFile(const std::string& path) {
  return config_toml::ReadFileWith(path, ReadMotionConfigText);
}

}  // namespace musher::motion
