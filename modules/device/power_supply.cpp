#include "musher/modules/device/power_supply.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <system_error>
#include <vector>

#include "musher/base/files.hpp"

namespace musher::device {
namespace {

namespace fs = std::filesystem;
using msg::BatteryState;

constexpr double kMicro = 1e-6;
constexpr double kTenth = 0.1;
constexpr double kPercent = 100;

std::string Text(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  return line;
}

// NaN if the file is missing or empty.
double Number(const fs::path& file) {
  std::istringstream text(Text(file));
  double value = kNotMeasured;
  return text >> value ? value : kNotMeasured;
}

double Ratio(const fs::path& supply, const std::string& part, const std::string& whole) {
  const double all = Number(supply / whole);
  return all > 0 ? kPercent * Number(supply / part) / all : kNotMeasured;
}

double FirstMeasured(double a, double b, double c = kNotMeasured) {
  return !std::isnan(a) ? a : !std::isnan(b) ? b : c;
}

std::uint8_t Status(const std::string& text) {
  if (text == "Charging") return BatteryState::kStatusCharging;
  if (text == "Discharging") return BatteryState::kStatusDischarging;
  if (text == "Not charging") return BatteryState::kStatusNotCharging;
  if (text == "Full") return BatteryState::kStatusFull;
  return BatteryState::kStatusUnknown;
}

std::uint8_t Health(const std::string& text) {
  if (text == "Good") return BatteryState::kHealthGood;
  if (text == "Overheat" || text == "Hot") return BatteryState::kHealthOverheat;
  if (text == "Dead") return BatteryState::kHealthDead;
  if (text == "Over voltage") return BatteryState::kHealthOvervoltage;
  if (text == "Unspecified failure") return BatteryState::kHealthUnspecFailure;
  if (text == "Cold") return BatteryState::kHealthCold;
  return BatteryState::kHealthUnknown;
}

// Drivers disagree about the sign: the status determines the direction.
double Current(const fs::path& supply, double voltage_v, std::uint8_t status) {
  double current = kMicro * Number(supply / "current_now");
  if (std::isnan(current)) current = kMicro * Number(supply / "power_now") / voltage_v;
  if (!std::isfinite(current)) return kNotMeasured;
  current = std::abs(current);
  return status == BatteryState::kStatusDischarging ? -current : current;
}

bool FeedsThisHost(const fs::path& supply) {
  return Text(supply / "type") == "Battery" && Text(supply / "scope") != "Device";
}

bool IsOtherPowerOn(const fs::path& supply) {
  return Text(supply / "type") != "Battery" && Number(supply / "online") >= 1;
}

Error NoBattery(const std::string& message) {
  return {BmsCode(KeyCode::kDeviceError), message};
}

}  // namespace

Result<BatteryReading> ReadHostBattery(const std::string& folder, const std::string& name) {
  std::error_code error;
  std::vector<fs::path> supplies = EntriesOf(folder, error);
  std::sort(supplies.begin(), supplies.end());
  if (error) return NoBattery(folder + " cannot be read: " + error.message());
  fs::path supply;
  bool external_power = false;
  for (const fs::path& candidate : supplies) {
    const bool wanted = name.empty() ? FeedsThisHost(candidate) : candidate.filename() == name;
    if (wanted && supply.empty()) supply = candidate;
    external_power = external_power || IsOtherPowerOn(candidate);
  }
  if (supply.empty()) {
    return NoBattery(folder + " has no " + (name.empty() ? "battery" : "supply '" + name + "'"));
  }

  BatteryReading reading;
  reading.external_power = external_power;
  reading.present = Number(supply / "present") != 0;  // a battery without this file is present
  reading.status = Status(Text(supply / "status"));
  reading.health = Health(Text(supply / "health"));
  reading.percent =
      FirstMeasured(Number(supply / "capacity"), Ratio(supply, "energy_now", "energy_full"),
                    Ratio(supply, "charge_now", "charge_full"));
  reading.voltage_v = kMicro * Number(supply / "voltage_now");
  reading.current_a = Current(supply, reading.voltage_v, reading.status);
  reading.temperature_c = kTenth * Number(supply / "temp");
  reading.health_percent = FirstMeasured(Ratio(supply, "energy_full", "energy_full_design"),
                                         Ratio(supply, "charge_full", "charge_full_design"));
  if (const double cycles = Number(supply / "cycle_count"); cycles >= 0) {
    reading.cycles = static_cast<int>(std::min(cycles, 30'000.0));
  }
  return reading;
}

}  // namespace musher::device
