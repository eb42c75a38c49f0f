#include "musher/modules/world/picture/strip_chart.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "musher/modules/world/paint/palette.hpp"
#include "musher/modules/world/picture/marks.hpp"

namespace musher::world {
namespace {

constexpr double kBandHeight = 28;
constexpr double kGap = 14;
constexpr double kSmall = 12;  // letters
constexpr double kTiny = 11;

double TimeMarkEvery(double range_s) {
  return MarkEvery(
      range_s, 12,
      {0.5, 1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 21'600, 86'400});
}

class Chart {
 public:
  Chart(const Track& track, const Pixel& corner, const Pixel& opposite, Canvas& canvas)
      : track_(track),
        samples_(track.samples()),
        canvas_(canvas),
        left_(corner.x() + kChartNames),
        right_(opposite.x()),
        end_s_(std::max(1.0, ToSeconds(samples_.back().at))) {}

  void Battery(double top, double bottom) {
    const auto y = [&](double percent) { return bottom + (top - bottom) * percent / 100; };
    canvas_.FillRect({left_, top}, {right_, bottom}, kGround);
    ForRuns(IsCharging, [&](const Sample& first, double from, double to) {
      if (first.charging) canvas_.FillRect({from, top}, {to, bottom}, kPad);
    });
    BatteryGrid(y);
    TimeGrid(top, bottom);
    ForRuns(IsCharging, [&](const Sample& first, double from, double to) {
      if (!first.charging || canvas_.TextWidth("charging", kTiny) + 8 > to - from) return;
      canvas_.Text("charging", {from + 6, top + 14}, kTiny, kPadEdge);
    });
    BatteryLine(track_, kBatteryLine, y);
    Names(top, bottom);
  }

  // Of several robots; the chart's own track only has its time.
  void Batteries(const World& world, double top, double bottom) {
    const auto y = [&](double percent) { return bottom + (top - bottom) * percent / 100; };
    canvas_.FillRect({left_, top}, {right_, bottom}, kGround);
    BatteryGrid(y);
    TimeGrid(top, bottom);
    for (std::size_t i = 0; i < world.scene().robots.size(); ++i) {
      BatteryLine(world.fleet().robots()[i].track, world.scene().robots[i].color, y);
    }
    Names(top, bottom);
  }

  void Band(const std::string& row, double top, const std::vector<std::string>& names,
            const std::function<int(const Sample&)>& index,
            const std::function<Color(const std::string&)>& color) {
    const double bottom = top + kBandHeight;
    ForRuns(index, [&](const Sample& first, double from, double to) {
      const std::string& name = names.at(static_cast<std::size_t>(index(first)));
      const Color fill = color(name);
      const std::string word = name.empty() ? "unknown" : name;
      canvas_.FillRect({from, top}, {std::max(to, from + 1), bottom}, fill);
      if (canvas_.TextWidth(word, kSmall) + 8 < to - from) {
        canvas_.Text(word, {(from + to) / 2, bottom - 10}, kSmall, InkOn(fill), Align::kCenter);
      }
    });
    Name(row, bottom - 10);
  }

  // A line through all rows at each mark, with its words beside it above the chart.
  void MarkMoments(double top, double bottom) {
    for (const Mark& mark : track_.marks()) {
      const double x = X(mark.at);
      const bool fits = x + canvas_.TextWidth(mark.text, kTiny) + 6 < right_;
      canvas_.Line({x, top - 14}, {x, bottom}, kMarkInk, 1.5);
      canvas_.Text(mark.text, {fits ? x + 5 : x - 5, top - 5}, kTiny, kMarkInk,
                   fits ? Align::kLeft : Align::kRight);
    }
  }

  void TimeAxis(double y) {
    for (const double s : Marks(0, end_s_, TimeMarkEvery(end_s_))) {
      canvas_.Line({Xs(s), y}, {Xs(s), y + 5}, kGreyInk);
      canvas_.Text(ClockText(s), {Xs(s), y + 19}, kTiny, kGreyInk, Align::kCenter);
    }
    canvas_.Line({left_, y}, {right_, y}, kGreyInk);
    canvas_.Text("min:s", {left_ - 22, y + 19}, kTiny, kGreyInk, Align::kRight);
  }

