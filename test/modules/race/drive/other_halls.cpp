#include "musher/test/modules/race/drive/other_halls.hpp"

namespace musher::race::testing {
namespace {

HallCase Case(int number, double lane_m, double line_m, SCurve s, double slip, Flooring flooring,
              double kelvin, double share, const Route& route) {
  HallCase hall{number, route, {HallOf(lane_m, line_m), s, flooring, {kelvin, share}}};
  hall.route.slip = slip;
  return hall;
}

HallCase Driven(HallCase hall) {
  hall.ends = true;
  return hall;
}

Route RouteOf(std::uint64_t seed, const char* qr_a, const char* arrow, const char* qr_b) {
  return {seed, {{"qr_a", qr_a}, {"arrow", arrow}, {"qr_b", qr_b}}};
}

}  // namespace

const std::vector<HallCase>& Halls() {
  using enum Flooring;
  static const std::vector<HallCase> halls = {
      Driven(Case(1, 0.70, 0.03, {1.6, 50}, 0.00, kGrey, 6500, 1.0,
                  RouteOf(11, "A-1", "left", "B-1"))),
      Case(2, 0.70, 0.05, {1.4, 50}, 0.03, kOak, 3000, 0.6, RouteOf(12, "A-2", "right", "B-2")),
      Case(3, 0.75, 0.07, {2.0, 40}, 0.05, kTiles, 8000, 0.4, RouteOf(13, "A-1", "right", "B-1")),
      Case(4, 0.75, 0.04, {1.5, 45}, 0.10, kBlueMat, 6500, 0.15, RouteOf(14, "A-2", "left", "B-2")),
      Case(5, 0.80, 0.05, {1.8, 50}, 0.15, kWetSpots, 6500, 1.2, RouteOf(15, "A-1", "left", "B-2")),
      Case(6, 0.83, 0.03, {1.6, 60}, 0.08, kGrey, 3000, 0.3, RouteOf(16, "A-2", "right", "B-1")),
      Case(7, 0.83, 0.07, {1.4, 45}, 0.02, kOak, 6500, 1.2, RouteOf(17, "A-1", "right", "B-2")),
      Case(8, 0.87, 0.05, {2.2, 35}, 0.12, kTiles, 3000, 0.8, RouteOf(18, "A-2", "left", "B-1")),
      Case(9, 0.90, 0.04, {1.7, 50}, 0.05, kBlueMat, 8000, 1.0, RouteOf(19, "A-1", "left", "B-1")),
      Case(10, 0.93, 0.06, {1.9, 45}, 0.15, kWetSpots, 8000, 0.5,
           RouteOf(20, "A-2", "right", "B-2")),
      Case(11, 0.97, 0.05, {1.6, 55}, 0.07, kOak, 8000, 0.2, RouteOf(21, "A-1", "right", "B-1")),
      Case(12, 1.00, 0.07, {2.0, 50}, 0.10, kGrey, 6500, 0.15, RouteOf(22, "A-2", "left", "B-2")),
  };
  return halls;
}

}  // namespace musher::race::testing
