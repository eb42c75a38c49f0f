#include "musher/modules/world/simulation/field_report.hpp"

#include <algorithm>
#include <cstdio>

namespace musher::world {
namespace {

std::string FieldWord(const std::string& text) {
  std::string quoted = "\"";
  for (const char letter : text) {
    if (letter == '"' || letter == '\\') quoted += '\\';
    if (static_cast<unsigned char>(letter) >= 0x20) quoted += letter;
  }
  return quoted + '"';
}

template <class... Values>
std::string FieldFormat(const char* format, Values... values) {
  char text[400];
  std::snprintf(text, sizeof(text), format, values...);
  return text;
}

std::string HeightsJson(const WheelHeights& heights_mm) {
  return FieldFormat("[%.1f,%.1f,%.1f,%.1f]", heights_mm[0], heights_mm[1], heights_mm[2],
                     heights_mm[3]);
}

std::string PoseJson(const Field& field) {
  const LiftBody& robot = field.robot();
  const FieldCell cell = field.spec().CellOf(robot.position_m());
  std::string text = FieldFormat(R"("pose":{"x_m":%.3f,"y_m":%.3f,"yaw_rad":%.4f},"cell":)",
                                 robot.position_m().x(), robot.position_m().y(), robot.yaw_rad());
  text += field.spec().Has(cell) ? FieldFormat("[%d,%d]", cell.row, cell.col) : "null";
  text += FieldFormat(R"(,"platform_mm":%.0f,"height_mm":%.1f,"wheels_mm":)",
                      field.spec().HeightMm(cell), robot.height_mm());
  text += HeightsJson(robot.wheels_mm()) + R"(,"targets_mm":)" + HeightsJson(robot.targets_mm());
  return text;
}

std::string ToolJson(const Tool& tool) {
  return FieldFormat(R"({"command":%d,"busy":%s,"done":%s,"result":)", tool.command,
                     tool.busy ? "true" : "false", tool.done ? "true" : "false") +
         FieldWord(tool.result) + "}";
}

std::string BoxesJson(const Field& field) {
  std::string text;
  for (std::size_t i = 0; i < field.boxes().size(); ++i) {
    const KfsSpec& spec = field.spec().boxes[i];
    text += std::string(i > 0 ? "," : "") + R"({"name":)" + FieldWord(spec.name) + R"(,"kind":")" +
            NameOf(spec.kind) +
            FieldFormat(R"(","cell":[%d,%d],"where":"%s"})", spec.cell.row, spec.cell.col,
                        NameOf(field.boxes()[i].where));
  }
  return text;
}

std::string EventsJson(const Field& field) {
  constexpr std::array<const char*, 8> kNames{"up",     "down",  "taken", "placed",
                                              "docked", "ready", "bump",  "fall"};
  std::string text;
  for (const FieldEvent& event : field.events()) {
    text += std::string(text.empty() ? "" : ",") +
            FieldFormat(R"({"at_s":%.2f,"what":"%s","x_m":%.2f,"y_m":%.2f,"text":)",
                        ToSeconds(event.at), kNames.at(static_cast<std::size_t>(event.kind)),
                        event.where_m.x(), event.where_m.y()) +
            FieldWord(event.text) + "}";
  }
  return text;
}

}  // namespace

std::string FieldJson(const World& world) {
  if (!world.field()) return "{}";
  const Field& field = *world.field();
  const LiftBody& robot = field.robot();
  const auto placed = [&](KfsBox::Where where) {
    return std::count_if(field.boxes().begin(), field.boxes().end(),
                         [where](const KfsBox& box) { return box.where == where; });
  };
  return R"({"name":)" + FieldWord(world.scene().name) + R"(,"side":)" +
         FieldWord(field.spec().side) + FieldFormat(R"(,"time_s":%.2f,)", ToSeconds(world.now())) +
         PoseJson(field) +
         FieldFormat(R"(,"waits":%s,"fallen":%s,"fall":)", robot.waits() ? "true" : "false",
                     robot.fallen() ? "true" : "false") +
         FieldWord(robot.fall()) +
         FieldFormat(R"(,"bumps":%d,"falls":%d,"arm":)", robot.bumps(), robot.falls()) +
         ToolJson(field.arm()) + R"(,"spear":)" + ToolJson(field.spear()) +
         FieldFormat(R"(,"r1_ready":%s,"placed_mid":%ld,"placed_high":%ld,"boxes":[)",
                     field.partner_ready() ? "true" : "false",
                     static_cast<long>(placed(KfsBox::Where::kMid)),
                     static_cast<long>(placed(KfsBox::Where::kHigh))) +
         BoxesJson(field) + R"(],"events":[)" + EventsJson(field) + "]}";
}

}  // namespace musher::world