 private:
  void BatteryGrid(const std::function<double(double)>& y) {
    for (const int percent : {0, 20, 40, 60, 80, 100}) {
      canvas_.Line({left_, y(percent)}, {right_, y(percent)}, kGrid);
      if (percent % 20 == 0) {
        canvas_.Text(std::to_string(percent), {left_ - 8, y(percent) + 4}, kTiny, kGreyInk,
                     Align::kRight);
      }
    }
  }

  void BatteryLine(const Track& track, const Color& color, const std::function<double(double)>& y) {
    std::vector<Pixel> line;
    for (const Sample& sample : track.samples()) {
      const Pixel point(X(sample.at), y(sample.battery_percent));
      if (line.size() > 1 && point.x() - line[line.size() - 2].x() < 0.3 &&
          std::abs(point.y() - line.back().y()) < 0.3) {
        line.back() = point;  // more than can be seen
      } else {
        line.push_back(point);
      }
    }
    canvas_.Polyline(line, color, 2);
  }

  void Names(double top, double bottom) {
    Name("battery", (top + bottom) / 2 - 4);
    Name("%", (top + bottom) / 2 + 12);
  }

  double Xs(double seconds) const { return left_ + (right_ - left_) * seconds / end_s_; }
  double X(Duration at) const { return Xs(ToSeconds(at)); }

  void Name(const std::string& name, double y) {
    canvas_.Text(name, {left_ - 38, y}, kSmall, kInk, Align::kRight);
  }

  void TimeGrid(double top, double bottom) {
    for (const double s : Marks(0, end_s_, TimeMarkEvery(end_s_))) {
      canvas_.Line({Xs(s), top}, {Xs(s), bottom}, kGrid);
    }
  }

  static int IsCharging(const Sample& sample) { return sample.charging ? 1 : 0; }

  // Calls `draw` for each longest run of samples with the same index.
  void ForRuns(const std::function<int(const Sample&)>& index,
               const std::function<void(const Sample&, double from, double to)>& draw) {
    for (std::size_t i = 0; i < samples_.size();) {
      std::size_t next = i + 1;
      while (next < samples_.size() && index(samples_[next]) == index(samples_[i])) ++next;
      const Duration end = next < samples_.size() ? samples_[next].at : samples_.back().at;
      draw(samples_[i], X(samples_[i].at), X(end));
      i = next;
    }
  }

  const Track& track_;
  const std::vector<Sample>& samples_;
  Canvas& canvas_;
  double left_;
  double right_;
  double end_s_;
};

}  // namespace

std::string ClockText(double seconds) {
  const auto whole = static_cast<long>(std::floor(seconds));
  const long minutes = whole / 60;
  char text[48];
  if (seconds == std::floor(seconds)) {
    std::snprintf(text, sizeof(text), "%ld:%02ld", minutes, whole % 60);
  } else {
    std::snprintf(text, sizeof(text), "%ld:%04.1f", minutes,
                  seconds - static_cast<double>(minutes * 60));
  }
  return text;
}

void DrawStripChart(const Track& track, const Pixel& corner, const Pixel& opposite,
                    Canvas& canvas) {
  constexpr double kAxis = 26;
  Chart chart(track, corner, opposite, canvas);
  const double bands = 2 * (kBandHeight + kGap);
  const double bottom = opposite.y() - kAxis - bands;
  chart.Battery(corner.y(), bottom);
  const double machine = bottom + kGap;
  chart.Band(
      "machine", machine, track.states(), [](const Sample& s) { return s.machine_state; },
      ColorOfState);
  const double motion = machine + kBandHeight + kGap;
  chart.Band(
      "motion", motion, track.motions(), [](const Sample& s) { return s.motion; }, ColorOfMotion);
  chart.MarkMoments(corner.y(), motion + kBandHeight);
  chart.TimeAxis(motion + kBandHeight + 6);
}

void DrawBatteryChart(const World& world, const Pixel& corner, const Pixel& opposite,
                      Canvas& canvas) {
  constexpr double kAxis = 26;
  Chart chart(world.fleet().robots().front().track, corner, opposite, canvas);
  const double bottom = opposite.y() - kAxis;
  chart.Batteries(world, corner.y(), bottom);
  chart.TimeAxis(bottom + 6);
}

}  // namespace musher::world
