// musher-race course COURSE --lane 0.9: a course for the measures of another hall.

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "musher/actuator/program/module_main.hpp"
#include "musher/base/toml/file.hpp"
#include "musher/modules/race/course_for_hall.hpp"
#include "musher/modules/race/course_reader.hpp"
#include "musher/modules/race/tool/tool.hpp"

namespace musher::race::tool {
namespace {

struct Input {
  std::vector<std::string> files;  // HALL, where it is there, and COURSE
  std::array<std::optional<double>, kHallMeasures.size()> measures;  // by option
  std::string vision;
  std::string walker;
  std::string folder;  // empty: prints one of them
};

struct Output {
  std::string name;
  AdaptedFile file;
};

// "--bay-a-in" of bay_a_in_m.
std::string OptionOf(const HallMeasure& measure) {
  std::string option = "--" + std::string(measure.key.substr(0, measure.key.rfind('_')));
  for (char& c : option) {
    if (c == '_') c = '-';
  }
  return option;
}

void PrintFault(const std::string& file, const std::string& what) {
  program::PrintErrors({Diagnostic{file, 0, 0, Severity::kError, what}});
}

// Nothing after a message.
std::optional<std::string> TextOf(const std::string& file) {
  const Result<std::string> text = config_toml::ReadModuleText(file);
  if (text) return text.value();
  PrintFault(file, text.error().message);
  return std::nullopt;
}

// The measures of the file, and over them those of the options. Nothing after a message.
std::optional<Hall> ReadHall(const Input& input, const Hall& base) {
  std::optional<Hall> hall = base;
  if (input.files.size() == 2) {
    const HallReading read = ReadHallFile(input.files.front(), base);
    program::PrintErrors(read.diagnostics);
    hall = read.hall;
  }
  std::string options;
  for (std::size_t i = 0; i < kHallMeasures.size(); ++i) {
    const auto& measure = input.measures.at(i);
    if (measure)
      options += std::string(kHallMeasures.at(i).key) + " = " + MeasureText(*measure) + "\n";
  }
  if (!hall || options.empty()) return hall;
  const HallReading read = ReadHallText(options, "options", *hall);
  program::PrintErrors(read.diagnostics);
  return read.hall;
}

// Nothing after a message.
std::optional<std::vector<Output>> Adapt(const Input& input) {
  const std::string& course = input.files.back();
  const CourseReading base = ReadCourseFile(course);
  program::PrintErrors(base.diagnostics);
  if (!base.course) return std::nullopt;
  const auto hall = ReadHall(input, base.course->hall);
  if (!hall) return std::nullopt;
  std::vector<Output> outputs;
  const auto add = [&](const char* name, const std::string& file, const auto& adapt) {
    const auto text = TextOf(file);
    if (text) outputs.push_back({name, adapt(*text)});
    return text.has_value();
  };
  const bool one = input.folder.empty();
  const bool others = !input.vision.empty() || !input.walker.empty();
  if (!(one && others)) {
    if (!add("course.toml", course,
             [&](const std::string& text) { return CourseForHall(*hall, *base.course, text); }))
      return std::nullopt;
  }
  if (!input.vision.empty()) {
    if (!add("vision.toml", input.vision, [&](const std::string& text) {
          return VisionForHall(*hall, base.course->hall, text);
        }))
      return std::nullopt;
  }
  if (!input.walker.empty()) {
    if (!add("walker.toml", input.walker,
             [&](const std::string& text) { return WalkerForHall(*hall, text); }))
      return std::nullopt;
  }
  return outputs;
}

// What is there stays as it is: then nothing is written.
bool WriteAll(const std::filesystem::path& folder, const std::vector<Output>& outputs) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  for (const Output& output : outputs) {
    const std::filesystem::path file = folder / output.name;
    if (!std::filesystem::exists(file, error)) continue;
    PrintFault(file, "there is such a file already; give another folder");
    return false;
  }
  for (const Output& output : outputs) {
    const std::filesystem::path file = folder / output.name;
    std::ofstream stream(file);
    stream << output.file.text << std::flush;
    if (stream) continue;
    PrintFault(file, "cannot be written");
    return false;
  }
  return true;
}

int Write(const Input& input) {
  const auto outputs = Adapt(input);
  if (!outputs) return program::kUsageError;
  if (input.folder.empty()) {
    std::cout << outputs->front().file.text << std::flush;
  } else if (!WriteAll(input.folder, *outputs)) {
    return program::kUsageError;
  }
  bool whole = true;
  for (const Output& output : *outputs) {
    const std::string of = input.folder.empty() ? "" : output.name + ": ";
    for (const std::string& change : output.file.changes) std::cerr << of << change << "\n";
    for (const std::string& open : output.file.open) {
      std::cerr << of << "not derived: " << open << "\n";
      whole = false;
    }
  }
  std::cerr << std::flush;
  return whole ? 0 : 1;
}

}  // namespace

int WriteCourse(int argc, const char* const* argv) {
  CLI::App app("Prints a course for the measures of another hall.", "musher-race course");
  app.footer(
      "Only numbers change. What changes, and what the measures do not give, is on stderr.\n"
      "Exit codes: 0 printed; 1 printed, but something is to be set by hand; 2 errors, or usage.");
  Input input;
  app.add_option(
         "FILES", input.files,
         "[HALL] COURSE: the course that is changed, with the [hall] it is for; before it a file "
         "(TOML) of measures, keys of [hall]")
      ->required()
      ->expected(1, 2);
  for (std::size_t i = 0; i < kHallMeasures.size(); ++i) {
    app.add_option(OptionOf(kHallMeasures.at(i)), input.measures.at(i),
                   "Metres: " + std::string(kHallMeasures.at(i).what));
  }
  auto* vision = app.add_option("--vision", input.vision,
                                "Prints this config of the vision module instead, changed");
  auto* walker = app.add_option("--walker", input.walker,
                                "Prints this config of the line walker instead, changed");
  app.add_option(
      "--write", input.folder,
      "Writes course.toml to this folder, and vision.toml and walker.toml of those given");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : program::kUsageError;
  }
  if (input.folder.empty() && *vision && *walker) {
    std::cerr << "musher-race course: --vision and --walker print one of them; both with --write\n";
    return program::kUsageError;
  }
  return Write(input);
}

}  // namespace musher::race::tool
